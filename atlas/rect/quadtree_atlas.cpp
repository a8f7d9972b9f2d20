#include "atlas/rect/quadtree_atlas.hpp"

#include <algorithm>
#include <cassert>

namespace tessera {

IdealTexels sumIdeal(const glsl::AtlasConfig& config, std::span<const glsl::PatchMeasure> measures) {
  IdealTexels sum;
  const glsl::uint smallest = glsl::smallestTexels(config.range);
  for (const glsl::PatchMeasure& measure : measures) {
    const glsl::uint texels = glsl::idealTexels(measure, config.constantBias, config.range);
    if (texels == smallest)
      ++sum.least;
    else
      sum.scalable += texels;
  }
  return sum;
}

QuadtreeAtlas::QuadtreeAtlas(const glsl::AtlasConfig& config)
    : config_(config),
      allocator_(config.width, config.height, config.superblockLog2),
      pressure_(glsl::pressureAtStart(config.pressure)),
      states_(config.patchInstances),
      marks_(config.patchInstances) {
  live_.reserve(config.patchInstances);
  pending_.reserve(config.patchInstances);
  sorted_.reserve(config.patchInstances);
}

void QuadtreeAtlas::frame(std::span<const std::uint32_t> patches,
                          std::span<const glsl::PatchMeasure> measures, const IdealTexels& ideal) {
  assert(patches.size() == measures.size());
  const float load = static_cast<float>(config_.width) * static_cast<float>(config_.height) -
                     static_cast<float>(allocator_.rootTexels());
  const float live = config_.merges != 0 ? static_cast<float>(allocator_.liveTexels()) : 0.0f;
  pressure_ = glsl::stepPressure(pressure_, config_.pressure, failures_ + reduced_ > 0, load, live,
                                 bias_ > config_.lowestBias, false, false);
  if (pressure_.reset != 0) {
    ++epoch_;
    allocator_.reset();
  }
  bias_ = config_.biased != 0
              ? glsl::pressureBias(
                    static_cast<glsl::uint>(ideal.scalable), static_cast<glsl::uint>(ideal.scalable >> 32U),
                    ideal.least * glsl::smallestTexels(config_.range), pressure_.target, config_.lowestBias)
              : 0.0f;
  failures_ = reduced_ = made_ = freed_ = 0;
  ++number_;
  pending_.clear();
  asked_.fill(0);
  for (std::size_t i = 0; i < patches.size(); ++i) request(patches[i], measures[i]);
  for (const std::uint32_t patch : live_) {
    if (marks_[patch] == number_) continue;
    glsl::PatchState& state = states_[patch];
    if (state.epoch != epoch_ || glsl::levelWidth(state.level) == 0) continue;
    release(state);
    state.level = 0;
    ++freed_;
  }
  live_.assign(patches.begin(), patches.end());
  assign();
}

void QuadtreeAtlas::release(glsl::PatchState& state) {
  const glsl::uvec2 at = glsl::unpackOrigin(state.origin);
  allocator_.release({at.x, at.y, glsl::levelWidth(state.level), glsl::levelHeight(state.level)});
}

void QuadtreeAtlas::request(std::uint32_t patch, const glsl::PatchMeasure& measure) {
  marks_[patch] = number_;
  glsl::PatchState& state = states_[patch];
  const bool known = state.epoch == epoch_;
  const glsl::uint level = glsl::selectLevel(measure, config_.constantBias, bias_, config_.range, state.level,
                                             known ? config_.hysteresis : -1.0f);
  const bool asks = glsl::levelWidth(level) > 0;
  if (known) {
    if ((state.level & glsl::kLevelSize) == (level & glsl::kLevelSize)) {
      state.level = level;
      return;
    }
    if (glsl::levelWidth(state.level) > 0) {
      release(state);
      freed_ += asks ? 0 : 1;
    }
  }
  state.level = level;
  state.epoch = epoch_;
  if (!asks) return;
  ++asked_[glsl::levelIndexOf(level)];
  pending_.push_back(patch);
}

void QuadtreeAtlas::assign() {
  // The largest first, so that small ones fill what those leave.
  std::uint32_t start = 0;
  for (glsl::uint l = glsl::kLevels; l-- > 0;) {
    const std::uint32_t count = asked_[l];
    asked_[l] = start;
    start += count;
  }
  sorted_.resize(pending_.size());
  for (const std::uint32_t patch : pending_)
    sorted_[asked_[glsl::levelIndexOf(states_[patch].level)]++] = patch;
  for (const std::uint32_t patch : sorted_) {
    glsl::PatchState& state = states_[patch];
    glsl::uint w = glsl::levelWidth(state.level);
    glsl::uint h = glsl::levelHeight(state.level);
    auto block = allocator_.allocate(w, h);
    if (!block && config_.merges != 0) {
      // As rect_assign.comp does: half the width and height is a better picture than a texel.
      while (!block && (w > 1 || h > 0)) {
        w = std::max(w - 1, 1u);
        h -= std::min(h, 1u);
        block = allocator_.allocate(w, h);
      }
      reduced_ += block ? 1 : 0;
      state.level = glsl::packLevel(w, h, glsl::levelTransposed(state.level));
    }
    if (block) {
      state.origin = glsl::packOrigin(block->x, block->y);
      ++made_;
    } else {
      state.level = 0;
      ++failures_;
    }
  }
}

}  // namespace tessera
