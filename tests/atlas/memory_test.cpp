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

/// What must hold of the visible patches after a frame, whatever was asked. Returns how many kept their
/// place.
std::uint32_t checkVisible(const Scenario& scenario, const glsl::AtlasState& state,
                           const RectStatistics& statistics, const Wants& wants,
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
    if (old.epoch != epochBefore || epochBefore != state.epoch || (old.level & glsl::kLevelSize) != level)
      continue;
    EXPECT_EQ(old.origin, now.origin) << "patch " << want.patch << " moved";
    ++kept;
  }
  EXPECT_EQ(failed, state.failures);
  EXPECT_EQ(records, statistics.records);
  EXPECT_EQ(texels, statistics.liveTexels);
  EXPECT_EQ(texels + records, statistics.samples);
  EXPECT_EQ(wants.size(), statistics.visiblePatches);
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
  const int frames = scenario.patches > 5000 ? 300 : 1500;
  for (int frame = 0; frame < frames; ++frame) {
    if (frame % 61 == 60 || (!same && frame % 5 == 0)) feed.memory.reset();
    const Wants wants = stream.next();
    feed.frame(wants, frame % 3 == 0);
    const glsl::AtlasState state = feed.memory.readState();
    const RectStatistics statistics = feed.memory.readStatistics();
    const auto after = feed.states();
    kept += checkVisible(scenario, state, statistics, wants, before, last.epoch, after);
    failures += state.failures;
    const MemorySnapshot snapshot = feed.memory.readSnapshot();
    const auto partition = checkPartition(snapshot);
    ASSERT_TRUE(partition) << "frame " << frame << ": " << partition.error().message;
    ASSERT_EQ(snapshot.live.size() + statistics.records, wants.size()) << "an invisible patch holds a block";

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
        ASSERT_EQ(state.widths[w].carrySuperblock,
                  twin.column(w).carrySuperblock.value_or(glsl::kNoSuperblock));
        for (std::uint32_t h = 0; h <= w; ++h) {
          const glsl::LevelState& level = state.levels[glsl::levelIndex(w, h)];
          ASSERT_EQ(level.requested, 0u);
          ASSERT_EQ(level.slotCount, twin.level(w, h).slotCount)
              << "level " << w << ", " << h << ", frame " << frame;
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
  EXPECT_GT(compared, frames / 8);
  if (scenario.change < 1.0) {
    EXPECT_GT(kept, 0u);
  }
  if (scenario.demand > 1.0) {
    EXPECT_GT(failures, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Memory, GpuFrames, ::testing::ValuesIn(test::scenarios()), test::scenarioName);

// Mueller 2018, sec. 4.2, both forms (see memory_twin_test.cpp), on the provisioning shader alone.
class GpuWorkedExample : public test::GlTest {
 protected:
  glsl::AtlasState provision(glsl::uint squares, glsl::uint halves, glsl::uint quarters) {
    RectMemoryOptions options;
    options.width = options.height = 64;
    options.superblockLog2 = 3;
    Feed feed(options, 200);
    glsl::AtlasState state = feed.memory.readState();
    const glsl::uint requested[] = {quarters, halves, squares};  // by log2 of height
    const int stacks[] = {7, 7, 5};
    for (glsl::uint h = 0; h < 3; ++h) {
      state.levels[glsl::levelIndex(2, h)].requested = requested[h];
      state.levels[glsl::levelIndex(2, h)].stackCount = stacks[h];
    }
    state.widths[2].carryOffset = 3;
    state.widths[2].carrySuperblock = 0;
    state.superblocksUsed = 1;
    gl::Buffer states(std::span<const glsl::AtlasState>(&state, 1));
    const gl::Buffer stackEntries(65536);
    const gl::Buffer live(1024);
    feed.see({});
    states.bindStorage(BIND_ATLAS_STATE);
    stackEntries.bindStorage(BIND_ATLAS_STACKS);
    live.bindStorage(BIND_ATLAS_LIVE);
    auto program = feed.programs().get({"pass/rect_provision.comp"});
    EXPECT_TRUE(program);
    (*program)->use();
    gl::api().DispatchCompute(1, 1, 1);
    gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    state = states.readAll<glsl::AtlasState>(1)[0];
    for (glsl::uint h = 0; h < 2; ++h) {
      const auto& level = state.levels[glsl::levelIndex(2, h)];
      remainders[h] = stackEntries.readAll<glsl::uint>(1, 4 * (level.stackBase + 7))[0];
    }
    return state;
  }
  static void expect(const glsl::AtlasState& state, glsl::uint h, glsl::uint offset, glsl::uint count,
                     int stack) {
    const auto& level = state.levels[glsl::levelIndex(2, h)];
    EXPECT_EQ(level.slotOffset, offset) << "height 2^" << h;
    EXPECT_EQ(level.slotCount, count) << "height 2^" << h;
    EXPECT_EQ(level.stackCount, stack) << "height 2^" << h;
    EXPECT_EQ(level.requested, 0u);
  }
  glsl::uint remainders[2] = {};
};

TEST_F(GpuWorkedExample, AsTheTextCounts) {
  const glsl::AtlasState state = provision(7, 14, 10);
  expect(state, 2, 3, 2, 5);
  expect(state, 1, 10, 7, 8);
  expect(state, 0, 34, 3, 8);
  EXPECT_EQ(state.widths[2].sourceSuperblock, 0u);
  EXPECT_EQ(state.widths[2].firstPopped, 1u);
  EXPECT_EQ(state.widths[2].popped, 2u);
  EXPECT_EQ(state.superblocksUsed, 3u);
  EXPECT_EQ(state.widths[2].carryOffset, 2u);
  EXPECT_EQ(state.widths[2].carrySuperblock, 2u);
  EXPECT_EQ(remainders[0], glsl::packOrigin(16, 5));
  EXPECT_EQ(remainders[1], glsl::packOrigin(16, 6));
}

TEST_F(GpuWorkedExample, AsTheTablePrints) {
  const glsl::AtlasState state = provision(7, 16, 10);
  expect(state, 2, 3, 2, 5);
  expect(state, 1, 10, 9, 8);
  expect(state, 0, 38, 3, 8);
  EXPECT_EQ(state.widths[2].popped, 2u);
  EXPECT_EQ(state.widths[2].carryOffset, 3u);
}

class Memory : public test::GlTest {};

Wants wantAll(std::uint32_t count, std::uint32_t w, std::uint32_t h) {
  Wants wants;
  for (std::uint32_t i = 0; i < count; ++i) wants.push_back({i, w, h});
  return wants;
}

TEST_F(Memory, FullStacksRefuseToCut) {
  const Scenario scenario{
      .name = "small stacks", .width = 256, .height = 256, .superblockLog2 = 4, .patches = 600};
  RectMemoryOptions options = optionsOf(scenario);
  Feed feed(options, scenario.patches);
  // Room for a few blocks a level only. What the stacks cannot take must not be cut, and no entry may be
  // written past the end of a stack: the painter would find the blocks of the next stack overwritten.
  glsl::AtlasState state = feed.memory.readState();
  glsl::uint base = 0;
  for (glsl::uint l = 1; l < glsl::levelIndex(5, 0); ++l) {
    state.levels[l].stackCapacity = 1 + l % 7;
    state.levels[l].stackBase = base;
    base += state.levels[l].stackCapacity;
  }
  feed.memory.stateBuffer().writeValue(state);
  FrameStream stream(scenario, 3);
  std::uint64_t failures = 0;
  std::uint64_t given = 0;
  for (int frame = 0; frame < 300; ++frame) {
    feed.frame(stream.next());
    state = feed.memory.readState();
    failures += state.failures;
    given += feed.memory.readStatistics().liveTexels;
    for (glsl::uint l = 1; l < glsl::levelIndex(5, 0); ++l)
      ASSERT_LE(state.levels[l].existing, state.levels[l].stackCapacity) << "level " << l;
    const auto partition = checkPartition(feed.memory.readSnapshot());
    ASSERT_TRUE(partition) << "frame " << frame << ": " << partition.error().message;
  }
  EXPECT_GT(failures, 0u);
  EXPECT_GT(given, 0u);
}

TEST_F(Memory, StacksHoldWhatTheAreaOrThePatchesAllow) {
  RectMemoryOptions options;
  Feed few(options, 1000);
  Feed many(options, 130000);
  Feed most(options, 1000000);
  // 8 Mpix: a stack entry a block of one size; never more than tens of MB.
  EXPECT_LT(few.memory.bytes(), 1u << 20);
  EXPECT_LT(many.memory.bytes(), 16u << 20);
  EXPECT_LT(most.memory.bytes(), 96u << 20);
}

TEST_F(Memory, AreaOfTheSmallestBlocksFits) {
  // The whole atlas as 2 x 1, then as one block, back and forth: each level reaches its bound of area.
  RectMemoryOptions options = optionsOf({.name = "one", .superblockLog2 = 6});
  Feed feed(options, 2048);
  for (int frame = 0; frame < 6; ++frame) {
    feed.memory.reset();
    const bool small = frame % 2 == 0;
    feed.frame(small ? wantAll(2048, 1, 0) : wantAll(1, 6, 6));
    const RectStatistics statistics = feed.memory.readStatistics();
    EXPECT_EQ(statistics.failures, 0u);
    EXPECT_EQ(statistics.liveTexels, 4096u);
    EXPECT_EQ(statistics.load, 1.0f);
    EXPECT_TRUE(checkPartition(feed.memory.readSnapshot()));
  }
}

TEST_F(Memory, ABlockSeenTheOtherWayRoundStays) {
  Feed feed(optionsOf({}), 10);
  feed.frame({{3, 3, 1}}, false);
  const glsl::PatchState first = feed.states()[3];
  EXPECT_FALSE(glsl::levelTransposed(first.level));
  feed.frame({{3, 3, 1}}, true);
  const glsl::PatchState second = feed.states()[3];
  EXPECT_TRUE(glsl::levelTransposed(second.level));
  EXPECT_EQ(first.origin, second.origin);
}

TEST_F(Memory, HysteresisKeepsALevel) {
  RectMemoryOptions options = optionsOf({});
  options.hysteresis = 0.25f;
  Feed feed(options, 4);
  const auto levelFor = [&](float logArea) {
    feed.frame({{1, 0, 0}}, std::vector<glsl::PatchMeasure>{{logArea, 0.0f}});
    const auto level = feed.states()[1].level;
    return glsl::levelWidth(level) + glsl::levelHeight(level);
  };
  EXPECT_EQ(levelFor(4.0f), 4u);
  EXPECT_EQ(levelFor(4.7f), 4u);
  EXPECT_EQ(levelFor(4.8f), 5u);
  EXPECT_EQ(levelFor(4.3f), 5u);
  EXPECT_EQ(levelFor(4.2f), 4u);
  feed.memory.reset();  // nothing is remembered across a reset
  EXPECT_EQ(levelFor(4.7f), 5u);
}

TEST_F(Memory, AResetMovesEverythingToFreshMemory) {
  Feed feed(optionsOf({}), 100);
  // Leave garbage: blocks of one size only, then another size.
  feed.frame(wantAll(64, 3, 2));
  feed.frame(wantAll(20, 3, 3));
  EXPECT_GT(feed.memory.readStatistics().stackTexels, 0u);
  const auto epoch = feed.memory.readState().epoch;
  feed.memory.reset();
  feed.frame(wantAll(20, 3, 3));
  const RectStatistics statistics = feed.memory.readStatistics();
  EXPECT_EQ(feed.memory.readState().epoch, epoch + 1);
  EXPECT_EQ(statistics.resets, 1u);
  EXPECT_EQ(statistics.stackTexels, 0u);
  EXPECT_EQ(statistics.liveTexels, 20u * 64u);
  EXPECT_EQ(statistics.freeSuperblocks, 44u);
  feed.frame(wantAll(20, 3, 3));
  EXPECT_EQ(feed.memory.readStatistics().resets, 1u) << "one call, one reset";
}

TEST_F(Memory, PassingTheHighWaterMarkResets) {
  RectMemoryOptions options = optionsOf({});
  options.highWater = 0.9f;
  Feed feed(options, 100);
  feed.frame(wantAll(32, 3, 3));  // half the atlas
  feed.frame(wantAll(60, 3, 2));  // nearly the other half; the first half lies on the stack
  EXPECT_GT(feed.memory.readStatistics().load, 0.9f);
  EXPECT_EQ(feed.memory.readStatistics().resets, 0u);
  feed.frame(wantAll(60, 3, 2));
  EXPECT_EQ(feed.memory.readStatistics().resets, 1u);
  EXPECT_LT(feed.memory.readStatistics().load, 0.6f);
  for (int i = 0; i < 10; ++i) feed.frame(wantAll(60, 3, 2));
  EXPECT_EQ(feed.memory.readStatistics().resets, 1u);
}

TEST_F(Memory, HopelessDemandDoesNotResetEveryFrame) {
  RectMemoryOptions options = optionsOf({});  // 64 superblocks of 8 x 8
  Feed feed(options, 640);
  for (int frame = 0; frame < 200; ++frame) {
    feed.frame(wantAll(640, 3, 3));
    EXPECT_EQ(feed.memory.readStatistics().failures, 640u - 64u);
  }
  // Waits of 1, 2, 4, ... 64 frames.
  EXPECT_GE(feed.memory.readStatistics().resets, 5u);
  EXPECT_LE(feed.memory.readStatistics().resets, 9u);
  // Once demand fits, a calm frame makes the next reset prompt again.
  feed.frame(wantAll(10, 3, 3));
  feed.frame(wantAll(10, 3, 3));
  const auto resets = feed.memory.readStatistics().resets;
  feed.frame(wantAll(640, 3, 3));
  feed.frame(wantAll(640, 3, 3));
  EXPECT_EQ(feed.memory.readStatistics().resets, resets + 1);
}

TEST_F(Memory, BadOptionsAreNamed) {
  gl::ProgramCache programs(test::context());
  const auto message = [&](auto change, std::uint32_t patches = 10) {
    RectMemoryOptions options;
    change(options);
    auto made = RectMemory::create(programs, options, patches);
    return made ? std::string() : made.error().message;
  };
  EXPECT_EQ(message([](RectMemoryOptions&) {}), "");
  EXPECT_NE(message([](RectMemoryOptions& o) { o.superblockLog2 = 11; }).find("2^11"), std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.width = 1000; }).find("1000"), std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.height = 0; }).find("0 texels"), std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.width = 32768; }).find("32768"), std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.bias = std::nanf(""); }).find("bias is nan"),
            std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.targetShare = 0.0f; }).find("targetShare"),
            std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.hysteresis = 3.0f; }).find("hysteresis"), std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions&) {}, 5000000).find("5000000"), std::string::npos);
}

}  // namespace
}  // namespace tessera
