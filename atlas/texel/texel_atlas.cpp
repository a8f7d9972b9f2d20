#include "atlas/texel/texel_atlas.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>

#include <glm/gtc/type_ptr.hpp>

#include "atlas/single_rows.hpp"
#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

constexpr int kMarkGroup = 16;
constexpr std::uint32_t kLeastWanted = 1u
                                       << 18u;  // tiles that pixels may ask for, be the atlas ever so small

Result<void> checkRange(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return {};
  return fail("texel shading: {} {} is outside [{}, {}]", name, value, least, most);
}

Result<glsl::TexelConfig> configFrom(const TexelAtlasOptions& options, std::size_t batches) {
  const struct {
    const char* name;
    double value, least, most;
  } ranges[] = {{"width", static_cast<double>(options.width), 64, 16384},
                {"height", static_cast<double>(options.height), 64, 16384},
                {"bias", options.bias, -16, 16},
                {"bias floor", options.biasFloor, -4, 0}};
  for (const auto& range : ranges)
    if (auto good = checkRange(range.name, range.value, range.least, range.most); !good)
      return tl::unexpected(good.error());
  constexpr int kTile = glsl::kTexelTile;
  for (const int side : {options.width, options.height})
    if (side % kTile != 0) return fail("texel shading: {} texels are no multiple of {}", side, kTile);
  glsl::TexelConfig config{};
  config.columns = static_cast<glsl::uint>(options.width / kTile);
  config.slots = config.columns * static_cast<glsl::uint>(options.height / kTile);
  config.recordRow = static_cast<glsl::uint>(options.height);
  config.wanted = std::max(2 * config.slots, kLeastWanted);
  config.table = std::bit_ceil(2 * config.wanted);
  config.batches = static_cast<glsl::uint>(batches);
  config.biased = options.pressureBias ? 1 : 0;
  config.constantBias = options.bias;
  config.lowestBias = options.biasFloor;
  return config;
}

void betweenPasses() { gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT); }

void runOnce(const gl::Program& program) {
  program.use();
  gl::api().DispatchCompute(1, 1, 1);
  betweenPasses();
}

void runOver(const gl::Program& program, const gl::Buffer& state, std::size_t groups) {
  program.use();
  gl::dispatchIndirect(state, groups);
  betweenPasses();
}

}  // namespace

Result<TexelAtlas> TexelAtlas::create(gl::ProgramCache& programs, const TexelAtlasOptions& options,
                                      std::span<const glsl::TexelChart> charts, std::uint32_t entries,
                                      std::span<const glsl::BatchGpu> batches) {
  auto config = configFrom(options, batches.size());
  if (!config) return tl::unexpected(config.error());
  TexelAtlas atlas;
  atlas.config_ = *config;
  auto compiled = programs.getAll({{&atlas.openPass_, "pass/texel_open.comp"},
                                   {&atlas.mark_, "pass/texel_mark.comp"},
                                   {&atlas.markLayers_, "pass/texel_mark.comp", {{"LAYERS", "1"}}},
                                   {&atlas.fit_, "pass/texel_fit.comp"},
                                   {&atlas.clear_, "pass/texel_clear.comp"},
                                   {&atlas.coarsen_, "pass/texel_coarsen.comp"},
                                   {&atlas.release_, "pass/texel_release.comp"},
                                   {&atlas.assign_, "pass/texel_assign.comp"},
                                   {&atlas.emit_, "pass/rect_emit.comp", {{"CHARTS", "1"}}},
                                   {&atlas.scan_, "pass/texel_scan.comp"},
                                   {&atlas.queuePass_, "pass/texel_queue.comp"}});
  if (!compiled) return tl::unexpected(compiled.error());
  const std::uint32_t singles =
      singleRows(static_cast<std::uint32_t>(options.width), static_cast<std::uint32_t>(options.height),
                 static_cast<std::uint32_t>(charts.size()));
  auto texture =
      AtlasTexture::create(options.width, options.height + static_cast<int>(singles), options.format);
  if (!texture) return tl::unexpected(texture.error());
  atlas.atlas_ = std::move(*texture);
  atlas.draw_ = PatchDraw(static_cast<std::uint32_t>(charts.size()), entries, batches);

  glsl::TexelState state{};
  state.config = *config;
  state.pressure = {options.pressureBias ? options.biasFloor : 0.0f, 0, glsl::kTexelQuiet, 0};
  state.freeSlots = static_cast<int>(config->slots);
  atlas.state_ = gl::Buffer(sizeof(glsl::TexelState));
  atlas.state_.writeValue(state);
  // The lowest on top: what is used stays together.
  std::vector<glsl::uint> slots(config->slots);
  std::iota(slots.rbegin(), slots.rend(), 0u);
  atlas.stack_ = gl::Buffer(slots);
  atlas.charts_ = gl::Buffer(charts, 0);
  atlas.table_ = gl::Buffer(std::size_t{4} * config->table * sizeof(glsl::uint));
  atlas.wanted_ = gl::Buffer(std::size_t{2} * config->wanted * sizeof(glsl::uvec2));
  atlas.tiles_ = gl::Buffer(std::size_t{2} * config->slots * sizeof(glsl::TexelTile));
  atlas.queue_ = gl::Buffer(std::size_t{config->slots} * sizeof(glsl::TexelTile));
  std::vector<glsl::TexelBatch> empty(batches.size());
  for (std::size_t i = 0; i < batches.size(); ++i) empty[i].firstEntry = batches[i].firstEntry;
  atlas.batches_ = gl::Buffer(empty);
  atlas.emptyBatches_ = gl::Buffer(empty, 0);
  return atlas;
}

void TexelAtlas::beginViews() {
  const bool placed = !open_;
  if (placed) current_ = 1 - current_;
  open_ = true;
  bindMemory();
  // The last frame's shaders wrote what is cleared here.
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
  table_.fill(0, current_ * table_.size() / 2, table_.size() / 2);
  openPass_->use();
  openPass_->set(LOCATION_COUNT, current_);
  openPass_->set(LOCATION_FRAME, placed ? 1u : 0u);
  runOnce(*openPass_);
}

void TexelAtlas::addViews(const gl::Texture& ids, std::span<const glm::mat3> pixelToRay) {
  bindMemory();
  ids.bind(UNIT_ID);
  const gl::Program& mark = ids.layers() > 0 ? *markLayers_ : *mark_;
  mark.use();
  for (std::size_t view = 0; view < pixelToRay.size(); ++view) {
    mark.set(LOCATION_COUNT, static_cast<unsigned>(view));
    gl::api().ProgramUniformMatrix3fv(mark.get(), LOCATION_VIEW, 1, GL_FALSE,
                                      glm::value_ptr(pixelToRay[view]));
    gl::dispatchOver(ids.width(), ids.height(), kMarkGroup);
    betweenPasses();
  }
}

void TexelAtlas::allocate(const VisibleSet& /*visible*/) {
  if (!open_) return;
  open_ = false;
  bindMemory();
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl::api().CopyNamedBufferSubData(emptyBatches_.get(), batches_.get(), 0, 0,
                                   static_cast<GLsizeiptr>(batches_.size()));
  for (glsl::uint round = 0; round < glsl::kTexelRounds; ++round) {
    runOnce(*fit_);
    runOver(*clear_, state_, offsetof(glsl::TexelState, clearGroupsX));
    runOver(*coarsen_, state_, offsetof(glsl::TexelState, wantedGroupsX));
  }
  runOnce(*fit_);
  runOver(*release_, state_, offsetof(glsl::TexelState, oldGroupsX));
  runOver(*assign_, state_, offsetof(glsl::TexelState, tileGroupsX));
}

void TexelAtlas::emit(const VisibleSet& visible) {
  draw_.emit(*emit_, visible);
  bind();
  betweenPasses();
  runOnce(*scan_);
  runOver(*queuePass_, state_, offsetof(glsl::TexelState, tileGroupsX));
}

void TexelAtlas::bindMemory() const {
  state_.bindStorage(BIND_ATLAS_STATE);
  charts_.bindStorage(BIND_TEXEL_CHARTS);
  table_.bindStorage(BIND_TEXEL_TABLE);
  wanted_.bindStorage(BIND_TEXEL_WANTED);
  tiles_.bindStorage(BIND_TEXEL_TILES);
  stack_.bindStorage(BIND_ATLAS_STACKS);
  batches_.bindStorage(BIND_TEXEL_BATCHES);
}

void TexelAtlas::bind() const {
  draw_.bind();
  bindMemory();
  queue_.bindStorage(BIND_TEXEL_QUEUE);
}

void TexelAtlas::beginShading() const {
  const gl::Texture& target = atlas_.display();
  gl::api().BindImageTexture(0, target.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, target.format());
  betweenPasses();
}

void TexelAtlas::shadeBatch(const gl::Program& program, std::uint32_t batch) const {
  const std::size_t first = batch * sizeof(glsl::TexelBatch);
  program.set(LOCATION_COUNT, batch);
  program.set(LOCATION_FRAME, 0u);
  gl::dispatchIndirect(batches_, first + offsetof(glsl::TexelBatch, tileGroupsX));
  program.set(LOCATION_FRAME, 1 + config_.recordRow);
  gl::dispatchIndirect(batches_, first + offsetof(glsl::TexelBatch, recordGroupsX));
}

void TexelAtlas::endShading() const {
  gl::api().MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                          GL_FRAMEBUFFER_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void TexelAtlas::drawBatches(std::uint32_t first, std::uint32_t count, std::uint32_t /*list*/) const {
  draw_.draw(first, count);
}

std::size_t TexelAtlas::bytes() const {
  return atlas_.texture.bytes() + draw_.bytes() + state_.size() + charts_.size() + table_.size() +
         wanted_.size() + tiles_.size() + queue_.size() + stack_.size() + batches_.size();
}

glsl::TexelState TexelAtlas::readState() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  return state_.readAll<glsl::TexelState>(1)[0];
}

TexelStatistics TexelAtlas::readCounts() const {
  const glsl::TexelState state = readState();
  TexelStatistics statistics;
  statistics.visible = state.visible;
  statistics.marked = state.marked;
  statistics.lost = state.lost;
  statistics.tiles = state.shown == 0 ? state.tiles0 : state.tiles1;
  statistics.slots = state.config.slots;
  statistics.samples = std::uint64_t{state.samples} + state.visible;
  statistics.kept = state.kept;
  statistics.coarser = state.shownCoarser;
  statistics.frames = state.frames;
  statistics.bias = state.shownBias;
  return statistics;
}

GatherStatistics TexelAtlas::readStatistics() const {
  const TexelStatistics counts = readCounts();
  constexpr std::uint64_t kTileTexels = 64;
  GatherStatistics statistics;
  statistics.samples = counts.samples;
  statistics.kinds = {{"tile", {80, 190, 190}, counts.samples - counts.visible},
                      {"record", {240, 150, 40}, counts.visible}};
  statistics.packings = {{"tiles", counts.samples - counts.visible, kTileTexels * counts.tiles}};
  statistics.visible = counts.visible;
  statistics.liveTexels = kTileTexels * counts.tiles;
  statistics.usedTexels = statistics.liveTexels + counts.visible;
  const std::uint64_t vertices = draw_.readVertices();
  statistics.displayBytes = vertices * sizeof(glsl::DisplayVertex);
  statistics.decodeBytes = vertices * sizeof(glsl::DisplayVertex::texel);
  statistics.failures = counts.lost;
  statistics.bias = static_cast<double>(counts.bias);
  return statistics;
}

std::vector<glsl::TexelTile> TexelAtlas::readTiles() const {
  const glsl::TexelState state = readState();
  return tiles_.readAll<glsl::TexelTile>(
      state.shown == 0 ? state.tiles0 : state.tiles1,
      std::size_t{state.shown} * state.config.slots * sizeof(glsl::TexelTile));
}

}  // namespace tessera
