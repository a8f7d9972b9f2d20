#include "atlas/rect/quadtree_atlas.hpp"

#include <algorithm>
#include <cassert>

namespace tessera {

IdealTexels sumIdeal(const glsl::AtlasConfig& config, std::span<const std::uint32_t> patches,
                     std::span<const glsl::PatchMeasure> measures, std::span<const glsl::PatchState> states,
                     std::uint32_t epoch) {
  assert(patches.size() == measures.size());
  IdealTexels sum;
  const glsl::uint smallest = glsl::smallestTexels(config.range);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const glsl::uint texels = glsl::idealTexels(measures[i], config.constantBias, config.range);
    if (texels == smallest) {
      ++sum.least;
      continue;
    }
    sum.scalable += texels;
    if (states[patches[i]].epoch != epoch) sum.fresh += texels;
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
  glsl::PressureInput last{};
  last.failed = failures_ + reduced_ > 0;
  last.waiting = waiting_ > 0;
  last.room = static_cast<float>(allocator_.rootTexels());
  last.load = static_cast<float>(config_.width) * static_cast<float>(config_.height) - last.room;
  last.live = config_.merges != 0 ? static_cast<float>(allocator_.liveTexels()) : 0.0f;
  last.fresh = glsl::biasedTexels(static_cast<glsl::uint>(ideal.fresh),
                                  static_cast<glsl::uint>(ideal.fresh >> 32U), bias_);
  last.limits = bias_ > config_.lowestBias;
  pressure_ = glsl::stepPressure(pressure_, config_.pressure, last);
  if (pressure_.reset != 0) {
    ++epoch_;
    allocator_.reset();
  }
  bias_ = config_.biased == 0
              ? 0.0f
              : glsl::pressureBias(static_cast<glsl::uint>(ideal.scalable),
                                   static_cast<glsl::uint>(ideal.scalable >> 32U), ideal.least, config_.range,
                                   pressure_.target, config_.lowestBias);
  failures_ = reduced_ = waiting_ = made_ = freed_ = 0;
  ++number_;
  pending_.clear();
  asked_.fill(0);
  for (std::size_t i = 0; i < patches.size(); ++i) request(patches[i], measures[i]);
  for (const std::uint32_t patch : live_) {
    if (marks_[patch] == number_) continue;
    glsl::PatchState& state = states_[patch];
    if (state.epoch != epoch_) continue;
    if (glsl::levelWidth(state.level) > 0) {
      release(state);
      ++freed_;
    }
    state = {};
  }
  live_.assign(patches.begin(), patches.end());
  assign();
}

void QuadtreeAtlas::release(const glsl::PatchState& state) {
  const glsl::uvec2 at = glsl::unpackOrigin(state.origin);
  allocator_.release({at.x, at.y, glsl::levelWidth(state.level), glsl::levelHeight(state.level)});
}

/// Gives the patch a block of this level, if there is one; it must not hold one.
bool QuadtreeAtlas::take(glsl::PatchState& state, glsl::uint level) {
  const auto block = allocator_.allocate(glsl::levelWidth(level), glsl::levelHeight(level));
  if (!block) return false;
  state.origin = glsl::packOrigin(block->x, block->y);
  state.level = level;
  ++made_;
  return true;
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
    if (glsl::waitsForMemory(state.level, level)) {
      ++waiting_;
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
    glsl::uint level = state.level;
    if (take(state, level)) continue;
    state.level = 0;
    // As rect_assign.comp does.
    for (glsl::uint next = glsl::smallerLevel(level, config_.range); config_.merges != 0 && next != level;
         next = glsl::smallerLevel(level, config_.range)) {
      level = next;
      if (take(state, level | glsl::kLevelReduced)) break;
    }
    if (state.level == 0)
      ++failures_;
    else
      ++reduced_;
  }
}

}  // namespace tessera
