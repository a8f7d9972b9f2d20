#include <array>
#include <chrono>
#include <cstddef>

#include "apps/tessera/atlas_bench.hpp"
#include "apps/tessera/progress.hpp"
#include "atlas/rect/place_tracker.hpp"
#include "atlas/rect/quadtree_atlas.hpp"
#include "engine/gl/timer.hpp"
#include "glsl/shared/bindings.h"

namespace tessera::app {

namespace {

/// Gives a RectMemory the frames of a stream in place of the passes that find and measure what is visible.
class StreamFeed {
 public:
  StreamFeed(std::uint32_t patchInstances, std::uint32_t mostVisible)
      : list_(4 * (std::size_t{mostVisible} + 1)),
        marks_(4 * std::size_t{patchInstances}),
        dispatch_(3 * sizeof(std::uint32_t)),
        numbers_(patchInstances, 0) {}

  /// Uploads a frame; RectMemory::allocate(dispatch(), number()) comes next.
  void upload(const RequestFrame& frame, const IdealTexels& ideal, RectMemory& memory) {
    ++number_;
    const auto count = static_cast<std::uint32_t>(frame.patches.size());
    for (const std::uint32_t patch : frame.patches) numbers_[patch] = number_;
    list_.writeValue(count);
    list_.write(std::span<const std::uint32_t>(frame.patches), sizeof(std::uint32_t));
    marks_.write(std::span<const std::uint32_t>(numbers_));
    const std::array<std::uint32_t, 3> groups = {(count + RECT_GROUP - 1) / RECT_GROUP, 1, 1};
    dispatch_.write(std::span<const std::uint32_t>(groups));
    memory.measures().write(std::span<const glsl::PatchMeasure>(frame.measures));
    glsl::IdealSum sum{};
    sum.low = static_cast<glsl::uint>(ideal.scalable);
    sum.high = static_cast<glsl::uint>(ideal.scalable >> 32U);
    sum.ones = ideal.least;
    sum.newLow = static_cast<glsl::uint>(ideal.fresh);
    sum.newHigh = static_cast<glsl::uint>(ideal.fresh >> 32U);
    memory.stateBuffer().writeValue(sum, offsetof(glsl::AtlasState, ideal));
    list_.bindStorage(BIND_VISIBLE);
    marks_.bindStorage(BIND_VISIBLE_MARK);
  }
  [[nodiscard]] const gl::Buffer& dispatch() const { return dispatch_; }
  [[nodiscard]] std::uint32_t number() const { return number_; }

 private:
  gl::Buffer list_;
  gl::Buffer marks_;
  gl::Buffer dispatch_;
  std::vector<std::uint32_t> numbers_;  // the frame each patch was last visible in
  std::uint32_t number_ = 0;
};

void add(const PlaceChanges& changes, BenchFrame& figures) {
  figures.reset = changes.reset;
  figures.stayed = changes.stayed;
  figures.kept = changes.kept;
  figures.moved = changes.moved;
  figures.movedTexels = static_cast<double>(changes.movedTexels);
}

}  // namespace

Result<BenchRun> runOnGpu(gl::Context& context, RectMemory memory, const RequestStream& stream,
                          const std::string& name, Progress& progress) {
  const std::uint32_t patches = stream.header().patchInstances;
  const glsl::AtlasState start = memory.readState();
  const glsl::AtlasConfig& config = start.config;
  std::uint32_t epoch = start.epoch;
  std::vector<glsl::PatchState> states(patches);
  StreamFeed feed(patches, stream.mostVisible());
  PlaceTracker places(patches);
  gl::Timer timer(gl::timerModeFor(context.info()));
  RequestStream::Reader reader(stream);
  RequestFrame frame;
  BenchRun run{name, {}};
  for (std::size_t f = 0; f < stream.frames(); ++f) {
    if (auto read = reader.next(frame); !read) return tl::unexpected(read.error());
    feed.upload(frame, sumIdeal(config, frame.patches, frame.measures, states, epoch), memory);
    timer.begin();
    memory.allocate(feed.dispatch(), feed.number());
    timer.end();
    BenchFrame figures;
    figures.ms = timer.milliseconds();
    const RectStatistics statistics = memory.readStatistics();
    states = memory.patchStates().readAll<glsl::PatchState>(patches);
    epoch = memory.readState().epoch;
    add(places.follow(frame.patches, states, epoch), figures);
    figures.live = static_cast<double>(statistics.liveTexels);
    figures.end = static_cast<double>(statistics.endTexels);
    figures.stack = static_cast<double>(statistics.stackTexels);
    figures.inaccessible = static_cast<double>(statistics.inaccessibleTexels);
    figures.free = static_cast<double>(statistics.freeTexels);
    figures.made = statistics.blocksMade;
    figures.freed = statistics.blocksFreed;
    figures.failures = statistics.failures;
    figures.reduced = statistics.blocksReduced;
    figures.bias = static_cast<double>(statistics.bias);
    figures.target = static_cast<double>(statistics.target);
    run.frames.push_back(figures);
    progress.step(name);
  }
  if (auto whole = checkPartition(memory.readSnapshot()); !whole)
    return fail("{}: after the last frame {}", name, whole.error().message);
  return run;
}

Result<BenchRun> runQuadtree(const RequestStream& stream, const glsl::AtlasConfig& config,
                             Progress& progress) {
  QuadtreeAtlas atlas(config);
  PlaceTracker places(config.patchInstances);
  RequestStream::Reader reader(stream);
  RequestFrame frame;
  BenchRun run{"CPU quadtree", {}};
  const double texels = static_cast<double>(config.width) * config.height;
  for (std::size_t f = 0; f < stream.frames(); ++f) {
    if (auto read = reader.next(frame); !read) return tl::unexpected(read.error());
    const IdealTexels ideal =
        sumIdeal(config, frame.patches, frame.measures, atlas.patchStates(), atlas.epoch());
    const auto start = std::chrono::steady_clock::now();
    atlas.frame(frame.patches, frame.measures, ideal);
    BenchFrame figures;
    figures.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    add(places.follow(frame.patches, atlas.patchStates(), atlas.epoch()), figures);
    figures.live = static_cast<double>(atlas.allocator().liveTexels());
    figures.free = static_cast<double>(atlas.allocator().rootTexels());
    figures.stack = texels - figures.live - figures.free;
    figures.made = atlas.blocksMade();
    figures.freed = atlas.blocksFreed();
    figures.failures = atlas.failures();
    figures.reduced = atlas.blocksReduced();
    figures.bias = static_cast<double>(config.constantBias + atlas.pressureBias());
    figures.target = static_cast<double>(atlas.target());
    run.frames.push_back(figures);
    progress.step(run.name);
  }
  if (auto whole = checkPartition(atlas.allocator().snapshot()); !whole)
    return fail("{}: after the last frame {}", run.name, whole.error().message);
  return run;
}

}  // namespace tessera::app
