#include "atlas/rect/memory.hpp"

#include <chrono>
#include <cstddef>
#include <map>
#include <thread>

#include "glsl/shared/bindings.h"
#include "tests/atlas/memory_scenarios.hpp"
#include "tests/atlas/visible_feed.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

using test::FrameStream;
using test::Scenario;
using test::VisibleFeed;
using Wants = std::vector<MemoryTwin::Want>;

RectMemoryOptions optionsOf(const Scenario& scenario, const test::Mode& mode = {}) {
  RectMemoryOptions options;
  options.width = static_cast<int>(scenario.width);
  options.height = static_cast<int>(scenario.height);
  options.superblockLog2 = static_cast<int>(scenario.superblockLog2);
  options.pressureBias = false;
  options.hysteresis = -1.0f;
  options.highWater = 1.0f;
  options.strategy = mode.columns ? AtlasStrategy::S0 : mode.stacks ? AtlasStrategy::S1 : AtlasStrategy::S2;
  options.merge = mode.merge;
  options.mergeShare = 0.0f;
  return options;
}

/// Feeds visible lists to a RectMemory, with measures that ask for exactly the wanted levels.
class Feed {
 public:
  Feed(const RectMemoryOptions& options, std::uint32_t patches)
      : programs_(test::context()), patches_(patches), visible_(patches) {
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
    memory.allocate(visible_.dispatch(), visible_.frame());
  }
  /// Uploads a visible list and binds it; the next calls use it.
  void see(const Wants& wants) {
    std::vector<std::uint32_t> list;
    for (const MemoryTwin::Want& want : wants) list.push_back(want.patch);
    visible_.see(list);
  }
  [[nodiscard]] std::vector<glsl::PatchState> states() const {
    return memory.patchStates().readAll<glsl::PatchState>(patches_);
  }
  [[nodiscard]] const gl::Buffer& dispatch() const { return visible_.dispatch(); }
  [[nodiscard]] std::uint32_t number() const { return visible_.frame(); }
  [[nodiscard]] gl::ProgramCache& programs() { return programs_; }

  RectMemory memory;

 private:
  gl::ProgramCache programs_;
  std::uint32_t patches_;
  VisibleFeed visible_;
};

/// What must hold of the visible patches after a frame, whatever was asked. Returns how many kept their
/// place.
std::uint32_t checkVisible(const Scenario& scenario, const glsl::AtlasState& state,
                           const RectStatistics& statistics, const Wants& wants,
                           const std::vector<glsl::PatchState>& before, std::uint32_t epochBefore,
                           const std::vector<glsl::PatchState>& after) {
  std::uint32_t kept = 0;
  std::uint32_t reduced = 0;
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
      // Smaller than asked for, but only for want of memory.
      const bool smaller = glsl::levelWidth(now.level) <= want.w && glsl::levelHeight(now.level) <= want.h;
      EXPECT_TRUE(now.level == 0 || (smaller && state.config.merges != 0))
          << "patch " << want.patch << " has a level that it did not ask for";
      ++(now.level == 0 ? failed : reduced);
    }
    if (now.level == 0) {
      // Its own texel, in the rows below the superblocks.
      EXPECT_EQ(now.origin & 0xffffu, want.patch % scenario.width);
      EXPECT_EQ(now.origin >> 16, scenario.height + want.patch / scenario.width);
      ++records;
      continue;
    }
    texels += glsl::levelTexels(now.level);
    const glsl::PatchState& old = before[want.patch];
    if (old.epoch != epochBefore || epochBefore != state.epoch || (old.level & glsl::kLevelSize) != level)
      continue;
    EXPECT_EQ(old.origin, now.origin) << "patch " << want.patch << " moved";
    ++kept;
  }
  EXPECT_EQ(failed, state.events.failures);
  EXPECT_EQ(reduced, state.events.reduced + state.events.waiting);
  EXPECT_EQ(records, statistics.records);
  EXPECT_EQ(texels, statistics.liveTexels);
  EXPECT_EQ(texels + records, statistics.samples);
  EXPECT_EQ(wants.size(), statistics.visiblePatches);
  return kept;
}

class GpuFrames : public test::GlTest, public ::testing::WithParamInterface<test::FrameCase> {};

TEST_P(GpuFrames, InvariantsHoldAndCountersAreTheTwins) {
  const auto& [scenario, mode] = GetParam();
  Feed feed(optionsOf(scenario, mode), scenario.patches);
  MemoryTwin twin(scenario.width, scenario.height, scenario.superblockLog2, scenario.patches,
                  {mode.columns, mode.stacks, mode.merge});
  // Which blocks lie on the stacks depends on the order of threads, and so does what merges and what is lost.
  const bool counted = mode.stacks && !mode.merge;
  FrameStream stream(scenario, 7);
  auto before = feed.states();
  glsl::AtlasState last = feed.memory.readState();
  std::uint64_t kept = 0;
  std::uint64_t failures = 0;
  int compared = 0;
  bool same = counted;  // once a request failed, who holds blocks depends on the order of threads
  const int frames = test::framesOf(scenario, 800, 6000);
  for (int frame = 0; frame < frames; ++frame) {
    if (frame % 61 == 60 || (counted && !same && frame % 5 == 0)) feed.memory.reset();
    const Wants wants = stream.next();
    feed.frame(wants, frame % 3 == 0);
    const glsl::AtlasState state = feed.memory.readState();
    const RectStatistics statistics = feed.memory.readStatistics();
    const auto after = feed.states();
    kept += checkVisible(scenario, state, statistics, wants, before, last.epoch, after);
    failures += state.events.failures;
    const MemorySnapshot snapshot = feed.memory.readSnapshot();
    const auto partition = checkPartition(snapshot);
    ASSERT_TRUE(partition) << "frame " << frame << ": " << partition.error().message;
    ASSERT_EQ(snapshot.live.size() + statistics.records, wants.size()) << "an invisible patch holds a block";

    if (state.epoch != last.epoch) {
      twin.reset();
      same = counted;
    }
    if (same) {
      ++compared;
      twin.frame(wants);
      ASSERT_EQ(state.events.failures, twin.failures());
      ASSERT_EQ(state.superblocksFree, twin.superblockStack().size());
      for (std::uint32_t w = 1; w <= scenario.superblockLog2; ++w)
        for (std::uint32_t h = 0; h <= w; ++h) {
          const glsl::BinState& bin = state.bins[glsl::binOf(state.config, w, h)];
          ASSERT_EQ(bin.carryOffset, twin.bin(w, h).carryOffset);
          ASSERT_EQ(bin.carrySuperblock, twin.bin(w, h).carrySuperblock.value_or(glsl::kNoSuperblock));
          const glsl::LevelState& level = state.levels[glsl::levelIndex(w, h)];
          ASSERT_EQ(level.requested, 0u);
          ASSERT_EQ(level.slotCount, twin.level(w, h).slotCount)
              << "level " << w << ", " << h << ", frame " << frame;
          ASSERT_EQ(level.slotOffset, twin.level(w, h).slotOffset);
          ASSERT_EQ(level.stackCount, static_cast<int>(twin.level(w, h).stack.size()));
        }
    }
    same = same && state.events.failures == 0;
    before = after;
    last = state;
    if (HasFailure()) FAIL() << "in frame " << frame;
  }
  if (counted) {
    EXPECT_GT(compared, frames / 8);
  }
  if (scenario.change < 1.0) {
    EXPECT_GT(kept, 0u);
  }
  if (scenario.demand > 1.0) {
    EXPECT_GT(failures, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Memory, GpuFrames,
                         ::testing::Combine(::testing::ValuesIn(test::scenarios()),
                                            ::testing::ValuesIn(test::modes())),
                         test::caseName);

// Mueller 2018, sec. 4.2, both forms (see memory_twin_test.cpp), on the provisioning shader alone.
class GpuWorkedExample : public test::GlTest {
 protected:
  glsl::AtlasState provision(glsl::uint squares, glsl::uint halves, glsl::uint quarters) {
    RectMemoryOptions options;
    options.width = options.height = 64;
    options.superblockLog2 = 3;
    options.merge = false;
    Feed feed(options, 200);
    glsl::AtlasState state = feed.memory.readState();
    const glsl::uint requested[] = {quarters, halves, squares};  // by log2 of height
    const int stacks[] = {7, 7, 5};
    for (glsl::uint h = 0; h < 3; ++h) {
      state.levels[glsl::levelIndex(2, h)].requested = requested[h];
      state.levels[glsl::levelIndex(2, h)].stackCount = stacks[h];
    }
    state.bins[2].carryOffset = 3;
    state.bins[2].carrySuperblock = 0;
    state.superblocksFree = 63;
    std::vector<glsl::uint> free(128, 0);
    for (glsl::uint i = 0; i < 64; ++i) free[i] = 63 - i;
    const gl::Buffer superblocks(free);
    gl::Buffer states(std::span<const glsl::AtlasState>(&state, 1));
    const gl::Buffer stackEntries(65536);
    const gl::Buffer live(1024);
    feed.see({});
    states.bindStorage(BIND_ATLAS_STATE);
    stackEntries.bindStorage(BIND_ATLAS_STACKS);
    live.bindStorage(BIND_ATLAS_LIVE);
    superblocks.bindStorage(BIND_ATLAS_SUPERBLOCKS);
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
  EXPECT_EQ(state.bins[2].sourceSuperblock, 0u);
  EXPECT_EQ(state.bins[2].firstPopped, 62u);  // the stack's top
  EXPECT_EQ(state.bins[2].popped, 2u);
  EXPECT_EQ(state.superblocksFree, 61u);
  EXPECT_EQ(state.bins[2].carryOffset, 2u);
  EXPECT_EQ(state.bins[2].carrySuperblock, 2u);
  EXPECT_EQ(remainders[0], glsl::packOrigin(16, 5));
  EXPECT_EQ(remainders[1], glsl::packOrigin(16, 6));
}

TEST_F(GpuWorkedExample, AsTheTablePrints) {
  const glsl::AtlasState state = provision(7, 16, 10);
  expect(state, 2, 3, 2, 5);
  expect(state, 1, 10, 9, 8);
  expect(state, 0, 38, 3, 8);
  EXPECT_EQ(state.bins[2].popped, 2u);
  EXPECT_EQ(state.bins[2].carryOffset, 3u);
}

class Memory : public test::GlTest {};

Wants wantAll(std::uint32_t count, std::uint32_t w, std::uint32_t h) {
  Wants wants;
  for (std::uint32_t i = 0; i < count; ++i) wants.push_back({i, w, h});
  return wants;
}

void fullStacksRefuse(bool merge) {
  const Scenario scenario{
      .name = "small stacks", .width = 256, .height = 256, .superblockLog2 = 4, .patches = 600};
  RectMemoryOptions options = optionsOf(scenario, {.name = "", .merge = merge});
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
    failures += state.events.failures;
    given += feed.memory.readStatistics().liveTexels;
    for (glsl::uint l = 1; l < glsl::levelIndex(5, 0); ++l)
      ASSERT_LE(state.levels[l].existing, state.levels[l].stackCapacity) << "level " << l;
    const auto partition = checkPartition(feed.memory.readSnapshot());
    ASSERT_TRUE(partition) << "frame " << frame << ": " << partition.error().message;
  }
  EXPECT_GT(failures, 0u);
  EXPECT_GT(given, 0u);
}

TEST_F(Memory, FullStacksRefuseToCut) { fullStacksRefuse(false); }
TEST_F(Memory, FullStacksRefuseToMergeAndToCut) { fullStacksRefuse(true); }

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

TEST_F(Memory, MergingGivesSuperblocksBackAndCutsThemForOthers) {
  const test::Mode merging{.name = "merging", .merge = true};
  Feed feed(optionsOf({}, merging), 1000);  // 64 superblocks of 8 x 8
  feed.frame(wantAll(1000, 2, 0));          // 4 x 1: 63 superblocks
  EXPECT_EQ(feed.memory.readStatistics().freeSuperblocks, 1u);
  feed.frame({});
  std::uint32_t merged = 0;
  for (int i = 0; i < 10; ++i) {
    feed.frame({});
    merged += feed.memory.readStatistics().blocksMerged;
    ASSERT_TRUE(checkPartition(feed.memory.readSnapshot()));
  }
  // 8 x 8 texels each: but the last superblock is still carried.
  EXPECT_EQ(feed.memory.readStatistics().freeSuperblocks, 63u);
  EXPECT_EQ(merged, 62u * (8 + 4 + 1) + 4 + 2);
  feed.frame(wantAll(63, 3, 3));
  EXPECT_EQ(feed.memory.readStatistics().failures, 0u);

  Feed cut(optionsOf({}, merging), 1000);
  cut.frame(wantAll(64, 3, 3));
  cut.frame(wantAll(1, 3, 3));
  cut.frame(wantAll(1000, 2, 0));  // 62.5 of the 63 free large blocks
  EXPECT_EQ(cut.memory.readStatistics().failures, 0u);
  EXPECT_TRUE(checkPartition(cut.memory.readSnapshot()));
  Feed whole(optionsOf({}), 1000);
  whole.frame(wantAll(64, 3, 3));
  whole.frame(wantAll(1, 3, 3));
  whole.frame(wantAll(1000, 2, 0));
  EXPECT_EQ(whole.memory.readStatistics().failures, 1000u) << "without cutting none of them fits";
}

TEST_F(Memory, ASmallerBlockKeepsTheShape) {
  Feed feed(optionsOf({}, {.name = "merging", .merge = true}), 200);  // 64 superblocks of 8 x 8
  Wants wants = wantAll(63, 3, 3);
  for (std::uint32_t i = 100; i < 102; ++i) wants.push_back({i, 2, 1});
  for (std::uint32_t i = 102; i < 104; ++i) wants.push_back({i, 2, 0});
  feed.frame(wants);
  wants.resize(63);
  wants.push_back({110, 3, 2});  // free are blocks of 4 x 2 and of 4 x 1, and no superblock
  feed.frame(wants);
  EXPECT_EQ(feed.states()[110].level & glsl::kLevelSize, glsl::packLevel(2, 1, false));
}

TEST_F(Memory, AResetForgetsWhatWasLiveInSuperblocks) {
  Feed feed(optionsOf({}, {.name = "S2", .columns = false, .stacks = false}), 100);
  feed.frame(wantAll(20, 3, 3));
  feed.memory.reset();
  feed.frame(wantAll(20, 3, 3));
  feed.frame({});
  EXPECT_EQ(feed.memory.readStatistics().freeSuperblocks, 63u) << "all but the one that is being filled";
}

TEST_F(Memory, BlocksThatAreAskedForAreNotCut) {
  Feed feed(optionsOf({}, {.name = "merging", .merge = true}), 200);  // 64 superblocks of 8 x 8
  feed.frame(wantAll(64, 3, 3));
  Wants wants = wantAll(63, 3, 3);
  wants.push_back({100, 3, 3});
  for (std::uint32_t i = 101; i < 105; ++i) wants.push_back({i, 2, 2});
  feed.frame(wants);
  // One block came free: it is for the patch that wants all of it, not for the four that want a quarter.
  EXPECT_EQ(feed.states()[100].level & glsl::kLevelSize, glsl::packLevel(3, 3, false));
  EXPECT_EQ(feed.memory.readStatistics().failures, 4u);
}

TEST_F(Memory, NothingIsCutThatItsStackCannotHold) {
  Feed feed(optionsOf({}, {.name = "merging", .merge = true}), 200);
  feed.frame(wantAll(1, 3, 3));
  glsl::AtlasState state = feed.memory.readState();
  const glsl::uint quarter = glsl::levelIndex(2, 2);
  state.levels[quarter].stackCapacity = 3;
  feed.memory.stateBuffer().writeValue(state);
  Wants wants;
  for (std::uint32_t i = 100; i < 104; ++i) wants.push_back({i, 2, 2});
  feed.frame(wants);
  state = feed.memory.readState();
  EXPECT_EQ(state.levels[quarter].existing, 2u) << "one less than the stack holds, from a superblock";
  EXPECT_EQ(state.events.failures, 2u);
  EXPECT_EQ(state.levels[glsl::levelIndex(3, 3)].stackCount, 1);
  EXPECT_TRUE(checkPartition(feed.memory.readSnapshot()));
}

TEST_F(Memory, ACameraThatJumpsFindsMemoryPackedAfresh) {
  for (const bool held : {false, true}) {
    Feed feed(optionsOf({}), 200);  // 64 superblocks of 8 x 8
    feed.memory.holdReset(held);
    feed.frame(wantAll(60, 3, 3));
    Wants others;
    for (std::uint32_t i = 100; i < 160; ++i) others.push_back({i, 3, 2});
    // What the measuring pass would say: all of them are new.
    glsl::IdealSum sum{};
    sum.low = sum.newLow = 60 * 32;
    feed.memory.stateBuffer().writeValue(sum, offsetof(glsl::AtlasState, ideal));
    feed.frame(others);
    const RectStatistics now = feed.memory.readStatistics();
    EXPECT_EQ(now.resets, held ? 0u : 1u);
    EXPECT_EQ(now.failures, held ? 60u - 8u : 0u);
    EXPECT_EQ(feed.memory.readState().ideal[0].newLow, 0u);
    if (held) continue;
    // What fits beside the others does not move them.
    sum.newLow = 16 * 64;
    feed.memory.stateBuffer().writeValue(sum, offsetof(glsl::AtlasState, ideal));
    feed.frame(others);
    EXPECT_EQ(feed.memory.readStatistics().resets, 1u);
  }
}

TEST_F(Memory, WantOfMemoryGivesASmallerBlock) {
  Feed feed(optionsOf({}, {.name = "merging", .merge = true}), 200);  // 64 superblocks of 8 x 8
  feed.frame(wantAll(20, 1, 0));                                      // one superblock
  Wants wants = wantAll(63, 3, 3);
  for (std::uint32_t i = 100; i < 104; ++i) wants.push_back({i, 2, 2});
  feed.frame(wants);
  RectStatistics now = feed.memory.readStatistics();
  EXPECT_EQ(now.failures, 0u);
  EXPECT_EQ(now.blocksReduced, 1u);
  EXPECT_TRUE(checkPartition(feed.memory.readSnapshot()));
  EXPECT_EQ(now.blocksWaiting, 0u);
  // While the reset that follows is held back, it stays where it is.
  const auto before = feed.states();
  feed.memory.holdReset(true);
  for (int i = 0; i < 3; ++i) {
    feed.frame(wants);
    now = feed.memory.readStatistics();
    EXPECT_EQ(now.blocksReduced, 0u) << "that was in an earlier frame";
    EXPECT_EQ(now.blocksWaiting, 1u);
    EXPECT_EQ(now.blocksMade, 0u);
    EXPECT_TRUE(now.resetPending);
    for (const MemoryTwin::Want& want : wants)
      EXPECT_EQ(feed.states()[want.patch].origin, before[want.patch].origin);
  }
  feed.memory.holdReset(false);
  feed.frame(wants);
  now = feed.memory.readStatistics();
  EXPECT_EQ(now.resets, 1u);
  EXPECT_EQ(now.blocksReduced + now.blocksWaiting, 0u);
  EXPECT_EQ(now.liveTexels, 63u * 64u + 4 * 16u);
}

TEST_F(Memory, WhatWaitsDuringAHoldGetsMemoryThatComesFree) {
  RectMemoryOptions options = optionsOf({}, {.name = "merging", .merge = true});
  options.pressureBias = true;  // nothing is measured, so the bias stays 0; S is what is looked at
  Feed feed(options, 200);      // 64 superblocks of 8 x 8
  feed.memory.holdReset(true);
  feed.frame(wantAll(20, 1, 0));  // one superblock
  Wants wants = wantAll(63, 3, 3);
  for (std::uint32_t i = 100; i < 104; ++i) wants.push_back({i, 2, 2});
  const float start = feed.memory.readStatistics().target;
  for (int i = 0; i < 30; ++i) feed.frame(wants);
  RectStatistics now = feed.memory.readStatistics();
  EXPECT_EQ(now.blocksWaiting, 1u);
  EXPECT_EQ(now.target, start * options.targetCut) << "S was cut each time that the patch waited";
  EXPECT_TRUE(now.resetPending);
  const auto before = feed.states();
  // A block of 8 x 8 comes free. Whether the patch sees it in the same frame depends on the order of threads.
  wants.erase(wants.begin());
  std::uint32_t made = 0;
  for (int i = 0; i < 2; ++i) {
    feed.frame(wants);
    made += feed.memory.readStatistics().blocksMade;
  }
  now = feed.memory.readStatistics();
  EXPECT_EQ(now.blocksWaiting, 0u);
  EXPECT_EQ(made, 1u);
  EXPECT_EQ(now.liveTexels, 62u * 64u + 4 * 16u);
  const auto after = feed.states();
  for (const MemoryTwin::Want& want : wants) {
    EXPECT_EQ(after[want.patch].level, glsl::packLevel(want.w, want.h, false));
    if ((before[want.patch].level & glsl::kLevelReduced) == 0) {
      EXPECT_EQ(after[want.patch].origin, before[want.patch].origin);
    }
  }
  EXPECT_TRUE(checkPartition(feed.memory.readSnapshot()));
  feed.frame(wants);
  now = feed.memory.readStatistics();
  EXPECT_EQ(now.resets, 0u);
  EXPECT_FALSE(now.resetPending) << "nothing is left for a reset to mend";
}

TEST_F(Memory, TexelsOfEveryKindAddUp) {
  for (const test::Mode& mode : test::modes()) {
    const Scenario scenario{.name = "sum", .width = 128, .patches = 800, .demand = 0.6};
    Feed feed(optionsOf(scenario, mode), scenario.patches);
    FrameStream stream(scenario, 11);
    std::map<std::uint32_t, glsl::PatchState> held;
    std::uint64_t lost = 0;
    std::uint32_t resets = 0;
    for (int frame = 0; frame < 100; ++frame) {
      if (frame == 50) feed.memory.reset();
      const Wants wants = stream.next();
      feed.frame(wants);
      const RectStatistics now = feed.memory.readStatistics();
      const bool reset = now.resets != std::exchange(resets, now.resets);
      EXPECT_EQ(now.liveTexels + now.endTexels + now.stackTexels + now.inaccessibleTexels + now.freeTexels,
                64u * 128u)
          << mode.name << ", frame " << frame;
      if (mode.stacks) {
        EXPECT_EQ(now.inaccessibleTexels, 0u);
      }
      lost += now.inaccessibleTexels;
      // Blocks made, moved and freed, counted from what patches hold.
      const auto states = feed.states();
      std::map<std::uint32_t, glsl::PatchState> holds;
      std::uint32_t made = 0;
      std::uint32_t moved = 0;
      std::uint64_t movedTexels = 0;
      for (const MemoryTwin::Want& want : wants) {
        const glsl::PatchState& state = states[want.patch];
        if (glsl::levelWidth(state.level) > 0) holds[want.patch] = state;
        const auto before = held.find(want.patch);
        const bool kept = before != held.end() && !reset && before->second.epoch == state.epoch &&
                          before->second.level == state.level &&
                          (state.level & glsl::kLevelSize) == (want.w | want.h << 4) &&
                          before->second.origin == state.origin;
        if (glsl::levelWidth(state.level) > 0 && !kept) ++made;
        if (before != held.end() && want.w > 0 && !kept) {
          ++moved;
          movedTexels += 1u << (want.w + want.h);
        }
      }
      std::uint32_t freed = 0;
      for (const auto& [patch, state] : held) {
        const auto wanted =
            std::find_if(wants.begin(), wants.end(), [&](const auto& w) { return w.patch == patch; });
        // A reset takes blocks from the invisible without giving them back one by one.
        if (wanted == wants.end() ? !reset : wanted->w == 0) ++freed;
      }
      EXPECT_EQ(now.blocksMade, made) << mode.name << ", frame " << frame;
      EXPECT_EQ(now.blocksMoved, moved) << mode.name << ", frame " << frame;
      EXPECT_EQ(now.movedTexels, movedTexels) << mode.name << ", frame " << frame;
      EXPECT_EQ(now.blocksFreed, freed) << mode.name << ", frame " << frame;
      held = std::move(holds);
      if (HasFailure()) return;
    }
    EXPECT_EQ(lost > 0, !mode.stacks);
  }
}

TEST_F(Memory, ResetsCanBeHeldBack) {
  RectMemoryOptions options = optionsOf({});
  options.highWater = 0.5f;
  Feed feed(options, 100);
  feed.memory.holdReset(true);
  for (int i = 0; i < 5; ++i) feed.frame(wantAll(40, 3, 3));
  EXPECT_EQ(feed.memory.readStatistics().resets, 0u);
  EXPECT_TRUE(feed.memory.readStatistics().resetPending);
  feed.memory.holdReset(false);
  feed.frame(wantAll(40, 3, 3));
  EXPECT_EQ(feed.memory.readStatistics().resets, 1u);
  for (int i = 0; i < 3; ++i) feed.frame({});
  const auto resets = feed.memory.readStatistics().resets;
  feed.memory.holdReset(true);
  feed.memory.reset();
  feed.frame(wantAll(4, 3, 3));
  EXPECT_EQ(feed.memory.readStatistics().resets, resets);
  EXPECT_TRUE(feed.memory.readStatistics().resetPending);
  feed.memory.holdReset(false);
  feed.frame(wantAll(4, 3, 3));
  EXPECT_EQ(feed.memory.readStatistics().resets, resets + 1) << "what was asked for is not forgotten";
  EXPECT_FALSE(feed.memory.readStatistics().resetPending);
}

TEST_F(Memory, StatisticsComeWithoutWaiting) {
  Feed feed(optionsOf({}), 100);
  EXPECT_FALSE(feed.memory.latestStatistics());
  std::uint32_t newest = 0;
  std::uint32_t frame = 0;
  const auto look = [&] {
    feed.frame(wantAll(++frame % 50, 3, 2));
    gl::api().Flush();
    const auto latest = feed.memory.latestStatistics();
    EXPECT_TRUE(latest || newest == 0) << "there were some";
    if (!latest) return;
    EXPECT_LE(latest->frames, frame);
    EXPECT_GE(latest->frames, newest);
    EXPECT_EQ(latest->visiblePatches, latest->frames % 50);
    EXPECT_EQ(latest->liveTexels, latest->visiblePatches * 32u);
    newest = latest->frames;
  };
  while (frame < 20) look();
  // Those of the last frame come, too. Where they may be left out (the GPU is far behind), those of a next
  // one.
  for (int tries = 0; tries < 5000 && newest < frame; ++tries) {
    gl::api().Finish();
    // The fence of what Finish waited for may be seen as passed only a little later: zink does so.
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    look();
  }
  EXPECT_EQ(newest, frame);
}

TEST_F(Memory, BlocksStayInTheirRange) {
  RectMemoryOptions options = optionsOf({});
  options.smallestLog2 = 1;
  options.largestLog2 = 2;
  options.aspectLog2 = 1;
  Feed feed(options, 100);
  Wants wants;
  for (std::uint32_t w = 0; w <= 3; ++w)
    for (std::uint32_t h = 0; h <= w; ++h) wants.push_back({static_cast<std::uint32_t>(wants.size()), w, h});
  feed.frame(wants);
  const auto states = feed.states();
  for (const MemoryTwin::Want& want : wants) {
    const glsl::uint level = states[want.patch].level;
    EXPECT_GE(glsl::levelHeight(level), 1u);
    EXPECT_LE(glsl::levelWidth(level), 2u);
    EXPECT_LE(glsl::levelWidth(level) - glsl::levelHeight(level), 1u);
  }
  EXPECT_EQ(feed.memory.readStatistics().records, 0u);
}

// Every size of the smallest block in every strategy: levels lie in the range, the counters are the twin's.
TEST_F(Memory, EverySmallestBlockWorks) {
  struct Case {
    Scenario scenario;
    int frames = 0;
  };
  const Case cases[] = {
      {{.name = "many", .width = 128, .height = 128, .superblockLog2 = 5, .patches = 400}, 30},
      {{.name = "few", .width = 2048, .height = 1024, .superblockLog2 = 10, .patches = 8}, 4}};
  std::mt19937 random(4);
  for (const auto& [scenario, frames] : cases)
    for (const test::Mode& mode : test::modes())
      for (std::uint32_t smallest = 0; smallest <= scenario.superblockLog2; ++smallest) {
        SCOPED_TRACE(mode.name + ", blocks of 2^" + std::to_string(smallest) +
                     " and more in superblocks of 2^" + std::to_string(scenario.superblockLog2));
        RectMemoryOptions options = optionsOf(scenario, mode);
        options.smallestLog2 = static_cast<int>(smallest);
        Feed feed(options, scenario.patches);
        const glsl::AtlasConfig config = feed.memory.readState().config;
        MemoryTwin twin(scenario.width, scenario.height, scenario.superblockLog2, scenario.patches,
                        {mode.columns, mode.stacks, mode.merge});
        const float mean = std::log2(static_cast<float>(scenario.width * scenario.height / scenario.patches));
        std::uint32_t given = 0;
        bool same = mode.stacks && !mode.merge;
        for (int frame = 0; frame < frames; ++frame) {
          Wants wants;
          std::vector<glsl::PatchMeasure> measures;
          for (std::uint32_t patch = 0; patch < scenario.patches; ++patch) {
            if (random() % 3 == 0) continue;
            const auto between = [&](float low, float high) {
              return std::uniform_real_distribution<float>(low, high)(random);
            };
            measures.push_back({mean + between(-4.0f, 2.0f), between(-4.0f, 4.0f)});
            const glsl::uint level = glsl::selectLevel(measures.back(), 0.0f, 0.0f, config.range, 0, -1.0f);
            wants.push_back({patch, glsl::levelWidth(level), glsl::levelHeight(level)});
          }
          feed.frame(wants, measures);
          const glsl::AtlasState state = feed.memory.readState();
          const auto states = feed.states();
          std::uint32_t without = 0;
          for (const MemoryTwin::Want& want : wants) {
            const glsl::uint level = states[want.patch].level;
            if (level == 0)
              without += want.w > 0 ? 1 : 0;
            else
              ASSERT_GE(glsl::levelHeight(level), smallest);
          }
          ASSERT_EQ(without, state.events.failures);
          const RectStatistics now = feed.memory.readStatistics();
          given += now.visiblePatches - now.records;
          const auto partition = checkPartition(feed.memory.readSnapshot());
          ASSERT_TRUE(partition) << "frame " << frame << ": " << partition.error().message;
          if (state.pressure.reset != 0) twin.reset();
          if (!same) continue;
          twin.frame(wants);
          ASSERT_EQ(state.events.failures, twin.failures());
          ASSERT_EQ(state.superblocksFree, twin.superblockStack().size());
          same = twin.failures() == 0;
        }
        EXPECT_GT(given, 0u);
      }
  // What the smallest blocks take may pass 32 bits.
  RectMemoryOptions options = optionsOf(cases[1].scenario);
  options.smallestLog2 = 10;
  options.pressureBias = true;
  Feed feed(options, 8);
  glsl::IdealSum sum{};
  sum.low = 1u << 20;
  sum.ones = 1u << 12;
  feed.memory.stateBuffer().writeValue(sum, offsetof(glsl::AtlasState, ideal));
  feed.frame({});
  EXPECT_EQ(feed.memory.readStatistics().bias, glsl::kLargestBias);
}

TEST(SuperblockOf, AnAtlasHasRoomForSixteenWhereItCan) {
  EXPECT_EQ(superblockLog2Of(4096, 2048), 8);
  EXPECT_EQ(superblockLog2Of(1024, 1024), 8);
  EXPECT_EQ(superblockLog2Of(1024, 512), 7);
  EXPECT_EQ(superblockLog2Of(512, 256), 6);
  EXPECT_EQ(superblockLog2Of(16384, 64), 6);
  EXPECT_EQ(superblockLog2Of(4, 2), 1);
  EXPECT_EQ(superblockLog2Of(0, 0), 1);
  for (int log2 = 3; log2 <= 14; ++log2) {
    const int side = 1 << log2;
    const int superblock = 1 << superblockLog2Of(side, side);
    EXPECT_GE(side / superblock * (side / superblock), std::min(16, side * side / 4)) << side;
    if (superblock < 256) {
      EXPECT_LT(side / (2 * superblock) * (side / (2 * superblock)), 16) << side;
    }
  }
}

// An atlas of the smallest size for what is visible: with two superblocks for eight widths most find no
// memory.
TEST_F(Memory, SmallAtlasHasPlaceForBlocksOfAllWidths) {
  gl::ProgramCache programs(test::context());
  RectMemoryOptions options;
  options.width = 512;
  options.height = 256;
  auto made = RectMemory::create(programs, options, 10);
  ASSERT_TRUE(made);
  const MemorySnapshot snapshot = made->readSnapshot();
  EXPECT_EQ(snapshot.superblockLog2, 6u);
  EXPECT_EQ(snapshot.freeSuperblocks.size(), 32u);
  options.smallestLog2 = 7;
  made = RectMemory::create(programs, options, 10);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->readSnapshot().superblockLog2, 7u);
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
  EXPECT_NE(message([](RectMemoryOptions& o) { o.biasFloor = -5.0f; }).find("biasFloor is -5"),
            std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.mergeShare = 2.0f; }).find("mergeShare"), std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.targetLargest = 0.5f; }).find("targetLargest is 0.5"),
            std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.softWater = 0.0f; }).find("softWater"), std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.quietFrames = -1; }).find("quietFrames is -1"),
            std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.aspectLog2 = 0; }).find("aspectLog2 is 0"),
            std::string::npos);
  const auto sizes = [&](int smallest, int largest, int superblock) {
    return message([&](RectMemoryOptions& o) {
      o.smallestLog2 = smallest;
      o.largestLog2 = largest;
      o.superblockLog2 = superblock;
    });
  };
  EXPECT_EQ(sizes(0, 0, 8) + sizes(8, 8, 8) + sizes(8, 10, 8) + sizes(10, 10, 10), "");
  EXPECT_NE(sizes(-1, 10, 8).find("smallestLog2 is -1, not in [0, 10]"), std::string::npos);
  EXPECT_NE(sizes(11, 10, 8).find("smallestLog2 is 11, not in [0, 10]"), std::string::npos);
  EXPECT_NE(sizes(0, 11, 8).find("largestLog2 is 11, not in [0, 10]"), std::string::npos);
  EXPECT_NE(sizes(9, 10, 8).find("smallestLog2 is 9, but superblockLog2 is 8"), std::string::npos);
  EXPECT_NE(sizes(5, 4, 8).find("smallestLog2 is 5, but largestLog2 is 4"), std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions& o) { o.superblockLog2 = 1; }).find("2097152 superblocks"),
            std::string::npos);
  EXPECT_NE(message([](RectMemoryOptions&) {}, 5000000).find("5000000"), std::string::npos);
}

}  // namespace
}  // namespace tessera
