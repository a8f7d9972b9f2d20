#include "atlas/rect/memory.hpp"

#include <cstddef>
#include <map>

#include "glsl/shared/bindings.h"
#include "tests/atlas/memory_scenarios.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using test::FrameStream;
using test::Scenario;
using Wants = std::vector<MemoryTwin::Want>;

RectMemoryOptions optionsOf(const Scenario& scenario) {
  RectMemoryOptions options;
  options.width = static_cast<int>(scenario.width);
  options.height = static_cast<int>(scenario.height);
  options.superblockLog2 = static_cast<int>(scenario.superblockLog2);
  options.pressureBias = false;
  options.hysteresis = -1.0f;
  options.highWater = 1.0f;
  return options;
}

/// Feeds visible lists to a RectMemory, with measures that ask for exactly the wanted levels.
class Feed {
 public:
  Feed(const RectMemoryOptions& options, std::uint32_t patches)
      : programs_(test::context()),
        patches_(patches),
        visible_(4 * (std::size_t{patches} + 1)),
        marks_(4 * std::size_t{patches}),
        dispatch_(12) {
    auto made = RectMemory::create(programs_, options, patches);
    if (!made) {
      ADD_FAILURE() << made.error().message;
      return;
    }
    memory = std::move(*made);
  }

  /// `transposed` swaps the axes of what is asked, so that the same block is wanted the other way round.
  void frame(const Wants& wants, bool transposed = false) {
    std::vector<glsl::PatchMeasure> measures;
    for (const MemoryTwin::Want& want : wants) {
      const auto aspect = static_cast<float>(want.w) - static_cast<float>(want.h);
      measures.push_back({static_cast<float>(want.w + want.h), transposed ? -aspect : aspect});
    }
    frame(wants, measures);
  }
  void frame(const Wants& wants, const std::vector<glsl::PatchMeasure>& measures) {
    see(wants);
    memory.measures().write(std::span<const glsl::PatchMeasure>(measures));
    memory.allocate(dispatch_, frame_);
  }
  /// Uploads a visible list and binds it; the next calls use it.
  void see(const Wants& wants) {
    ++frame_;
    std::vector<std::uint32_t> list = {static_cast<std::uint32_t>(wants.size())};
    std::vector<std::uint32_t> marks = marks_.readAll<std::uint32_t>(patches_);
    for (const MemoryTwin::Want& want : wants) {
      list.push_back(want.patch);
      marks[want.patch] = frame_;
    }
    visible_.write(std::span<const std::uint32_t>(list));
    marks_.write(std::span<const std::uint32_t>(marks));
    const std::vector<std::uint32_t> groups = {
        static_cast<std::uint32_t>((wants.size() + RECT_GROUP - 1) / RECT_GROUP), 1, 1};
    dispatch_.write(std::span<const std::uint32_t>(groups));
    visible_.bindStorage(BIND_VISIBLE);
    marks_.bindStorage(BIND_VISIBLE_MARK);
  }
  [[nodiscard]] std::vector<glsl::PatchState> states() const {
    return memory.patchStates().readAll<glsl::PatchState>(patches_);
  }
  [[nodiscard]] const gl::Buffer& dispatch() const { return dispatch_; }
  [[nodiscard]] std::uint32_t number() const { return frame_; }
  [[nodiscard]] gl::ProgramCache& programs() { return programs_; }

  RectMemory memory;

 private:
  gl::ProgramCache programs_;
  std::uint32_t patches_;
  std::uint32_t frame_ = 0;
  gl::Buffer visible_;
  gl::Buffer marks_;
  gl::Buffer dispatch_;
};

/// What must hold of the visible patches after a frame, whatever was asked. Returns how many kept their place.
std::uint32_t checkVisible(const Scenario& scenario, const glsl::AtlasState& state, const Wants& wants,
                           const std::vector<glsl::PatchState>& before, std::uint32_t epochBefore,
                           const std::vector<glsl::PatchState>& after) {
  std::uint32_t kept = 0;
  std::uint32_t failed = 0;
  std::uint32_t records = 0;
  std::uint32_t texels = 0;
  std::map<std::uint32_t, std::uint32_t> recordTexels;
  for (const MemoryTwin::Want& want : wants) {
    const glsl::PatchState& now = after[want.patch];
    EXPECT_EQ(now.epoch, state.epoch);
    EXPECT_EQ(now.level & glsl::kLevelPending, 0u);
    const std::uint32_t level = want.w | (want.h << 4);
    if ((now.level & glsl::kLevelSize) != level) {
      EXPECT_EQ(now.level, 0u) << "patch " << want.patch << " has a level that it did not ask for";
      ++failed;
    }
    if (now.level == 0) {
      // Its own texel, in the rows below the superblocks.
      EXPECT_EQ(now.origin & 0xffffu, want.patch % scenario.width);
      EXPECT_EQ(now.origin >> 16, scenario.height + want.patch / scenario.width);
      ++records;
      continue;
    }
    texels += 1u << (want.w + want.h);
    const glsl::PatchState& old = before[want.patch];
    if (old.epoch != epochBefore || epochBefore != state.epoch || (old.level & glsl::kLevelSize) != level) continue;
    EXPECT_EQ(old.origin, now.origin) << "patch " << want.patch << " moved";
    ++kept;
  }
  EXPECT_EQ(failed, state.failures);
  EXPECT_EQ(records, state.records);
  EXPECT_EQ(texels, state.liveTexels);
  EXPECT_EQ(wants.size(), state.visible);
  return kept;
}

class GpuFrames : public test::GlTest, public ::testing::WithParamInterface<Scenario> {};

TEST_P(GpuFrames, InvariantsHoldAndCountersAreTheTwins) {
  const Scenario& scenario = GetParam();
  Feed feed(optionsOf(scenario), scenario.patches);
  MemoryTwin twin(scenario.width, scenario.height, scenario.superblockLog2, scenario.patches);
  FrameStream stream(scenario, 7);
  auto before = feed.states();
  glsl::AtlasState last = feed.memory.readState();
  std::uint64_t kept = 0;
  std::uint64_t failures = 0;
  int compared = 0;
  bool same = true;  // once a request failed, who holds blocks depends on the order of threads
  for (int frame = 0; frame < 1500; ++frame) {
    if (frame % 61 == 60 || (!same && frame % 5 == 0)) feed.memory.reset();
    const Wants wants = stream.next();
    feed.frame(wants, frame % 3 == 0);
    const glsl::AtlasState state = feed.memory.readState();
    const auto after = feed.states();
    kept += checkVisible(scenario, state, wants, before, last.epoch, after);
    failures += state.failures;
    const MemorySnapshot snapshot = feed.memory.readSnapshot();
    const auto partition = checkPartition(snapshot);
    ASSERT_TRUE(partition) << "frame " << frame << ": " << partition.error().message;
    ASSERT_EQ(snapshot.live.size() + state.records, wants.size()) << "an invisible patch holds a block";

    if (state.epoch != last.epoch) {
      twin.reset();
      same = true;
    }
    if (same) {
      ++compared;
      twin.frame(wants);
      ASSERT_EQ(state.failures, twin.failures());
      ASSERT_EQ(state.config.superblocks - state.superblocksUsed, twin.superblockStack().size());
      for (std::uint32_t w = 1; w <= scenario.superblockLog2; ++w) {
        ASSERT_EQ(state.widths[w].carryOffset, twin.column(w).carryOffset);
        ASSERT_EQ(state.widths[w].carrySuperblock, twin.column(w).carrySuperblock.value_or(glsl::kNoSuperblock));
        for (std::uint32_t h = 0; h <= w; ++h) {
          const glsl::LevelState& level = state.levels[glsl::levelIndex(w, h)];
          ASSERT_EQ(level.requested, 0u);
          ASSERT_EQ(level.slotCount, twin.level(w, h).slotCount) << "level " << w << ", " << h << ", frame " << frame;
          ASSERT_EQ(level.slotOffset, twin.level(w, h).slotOffset);
          ASSERT_EQ(level.stackCount, static_cast<int>(twin.level(w, h).stack.size()));
        }
      }
    }
    same = same && state.failures == 0;
    before = after;
    last = state;
    if (HasFailure()) FAIL() << "in frame " << frame;
  }
  EXPECT_GT(compared, 200);
  if (scenario.change < 1.0) {
    EXPECT_GT(kept, 0u);
  }
  if (scenario.demand > 1.0) {
    EXPECT_GT(failures, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Memory, GpuFrames, ::testing::ValuesIn(test::scenarios()), test::scenarioName);

}  // namespace
}  // namespace tessera
