#include "atlas/rect/memory.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "atlas/single_rows.hpp"
#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

// The smallest S, as a share of the atlas: below this a cut would only blur the picture further.
constexpr float kSmallestTargetShare = 0.125f;

Result<void> checkRange(const char* name, float value, float low, float high) {
  if (value >= low && value <= high) return {};
  return fail("atlas memory: {} is {}, not in [{}, {}]", name, value, low, high);
}

Result<glsl::AtlasConfig> configFrom(const RectMemoryOptions& options, std::uint32_t patchInstances) {
  const int superblockLog2 =
      options.superblockLog2 == 0
          ? std::max(superblockLog2Of(options.width, options.height), std::min(options.smallestLog2, 10))
          : options.superblockLog2;
  if (superblockLog2 < 1 || superblockLog2 > static_cast<int>(glsl::kMaxBlockLog2))
    return fail("atlas memory: superblocks of 2^{} texels a side are not in [2^1, 2^{}]", superblockLog2,
                glsl::kMaxBlockLog2);
  const int size = 1 << superblockLog2;
  for (const int side : {options.width, options.height})
    if (side < size || side > 16384 || side % size != 0)
      return fail("atlas memory: a side of {} texels is not a multiple of the superblock's {} up to 16384",
                  side, size);
  const std::int64_t superblocks =
      (std::int64_t{options.width} >> superblockLog2) * (std::int64_t{options.height} >> superblockLog2);
  constexpr std::int64_t kMostSuperblocks = 65536;
  if (superblocks > kMostSuperblocks)
    return fail("atlas memory: {} superblocks of {} x {} texels are more than {}", superblocks, size, size,
                kMostSuperblocks);
  // A group count a dimension is at most 65535.
  if (patchInstances > 65535u * RECT_GROUP)
    return fail("atlas memory: {} patch instances are more than {}", patchInstances, 65535u * RECT_GROUP);
  for (const auto& checked :
       {checkRange("bias", options.bias, -16.0f, 16.0f),
        checkRange("targetShare", options.targetShare, 1e-6f, 1.0f),
        checkRange("targetLargest", options.targetLargest, options.targetShare, 1.0f),
        checkRange("softWater", options.softWater, 1e-6f, 1.0f),
        checkRange("targetCut", options.targetCut, 1e-6f, 1.0f),
        checkRange("targetGrowth", options.targetGrowth, 1.0f, 2.0f),
        checkRange("highWater", options.highWater, 1e-6f, 1.0f),
        checkRange("hysteresis", options.hysteresis, -1.0f, 2.0f),
        checkRange("biasFloor", options.biasFloor, -4.0f, 0.0f),
        checkRange("mergeShare", options.mergeShare, 0.0f, 1.0f),
        checkRange("quietFrames", static_cast<float>(options.quietFrames), 0.0f, 1e6f),
        checkRange("smallestLog2", static_cast<float>(options.smallestLog2), 0.0f, 10.0f),
        checkRange("largestLog2", static_cast<float>(options.largestLog2), 0.0f, 10.0f),
        checkRange("aspectLog2", static_cast<float>(options.aspectLog2), 1.0f, 10.0f)})
    if (!checked) return tl::unexpected(checked.error());
  const int largest = std::min(options.largestLog2, superblockLog2);
  if (options.smallestLog2 > largest)
    return fail("atlas memory: smallestLog2 is {}, but {} is {}: no block has 2^{} texels a side",
                options.smallestLog2,
                options.largestLog2 <= superblockLog2 ? "largestLog2" : "superblockLog2", largest,
                options.smallestLog2);

  glsl::AtlasConfig config{};
  config.width = static_cast<glsl::uint>(options.width);
  config.height = static_cast<glsl::uint>(options.height);
  config.superblockLog2 = static_cast<glsl::uint>(superblockLog2);
  config.superblocks = static_cast<glsl::uint>(superblocks);
  config.patchInstances = patchInstances;
  config.views = 1;
  config.biased = options.pressureBias ? 1 : 0;
  config.columns = options.strategy == AtlasStrategy::S0 ? 1 : 0;
  config.stacks = options.strategy <= AtlasStrategy::S1 ? 1 : 0;
  config.merges = options.strategy == AtlasStrategy::S0 && options.merge ? 1 : 0;
  const float texels = static_cast<float>(options.width) * static_cast<float>(options.height);
  config.mergeLoad = static_cast<glsl::uint>(texels * options.mergeShare);
  config.constantBias = options.bias;
  config.lowestBias = options.biasFloor;
  config.hysteresis = options.hysteresis;
  config.range = {static_cast<glsl::uint>(options.smallestLog2), static_cast<glsl::uint>(largest),
                  static_cast<glsl::uint>(options.aspectLog2)};
  config.pressure.highWater = texels * options.highWater;
  config.pressure.softWater = texels * options.softWater;
  config.pressure.targetStart = texels * options.targetShare;
  config.pressure.targetLargest = texels * options.targetLargest;
  config.pressure.targetSmallest = std::fmin(texels * kSmallestTargetShare, config.pressure.targetStart);
  config.pressure.targetCut = options.targetCut;
  config.pressure.targetGrowth = options.targetGrowth;
  config.pressure.quietFrames = static_cast<glsl::uint>(options.quietFrames);
  config.pressure.resets = options.strategy != AtlasStrategy::S3 ? 1 : 0;
  config.pressure.adapts = config.biased;
  return config;
}

/// The state before the first frame. `entries` receives how many entries all stacks have.
glsl::AtlasState initialState(const glsl::AtlasConfig& config, std::uint64_t& entries) {
  glsl::AtlasState state{};
  state.config = config;
  state.epoch = 1;
  state.pressure = glsl::pressureAtStart(config.pressure);
  state.superblocksFree = config.superblocks;
  entries = 0;
  for (glsl::uint w = 1; w <= config.superblockLog2; ++w)
    for (glsl::uint h = 0; h <= w; ++h) {
      glsl::LevelState& level = state.levels[glsl::levelIndex(w, h)];
      level.stackBase = static_cast<glsl::uint>(entries);
      level.stackCapacity = glsl::stackCapacityOf(config, w, h);
      if (config.stacks != 0) entries += level.stackCapacity;
      if (config.columns != 0 && h != w) continue;
      glsl::BinState& bin = state.bins[glsl::binOf(config, w, h)];
      bin.carryOffset = glsl::blocksPerSuperblock(config.superblockLog2, w, h);
      bin.carrySuperblock = glsl::kNoSuperblock;
    }
  return state;
}

RectStatistics statisticsOf(const glsl::AtlasState& state) {
  const glsl::AtlasConfig& config = state.config;
  RectStatistics statistics;
  statistics.visiblePatches = state.visible;
  statistics.blocksMoved = state.events.moved;
  statistics.movedTexels = state.events.movedTexels;
  statistics.blocksFreed = state.events.freed;
  statistics.blocksMerged = state.events.merged;
  statistics.blocksReduced = state.events.reduced;
  statistics.blocksWaiting = state.events.waiting;
  statistics.failures = state.events.failures;
  statistics.resets = state.resets;
  statistics.frames = state.frames;
  std::uint32_t blocks = 0;
  std::uint32_t requested = 0;
  for (glsl::uint w = 1; w <= config.superblockLog2; ++w)
    for (glsl::uint h = 0; h <= w; ++h) {
      const glsl::LevelState& level = state.levels[glsl::levelIndex(w, h)];
      const auto stacked = static_cast<std::uint32_t>(level.stackCount);
      const std::uint32_t live = level.existing - stacked - level.lost;
      statistics.stackTexels += std::uint64_t{stacked} << (w + h);
      statistics.inaccessibleTexels += std::uint64_t{level.lost} << (w + h);
      statistics.liveTexels += std::uint64_t{live} << (w + h);
      blocks += live;
      requested += level.lastRequested;
      if (config.columns != 0 && h != w) continue;
      const glsl::BinState& bin = state.bins[glsl::binOf(config, w, h)];
      statistics.endTexels +=
          std::uint64_t{glsl::blocksPerSuperblock(config.superblockLog2, w, h) - bin.carryOffset} << (w + h);
    }
  statistics.blocksMade = requested - state.events.failures;
  statistics.records = state.visible - blocks;
  statistics.samples = statistics.liveTexels + statistics.records;
  statistics.freeSuperblocks = state.superblocksFree;
  statistics.freeTexels = std::uint64_t{state.superblocksFree} << (2 * config.superblockLog2);
  statistics.resetPending = state.pressure.pending != 0;
  statistics.load = static_cast<float>(state.cutTexels) /
                    (static_cast<float>(config.width) * static_cast<float>(config.height));
  statistics.bias = config.constantBias + state.pressureBias;
  statistics.target = state.pressure.target;
  return statistics;
}

void betweenPhases() { gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT); }

}  // namespace

int superblockLog2Of(int width, int height) {
  int log2 = 8;
  while (log2 > 1 && std::int64_t{width >> log2} * (height >> log2) < 16) --log2;
  return log2;
}

Result<RectMemory> RectMemory::create(gl::ProgramCache& programs, const RectMemoryOptions& options,
                                      std::uint32_t patchInstances) {
  auto config = configFrom(options, patchInstances);
  if (!config) return tl::unexpected(config.error());
  RectMemory memory;
  memory.config_ = *config;
  std::uint64_t entries = 0;
  const glsl::AtlasState state = initialState(*config, entries);
  GLint64 largest = 0;
  gl::api().GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
  const std::uint64_t stackBytes = entries * sizeof(glsl::uint);
  if (stackBytes > static_cast<std::uint64_t>(largest))
    return fail(
        "atlas memory: stacks of {} bytes for {} x {} texels and {} patches are past this context's limit of "
        "{}",
        stackBytes, options.width, options.height, patchInstances, largest);
  auto compiled = programs.getAll({{&memory.measure_, "pass/rect_measure.comp"},
                                   {&memory.plan_, "pass/rect_plan.comp"},
                                   {&memory.merge_, "pass/rect_merge.comp"},
                                   {&memory.request_, "pass/rect_request.comp"},
                                   {&memory.provision_, "pass/rect_provision.comp"},
                                   {&memory.assign_, "pass/rect_assign.comp"}});
  if (!compiled) return tl::unexpected(compiled.error());
  memory.state_ = gl::Buffer(sizeof(glsl::AtlasState));
  memory.state_.writeValue(state);
  memory.stacks_ = gl::Buffer(stackBytes);
  std::vector<glsl::uint> superblocks(std::size_t{2} * config->superblocks, 0);
  for (glsl::uint i = 0; i < config->superblocks; ++i) superblocks[i] = config->superblocks - 1 - i;
  memory.superblocks_ = gl::Buffer(superblocks);
  if (config->merges != 0)
    memory.mergeMap_ =
        gl::Buffer((std::size_t{config->width} * config->height / 2 + 31) / 32 * sizeof(glsl::uint));
  memory.readback_ = gl::Readback(sizeof(glsl::AtlasState), kReadbacks);
  memory.patches_ = gl::Buffer(patchInstances * sizeof(glsl::PatchState));
  memory.measures_ = gl::Buffer(patchInstances * sizeof(glsl::PatchMeasure));
  memory.live_ = gl::Buffer((std::size_t{patchInstances} + 1) * sizeof(glsl::uint));
  return memory;
}

void RectMemory::bind() const {
  patches_.bindStorage(BIND_PATCH_STATE);
  state_.bindStorage(BIND_ATLAS_STATE);
}

void RectMemory::bindPhases() const {
  bind();
  stacks_.bindStorage(BIND_ATLAS_STACKS);
  measures_.bindStorage(BIND_PATCH_MEASURE);
  live_.bindStorage(BIND_ATLAS_LIVE);
  superblocks_.bindStorage(BIND_ATLAS_SUPERBLOCKS);
  if (mergeMap_) mergeMap_.bindStorage(BIND_ATLAS_MERGE);
}

void RectMemory::measure(const gl::Buffer& dispatch, std::uint32_t viewCount, const gl::Program* program) {
  assert(viewCount >= 1 && viewCount <= RECT_VIEWS);
  if (viewCount != config_.views) {
    config_.views = viewCount;
    state_.writeValue(viewCount, offsetof(glsl::AtlasState, config) + offsetof(glsl::AtlasConfig, views));
  }
  bindPhases();
  (program != nullptr ? program : measure_)->use();
  gl::dispatchIndirect(dispatch, 0);
}

void RectMemory::allocate(const gl::Buffer& dispatch, std::uint32_t frame) {
  bindPhases();
  betweenPhases();
  plan_->use();
  plan_->set(LOCATION_COUNT, (resetAsked_ ? 1u : 0u) | (resetHeld_ ? 2u : 0u));
  resetAsked_ = resetAsked_ && resetHeld_;
  gl::api().DispatchCompute(1, 1, 1);
  gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
  if (mergeMap_) {
    gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    mergeMap_.fill(0);
    merge_->use();
    gl::dispatchIndirect(state_, offsetof(glsl::AtlasState, mergeGroupsX));
    betweenPhases();
  }
  request_->use();
  request_->set(LOCATION_FRAME, frame);
  gl::dispatchIndirect(state_, offsetof(glsl::AtlasState, requestGroupsX));
  betweenPhases();
  provision_->use();
  gl::api().DispatchCompute(1, 1, 1);
  betweenPhases();
  assign_->use();
  gl::dispatchIndirect(dispatch, 0);
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  readback_.request(state_);
}

void RectMemory::setBias(float bias) {
  config_.constantBias = bias;
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  state_.writeValue(bias, offsetof(glsl::AtlasState, config) + offsetof(glsl::AtlasConfig, constantBias));
}

int RectMemory::textureHeight() const {
  return static_cast<int>(config_.height + singleRows(config_.width, config_.height, config_.patchInstances));
}

std::size_t RectMemory::bytes() const {
  return state_.size() + stacks_.size() + superblocks_.size() + mergeMap_.size() + patches_.size() +
         measures_.size() + live_.size();
}

glsl::AtlasState RectMemory::readState() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  return state_.readAll<glsl::AtlasState>(1)[0];
}

std::vector<glsl::PatchState> RectMemory::readVisible() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  const auto states = patches_.readAll<glsl::PatchState>(config_.patchInstances);
  const auto list = live_.readAll<glsl::uint>(std::size_t{1} + live_.readAll<glsl::uint>(1)[0]);
  std::vector<glsl::PatchState> visible;
  for (std::size_t i = 1; i < list.size(); ++i) visible.push_back(states[list[i]]);
  return visible;
}

RectStatistics RectMemory::readStatistics() const { return statisticsOf(readState()); }

std::optional<RectStatistics> RectMemory::latestStatistics() {
  const void* bytes = readback_.latest();
  if (bytes == nullptr) return std::nullopt;
  glsl::AtlasState state;
  std::memcpy(&state, bytes, sizeof(state));
  return statisticsOf(state);
}

MemorySnapshot RectMemory::readSnapshot() const {
  const glsl::AtlasState state = readState();
  const auto stacks = stacks_.readAll<glsl::uint>(stacks_.size() / sizeof(glsl::uint));
  const auto patches = patches_.readAll<glsl::PatchState>(config_.patchInstances);
  MemorySnapshot snapshot;
  snapshot.width = config_.width;
  snapshot.height = config_.height;
  snapshot.superblockLog2 = config_.superblockLog2;
  for (const glsl::PatchState& patch : patches) {
    if (patch.epoch != state.epoch || glsl::levelWidth(patch.level) == 0) continue;
    const glsl::uvec2 at = glsl::unpackOrigin(patch.origin);
    snapshot.live.push_back({at.x, at.y, glsl::levelWidth(patch.level), glsl::levelHeight(patch.level)});
  }
  for (glsl::uint w = 1; w <= config_.superblockLog2; ++w)
    for (glsl::uint h = 0; h <= w; ++h) {
      const glsl::LevelState& level = state.levels[glsl::levelIndex(w, h)];
      snapshot.inaccessibleTexels += std::uint64_t{level.lost} << (w + h);
      for (int i = 0; i < level.stackCount; ++i) {
        const glsl::uvec2 at = glsl::unpackOrigin(stacks[level.stackBase + static_cast<glsl::uint>(i)]);
        snapshot.stacked.push_back({at.x, at.y, w, h});
      }
      if (config_.columns != 0 && h != w) continue;
      const glsl::BinState& bin = state.bins[glsl::binOf(config_, w, h)];
      if (bin.carrySuperblock != glsl::kNoSuperblock)
        snapshot.carried.push_back({w, h, bin.carrySuperblock, bin.carryOffset});
    }
  snapshot.freeSuperblocks = superblocks_.readAll<glsl::uint>(state.superblocksFree);
  return snapshot;
}

}  // namespace tessera
