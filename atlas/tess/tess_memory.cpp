#include "atlas/tess/tess_memory.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "atlas/single_rows.hpp"
#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

// Free slots that a bin remembers; what is freed beyond is lost until memory is reset.
constexpr std::uint64_t kLongestStack = 16384;     // of Ls
constexpr std::uint64_t kLongestBlockStack = 256;  // of Oversampling's blocks, which have many more bins

Result<void> checkRange(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return {};
  return fail("atlas memory: {} {} is outside [{}, {}]", name, value, least, most);
}

/// The largest sizes whose cells fit into the atlas.
glsl::TessLimits limitsOf(const TessMemoryOptions& options) {
  const auto fits = [&](glsl::uvec2 cell) {
    return static_cast<int>(cell.x) <= options.width && static_cast<int>(cell.y) <= options.height;
  };
  glsl::uint level = glsl::kLargestLevel;
  while (!fits(glsl::lPairSize(level))) --level;
  glsl::uint columns = 1 + static_cast<glsl::uint>(glsl::kOverWidest);
  constexpr auto kMostRows = 2 + static_cast<glsl::uint>(glsl::kOverHighest);
  while (!fits(glsl::overPairSize(columns + 1, kMostRows)) ||
         glsl::overClassSteps(glsl::overClass(columns)) != columns)
    --columns;
  // Rounding may add a texel, but no class.
  return {options.slanted, static_cast<float>(level), static_cast<float>(columns - 1)};
}

Result<glsl::TessConfig> configFrom(const TessMemoryOptions& options, std::uint32_t triangles) {
  const struct {
    const char* name;
    double value, least, most;
  } ranges[] = {
      {"width", static_cast<double>(options.width), 256, 16384},
      {"height", static_cast<double>(options.height), 256, 16384},
      {"bias", options.bias, -16, 16},
      {"bias floor", options.biasFloor, -4, 0},
      {"target share", options.targetShare, 1e-6, 1},
      {"largest target", options.targetLargest, options.targetShare, 1},
      {"target cut", options.targetCut, 1e-6, 1},
      {"target growth", options.targetGrowth, 1, 2},
      {"quiet frames", static_cast<double>(options.quietFrames), 0, 1e6},
      {"high-water mark", options.highWater, 1e-6, 1},
      {"slanted", options.slanted, TessMemoryOptions::kAllSlanted, TessMemoryOptions::kNoneSlanted}};
  for (const auto& range : ranges)
    if (auto good = checkRange(range.name, range.value, range.least, range.most); !good)
      return tl::unexpected(good.error());
  if (!(options.hysteresis <= 1.0f))
    return fail("atlas memory: hysteresis {} is above 1", options.hysteresis);
  const double area = static_cast<double>(options.width) * options.height;
  glsl::TessConfig config{};
  config.width = static_cast<glsl::uint>(options.width);
  config.height = static_cast<glsl::uint>(options.height);
  config.triangles = triangles;
  // A run ends with its bin or uses up a free rectangle's width.
  config.runs = glsl::kTessBins + glsl::kFreeRects + config.height;
  config.views = 1;
  config.biased = options.pressureBias ? 1 : 0;
  config.constantBias = options.bias;
  config.lowestBias = options.biasFloor;
  config.hysteresis = options.hysteresis;
  config.limits = limitsOf(options);
  config.pressure.highWater = static_cast<float>(options.highWater * area);
  config.pressure.softWater = static_cast<float>(area);
  config.pressure.targetStart = static_cast<float>(options.targetShare * area);
  config.pressure.targetLargest = static_cast<float>(options.targetLargest * area);
  config.pressure.targetSmallest = static_cast<float>(0.05 * area);
  config.pressure.targetCut = options.targetCut;
  config.pressure.targetGrowth = options.targetGrowth;
  config.pressure.quietFrames = static_cast<glsl::uint>(options.quietFrames);
  config.pressure.resets = 1;
  config.pressure.adapts = options.pressureBias ? 1 : 0;
  return config;
}

/// The bins, smallest cells first.
std::vector<glsl::TessBin> emptyBins(const glsl::TessConfig& config, std::uint64_t& entries) {
  std::vector<glsl::TessBin> bins(glsl::kTessBins);
  entries = 0;
  for (glsl::uint i = 0; i < glsl::kTessBins; ++i) {
    glsl::TessBin& bin = bins[i];
    const glsl::uvec2 cell = glsl::cellOfBin(i);
    bin.cellWidth = cell.x;
    bin.cellHeight = cell.y;
    const std::uint64_t slots =
        std::uint64_t{2} * config.width * config.height / (std::uint64_t{bin.cellWidth} * bin.cellHeight);
    bin.stackBase = static_cast<glsl::uint>(entries);
    bin.stackCapacity = static_cast<glsl::uint>(
        std::clamp<std::uint64_t>(slots, 1, i < glsl::kLargestLevel ? kLongestStack : kLongestBlockStack));
    bin.spare = glsl::kNoPlace;
    entries += bin.stackCapacity;
  }
  return bins;
}

void betweenPhases() { gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT); }

}  // namespace

Result<TessMemory> TessMemory::create(gl::ProgramCache& programs, const TessMemoryOptions& options,
                                      std::uint32_t triangles) {
  auto config = configFrom(options, triangles);
  if (!config) return tl::unexpected(config.error());
  TessMemory memory;
  memory.config_ = *config;
  auto compiled = programs.getAll({{&memory.measure_, "pass/tess_measure.comp"},
                                   {&memory.plan_, "pass/tess_plan.comp"},
                                   {&memory.request_, "pass/tess_request.comp"},
                                   {&memory.provision_, "pass/tess_provision.comp"},
                                   {&memory.assign_, "pass/tess_assign.comp"}});
  if (!compiled) return tl::unexpected(compiled.error());
  std::uint64_t entries = 0;
  memory.bins_ = gl::Buffer(emptyBins(*config, entries));
  memory.stacks_ = gl::Buffer(entries * sizeof(glsl::uint));
  memory.runs_ = gl::Buffer(config->runs * sizeof(glsl::TessRun));
  memory.state_ = gl::Buffer(sizeof(glsl::TessAtlasState));
  glsl::TessAtlasState state{};
  state.config = *config;
  state.epoch = 1;
  state.rectCount = 1;
  state.rects[0] = {0, 0, config->width, config->height};
  state.pressure = glsl::pressureAtStart(config->pressure);
  memory.state_.writeValue(state);
  const std::size_t numbers = std::size_t{triangles} + glsl::kSplitNumbers;
  memory.states_ = gl::Buffer(numbers * sizeof(glsl::TessState));
  memory.measures_ = gl::Buffer(numbers * sizeof(glsl::TessMeasure));
  memory.live_ = gl::Buffer((numbers + 1) * sizeof(glsl::uint));
  return memory;
}

void TessMemory::bind() const {
  states_.bindStorage(BIND_PATCH_STATE);
  state_.bindStorage(BIND_ATLAS_STATE);
}

void TessMemory::bindPhases() const {
  bind();
  bins_.bindStorage(BIND_TESS_BINS);
  runs_.bindStorage(BIND_TESS_RUNS);
  stacks_.bindStorage(BIND_ATLAS_STACKS);
  measures_.bindStorage(BIND_PATCH_MEASURE);
  live_.bindStorage(BIND_ATLAS_LIVE);
}

void TessMemory::setViewCount(std::uint32_t viewCount) {
  assert(viewCount >= 1 && viewCount <= TESS_VIEWS);
  if (viewCount != config_.views) {
    config_.views = viewCount;
    gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    state_.writeValue(viewCount, offsetof(glsl::TessAtlasState, config) + offsetof(glsl::TessConfig, views));
  }
}

void TessMemory::measure(const gl::Buffer& dispatch, const gl::Program* program) {
  bindPhases();
  (program != nullptr ? program : measure_)->use();
  gl::dispatchIndirect(dispatch, 0);
}

void TessMemory::allocate(const gl::Buffer& dispatch, std::uint32_t frame) {
  bindPhases();
  betweenPhases();
  const glsl::uint asked = (resetAsked_ ? 1u : 0u) | (resetHeld_ ? 2u : 0u);
  resetAsked_ = resetAsked_ && resetHeld_;
  for (glsl::uint round = 0; round < glsl::kTessRounds; ++round) {
    plan_->use();
    plan_->set(LOCATION_COUNT, asked);
    plan_->set(LOCATION_FRAME, round);
    gl::api().DispatchCompute(1, 1, 1);
    gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    request_->use();
    request_->set(LOCATION_FRAME, frame);
    gl::dispatchIndirect(state_, offsetof(glsl::TessAtlasState, requestGroupsX));
    betweenPhases();
    provision_->use();
    gl::api().DispatchCompute(1, 1, 1);
    betweenPhases();
  }
  assign_->use();
  gl::dispatchIndirect(dispatch, 0);
}

int TessMemory::textureHeight() const {
  const std::uint32_t records = config_.triangles + glsl::kSplitNumbers;
  return static_cast<int>(config_.height + singleRows(config_.width, config_.height, records));
}

std::size_t TessMemory::bytes() const {
  return state_.size() + bins_.size() + runs_.size() + stacks_.size() + states_.size() + measures_.size() +
         live_.size();
}

glsl::TessAtlasState TessMemory::readState() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  return state_.readAll<glsl::TessAtlasState>(1)[0];
}

std::vector<glsl::TessState> TessMemory::readStates() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  return states_.readAll<glsl::TessState>(config_.triangles + glsl::kSplitNumbers);
}

std::vector<glsl::uint> TessMemory::readVisible() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  auto visible = live_.readAll<glsl::uint>(std::size_t{1} + live_.readAll<glsl::uint>(1)[0]);
  visible.erase(visible.begin());
  return visible;
}

std::vector<glsl::TessBin> TessMemory::readBins() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  return bins_.readAll<glsl::TessBin>(glsl::kTessBins);
}

TessStatistics TessMemory::readStatistics() const {
  const glsl::TessAtlasState state = readState();
  TessStatistics statistics;
  statistics.visible = live_.readAll<glsl::uint>(1)[0];
  statistics.singles = state.events.singles;
  statistics.samples = state.events.samples;
  statistics.lSamples = state.events.lSamples;
  statistics.inside = state.events.inside;
  statistics.outside = state.events.outside;
  statistics.slanted = state.events.slanted;
  statistics.liveTexels = state.liveTexels;
  statistics.cellTexels = state.cellTexels;
  for (glsl::uint i = 0; i < state.rectCount; ++i)
    statistics.freeTexels += std::uint64_t{state.rects[i].width} * state.rects[i].height;
  statistics.moved = state.events.moved;
  statistics.movedTexels = state.events.movedTexels;
  statistics.freed = state.events.freed;
  statistics.failures = state.events.failures;
  statistics.resets = state.resets;
  statistics.frames = state.frames;
  statistics.bias = state.config.constantBias + state.bias;
  statistics.target = state.pressure.target;
  return statistics;
}

}  // namespace tessera
