#include "atlas/rect/quadtree.hpp"

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "atlas/rect/place_tracker.hpp"
#include "atlas/rect/quadtree_atlas.hpp"
#include "tests/atlas/memory_scenarios.hpp"

namespace tessera {
namespace {

using test::FrameStream;
using test::Scenario;
using Wants = std::vector<MemoryTwin::Want>;

std::uint64_t texelsOf(const AtlasBlock& block) { return std::uint64_t{1} << (block.w + block.h); }

void expectWhole(const QuadtreeAllocator& allocator) {
  const MemorySnapshot snapshot = allocator.snapshot();
  const auto partition = checkPartition(snapshot);
  ASSERT_TRUE(partition) << partition.error().message;
  std::uint64_t live = 0;
  for (const AtlasBlock& block : snapshot.live) live += texelsOf(block);
  EXPECT_EQ(live, allocator.liveTexels());
  EXPECT_EQ(allocator.rootTexels(), snapshot.freeSuperblocks.size() << (2 * snapshot.superblockLog2));
}

TEST(Quadtree, StartsAsFreeRoots) {
  const QuadtreeAllocator allocator(64, 32, 4);
  expectWhole(allocator);
  EXPECT_EQ(allocator.snapshot().freeSuperblocks.size(), 8u);
  EXPECT_TRUE(allocator.snapshot().stacked.empty());
}

TEST(Quadtree, SplitsAsWorkedByHand) {
  // One root of 8 x 8. A 4 x 1: the root gives three squares of 4, the fourth gives rows of 2 and 1.
  QuadtreeAllocator allocator(8, 8, 3);
  const auto first = allocator.allocate(2, 0);
  EXPECT_EQ(first, (AtlasBlock{0, 0, 2, 0}));
  std::set<std::array<std::uint32_t, 4>> free;
  for (const AtlasBlock& b : allocator.snapshot().stacked) free.insert({b.x, b.y, b.w, b.h});
  EXPECT_EQ(free, (std::set<std::array<std::uint32_t, 4>>{
                      {0, 1, 2, 0}, {0, 2, 2, 1}, {4, 0, 2, 2}, {0, 4, 2, 2}, {4, 4, 2, 2}}));
  // The smallest that serves: the half, then its own row, before any square.
  EXPECT_EQ(allocator.allocate(2, 1), (AtlasBlock{0, 2, 2, 1}));
  EXPECT_EQ(allocator.allocate(2, 0), (AtlasBlock{0, 1, 2, 0}));
  EXPECT_EQ(allocator.liveTexels(), 16u);
  EXPECT_FALSE(allocator.allocate(3, 3));
  EXPECT_FALSE(allocator.allocate(3, 0));
  // All given back is one root again.
  allocator.release({0, 2, 2, 1});
  allocator.release({0, 0, 2, 0});
  EXPECT_TRUE(allocator.snapshot().freeSuperblocks.empty());
  allocator.release({0, 1, 2, 0});
  EXPECT_EQ(allocator.snapshot().freeSuperblocks.size(), 1u);
  EXPECT_EQ(allocator.allocate(3, 3), (AtlasBlock{0, 0, 3, 3}));
}

TEST(Quadtree, EverySizeFillsTheAtlas) {
  constexpr std::uint32_t kRoot = 4;
  for (std::uint32_t w = 1; w <= kRoot; ++w)
    for (std::uint32_t h = 0; h <= w; ++h) {
      QuadtreeAllocator allocator(64, 48, kRoot);
      const std::uint32_t count = (64u * 48u) >> (w + h);
      for (std::uint32_t i = 0; i < count; ++i) ASSERT_TRUE(allocator.allocate(w, h)) << w << " " << h;
      EXPECT_FALSE(allocator.allocate(w, h));
      EXPECT_FALSE(allocator.allocate(1, 0));
      EXPECT_EQ(allocator.liveTexels(), 64u * 48u);
      expectWhole(allocator);
      allocator.reset();
      expectWhole(allocator);
      EXPECT_EQ(allocator.rootTexels(), 64u * 48u);
    }
}

TEST(Quadtree, RandomWorkKeepsTheAtlasWhole) {
  constexpr std::uint32_t kRoot = 5;
  std::mt19937 random(3);
  QuadtreeAllocator allocator(128, 96, kRoot);
  std::vector<AtlasBlock> held;
  std::uint32_t refused = 0;
  for (int step = 0; step < 60000; ++step) {
    // Waves: mostly taking, then mostly giving back.
    const bool take = held.empty() || random() % 8 < (step / 3000 % 2 == 0 ? 5u : 3u);
    if (take) {
      const std::uint32_t w = 1 + random() % kRoot;
      const std::uint32_t h = random() % (w + 1);
      const auto block = allocator.allocate(w, h);
      if (!block) {
        ++refused;
        // Refused only when nothing free is large enough.
        if (refused % 50 != 0) continue;
        for (const AtlasBlock& b : allocator.snapshot().stacked)
          ASSERT_FALSE((b.w == w && b.h >= h) || (b.w > w && b.h == b.w));
        continue;
      }
      ASSERT_TRUE(block->w == w && block->h == h);
      held.push_back(*block);
    } else {
      const std::size_t i = random() % held.size();
      allocator.release(held[i]);
      held[i] = held.back();
      held.pop_back();
    }
    if (step % 97 != 0) continue;
    expectWhole(allocator);
    // No siblings are free together.
    std::map<std::array<std::uint32_t, 4>, std::uint32_t> siblings;
    for (const AtlasBlock& b : allocator.snapshot().stacked) {
      const std::uint32_t mask = b.w == b.h ? ~(1u << b.w) : ~0u;
      const std::uint32_t count = ++siblings[{b.x & mask, b.y & ~(1u << b.h), b.w, b.h}];
      ASSERT_LT(count, b.w == b.h ? 4u : 2u) << "at " << b.x << ", " << b.y;
    }
    if (HasFailure()) FAIL() << "in step " << step;
  }
  EXPECT_GT(refused, 100u);
  for (const AtlasBlock& block : held) allocator.release(block);
  EXPECT_EQ(allocator.rootTexels(), 128u * 96u);
}

// ---- the frames ----

/// Takes what is asked, neither bias nor hysteresis nor resets.
glsl::AtlasConfig configOf(const Scenario& scenario) {
  glsl::AtlasConfig config{};
  config.width = scenario.width;
  config.height = scenario.height;
  config.superblockLog2 = scenario.superblockLog2;
  config.patchInstances = scenario.patches;
  config.hysteresis = -1.0f;
  config.range = {0, scenario.superblockLog2, glsl::kMaxBlockLog2};
  config.pressure.highWater = 1e9f;
  config.pressure.softWater = 1e9f;
  config.pressure.targetStart = 1e9f;
  config.pressure.targetLargest = 1e9f;
  config.pressure.targetSmallest = 1.0f;
  return config;
}

void frame(QuadtreeAtlas& atlas, const glsl::AtlasConfig& config, std::span<const std::uint32_t> patches,
           const std::vector<glsl::PatchMeasure>& measures) {
  atlas.frame(patches, measures, sumIdeal(config, patches, measures, atlas.patchStates(), atlas.epoch()));
}

void feed(QuadtreeAtlas& atlas, const glsl::AtlasConfig& config, const Wants& wants) {
  std::vector<std::uint32_t> patches;
  std::vector<glsl::PatchMeasure> measures;
  for (const MemoryTwin::Want& want : wants) {
    patches.push_back(want.patch);
    measures.push_back({static_cast<float>(want.w + want.h), static_cast<float>(want.w - want.h)});
  }
  frame(atlas, config, patches, measures);
}

class QuadtreeFrames : public ::testing::TestWithParam<Scenario> {};

TEST_P(QuadtreeFrames, InvariantsHold) {
  const Scenario& scenario = GetParam();
  const glsl::AtlasConfig config = configOf(scenario);
  QuadtreeAtlas atlas(config);
  FrameStream stream(scenario, 5);
  std::uint64_t failures = 0;
  std::uint64_t kept = 0;
  const int frames = scenario.patches > 5000 ? 150 : 1000;
  for (int frame = 0; frame < frames; ++frame) {
    const std::vector<glsl::PatchState> before(atlas.patchStates().begin(), atlas.patchStates().end());
    const Wants wants = stream.next();
    feed(atlas, config, wants);
    std::uint32_t failed = 0;
    std::set<std::array<std::uint32_t, 4>> blocks;
    for (const MemoryTwin::Want& want : wants) {
      const glsl::PatchState& now = atlas.patchStates()[want.patch];
      const glsl::uint level = glsl::packLevel(want.w, want.h, false);
      if (now.level == 0) {
        failed += want.w > 0 ? 1 : 0;
        continue;
      }
      ASSERT_EQ(now.level, level);
      const glsl::uvec2 at = glsl::unpackOrigin(now.origin);
      ASSERT_TRUE(blocks.insert({at.x, at.y, want.w, want.h}).second);
      if (before[want.patch].level != level) continue;
      ASSERT_EQ(before[want.patch].origin, now.origin) << "patch " << want.patch << " moved";
      ++kept;
    }
    ASSERT_EQ(failed, atlas.failures());
    const MemorySnapshot snapshot = atlas.allocator().snapshot();
    ASSERT_EQ(snapshot.live.size(), blocks.size()) << "an invisible patch holds a block";
    for (const AtlasBlock& b : snapshot.live) ASSERT_TRUE(blocks.contains({b.x, b.y, b.w, b.h}));
    const auto partition = checkPartition(snapshot);
    ASSERT_TRUE(partition) << "frame " << frame << ": " << partition.error().message;
    failures += failed;
  }
  EXPECT_EQ(atlas.resets(), 0u);
  if (scenario.change < 1.0) {
    EXPECT_GT(kept, 0u);
  }
  if (scenario.demand > 1.0) {
    EXPECT_GT(failures, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Memory, QuadtreeFrames, ::testing::ValuesIn(test::scenarios()),
                         [](const auto& test) {
                           std::string name = test.param.name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

/// Texels of what is asked, without single texels.
std::uint64_t texelsOf(const Wants& wants) {
  std::uint64_t texels = 0;
  for (const MemoryTwin::Want& want : wants) texels += want.w > 0 ? std::uint64_t{1} << (want.w + want.h) : 0;
  return texels;
}

/// Live texels in the last frame before the first that fails a request.
template <class Frame>
std::uint64_t heldBeforeFailure(const Scenario& scenario, std::uint32_t seed, Frame&& frame) {
  FrameStream stream(scenario, seed);
  std::uint64_t held = 0;
  for (int i = 0; i < 3000; ++i) {
    const Wants wants = stream.next();
    if (frame(wants) > 0) return held;
    held = std::max(held, texelsOf(wants));
  }
  ADD_FAILURE() << "nothing ever failed";
  return held;
}

TEST(QuadtreeFragmentation, HoldsAtLeastWhatS0Holds) {
  // The visible set grows slowly past the atlas, with patches that come, go and change.
  const Scenario growing[] = {
      {.name = "calm",
       .width = 256,
       .height = 256,
       .superblockLog2 = 5,
       .patches = 3000,
       .demand = 1.5,
       .appear = 0.01,
       .disappear = 0.005,
       .change = 0.01,
       .emptyFrames = 0.0},
      {.name = "restless",
       .width = 256,
       .height = 256,
       .superblockLog2 = 5,
       .patches = 3000,
       .demand = 1.5,
       .appear = 0.01,
       .disappear = 0.01,
       .change = 0.1,
       .emptyFrames = 0.0},
      {.name = "large",
       .width = 256,
       .height = 128,
       .superblockLog2 = 6,
       .patches = 400,
       .demand = 1.5,
       .appear = 0.01,
       .disappear = 0.005,
       .change = 0.03,
       .emptyFrames = 0.0},
  };
  for (const Scenario& scenario : growing)
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
      const glsl::AtlasConfig config = configOf(scenario);
      QuadtreeAtlas atlas(config);
      const auto quadtree = heldBeforeFailure(scenario, seed, [&](const Wants& wants) {
        feed(atlas, config, wants);
        return atlas.failures();
      });
      for (const bool merge : {false, true}) {
        MemoryTwin twin(scenario.width, scenario.height, scenario.superblockLog2, scenario.patches,
                        {.merge = merge});
        const auto s0 = heldBeforeFailure(scenario, seed, [&](const Wants& wants) {
          twin.frame(wants);
          return twin.failures();
        });
        EXPECT_GE(quadtree, s0) << scenario.name << ", seed " << seed << (merge ? ", merged" : "");
        RecordProperty(scenario.name + std::to_string(seed) + (merge ? "m" : ""),
                       std::to_string(quadtree) + " " + std::to_string(s0));
      }
    }
}

TEST(QuadtreeAtlas, BiasResetsAndHysteresisAreTheSharedOnes) {
  glsl::AtlasConfig config = configOf({.name = "", .patches = 100});  // 64 x 64, roots of 8 x 8
  config.biased = 1;
  config.lowestBias = -2.0f;
  config.hysteresis = 0.25f;
  config.pressure = {.highWater = 3000.0f,
                     .softWater = 1e9f,
                     .targetStart = 2048.0f,
                     .targetLargest = 2048.0f,
                     .targetSmallest = 512.0f,
                     .targetCut = 0.5f,
                     .targetGrowth = 1.0f,
                     .quietFrames = 100,
                     .resets = 1,
                     .adapts = 1};
  QuadtreeAtlas atlas(config);
  std::vector<std::uint32_t> patches;
  std::vector<glsl::PatchMeasure> measures;
  for (std::uint32_t i = 0; i < 64; ++i) {
    patches.push_back(i);
    measures.push_back({7.0f, 0.0f});  // 128 texels, clamped to 64: 4096 in all, twice the target
  }
  const IdealTexels ideal = sumIdeal(config, patches, measures, atlas.patchStates(), atlas.epoch());
  EXPECT_EQ(ideal.scalable, 4096u);
  EXPECT_EQ(ideal.fresh, 4096u);
  EXPECT_EQ(ideal.least, 0u);
  atlas.frame(patches, measures, ideal);
  EXPECT_EQ(atlas.pressureBias(), 1.0f);
  EXPECT_EQ(atlas.allocator().liveTexels(), 64u * 32u);
  EXPECT_EQ(atlas.blocksMade(), 64u);
  // Room to spare: up to the lowest bias.
  atlas.frame(std::span(patches).first(4), std::vector<glsl::PatchMeasure>(4, {3.0f, 0.0f}),
              {.scalable = 32});
  EXPECT_EQ(atlas.pressureBias(), -2.0f);
  EXPECT_EQ(atlas.allocator().liveTexels(), 4u * 32u);
  EXPECT_EQ(atlas.blocksFreed(), 60u);
  EXPECT_EQ(atlas.blocksMade(), 0u) << "the same size as before";
  // Within hysteresis of the border at 4.5 of log2 area; a bias of -2 in force.
  const auto levelFor = [&](float logArea) {
    atlas.frame(std::span(patches).first(1), std::vector<glsl::PatchMeasure>{{logArea, 0.0f}},
                {.scalable = 8});
    return glsl::levelTexels(atlas.patchStates()[0].level);
  };
  EXPECT_EQ(levelFor(2.6f), 32u);
  EXPECT_EQ(levelFor(2.2f), 16u);
  EXPECT_EQ(levelFor(2.7f), 16u);
  EXPECT_EQ(levelFor(2.8f), 32u);
  // Past the high-water mark the next frame starts afresh, with a smaller target.
  config.biased = 0;
  QuadtreeAtlas full(config);
  full.frame(patches, measures, ideal);
  EXPECT_EQ(full.allocator().liveTexels(), 4096u);
  EXPECT_EQ(full.resets(), 0u);
  full.frame(patches, measures, ideal);
  EXPECT_EQ(full.resets(), 1u);
  EXPECT_EQ(full.target(), 1024.0f);
  EXPECT_EQ(full.blocksMade(), 64u);
  const auto partition = checkPartition(full.allocator().snapshot());
  EXPECT_TRUE(partition) << partition.error().message;
  // What counts is what is cut and not merged back: 3 halves of 32 texels cut 2 roots of 64.
  config.pressure.highWater = 127.0f;
  QuadtreeAtlas cut(config);
  const std::vector<glsl::PatchMeasure> halves(3, {5.0f, 1.0f});
  frame(cut, config, std::span(patches).first(3), halves);
  EXPECT_EQ(cut.allocator().liveTexels(), 96u);
  frame(cut, config, std::span(patches).first(3), halves);
  EXPECT_EQ(cut.resets(), 1u);
}

TEST(QuadtreeAtlas, SmallerBlocksForWantOfMemory) {
  glsl::AtlasConfig config = configOf({.name = "", .width = 16, .height = 16, .patches = 10});
  config.merges = 1;
  QuadtreeAtlas atlas(config);  // 4 roots of 8 x 8
  // Three roots whole; of the fourth a 4 x 2, and so three squares of 4 and a half of one are free.
  feed(atlas, config, {{0, 3, 3}, {1, 3, 3}, {2, 3, 3}, {3, 2, 1}});
  EXPECT_EQ(atlas.failures() + atlas.blocksReduced(), 0u);
  // Four more of 8 x 8: three come down to 4 x 4, and nothing down to 2 x 1 is left for the last, as a row is
  // not cut into columns.
  feed(atlas, config,
       {{0, 3, 3}, {1, 3, 3}, {2, 3, 3}, {3, 2, 1}, {4, 3, 3}, {5, 3, 3}, {6, 3, 3}, {7, 3, 3}});
  EXPECT_EQ(atlas.blocksReduced(), 3u);
  EXPECT_EQ(atlas.failures(), 1u);
  const glsl::uint reduced = glsl::packLevel(2, 2, false) | glsl::kLevelReduced;
  EXPECT_EQ(atlas.patchStates()[4].level, reduced);
  EXPECT_EQ(atlas.patchStates()[7].level, 0u);
  EXPECT_EQ(atlas.allocator().liveTexels(), 3u * 64u + 8u + 3u * 16u);
  // They keep those, also when larger ones come free: until a reset.
  Wants wants = {{0, 3, 3}, {1, 3, 3}, {2, 3, 3}, {3, 2, 1}, {4, 3, 3}, {5, 3, 3}, {6, 3, 3}};
  const auto origin = [&](std::uint32_t patch) { return atlas.patchStates()[patch].origin; };
  const std::array<glsl::uint, 3> before = {origin(4), origin(5), origin(6)};
  for (int i = 0; i < 3; ++i) {
    feed(atlas, config, wants);
    EXPECT_EQ(atlas.blocksReduced() + atlas.blocksMade() + atlas.failures(), 0u);
    EXPECT_EQ(atlas.blocksWaiting(), 3u);
    EXPECT_EQ((std::array<glsl::uint, 3>{origin(4), origin(5), origin(6)}), before);
    if (i == 0) wants.erase(wants.begin());
  }
  // Who wants as much as it has does not wait.
  wants[3] = {4, 2, 2};
  feed(atlas, config, wants);
  EXPECT_EQ(atlas.blocksWaiting(), 2u);
  EXPECT_EQ(origin(4), before[0]);
  EXPECT_EQ(atlas.patchStates()[4].level, glsl::packLevel(2, 2, false));
  wants[3] = {4, 3, 3};
  feed(atlas, config, wants);
  EXPECT_EQ(atlas.patchStates()[4].level, glsl::packLevel(3, 3, false)) << "the one that is free";
  EXPECT_EQ(atlas.allocator().liveTexels(), 3u * 64u + 8u + 2u * 16u);
  const auto partition = checkPartition(atlas.allocator().snapshot());
  EXPECT_TRUE(partition) << partition.error().message;
}

TEST(QuadtreeAtlas, EverySmallestBlockWorks) {
  const Scenario scenario{.name = "", .width = 2048, .height = 1024, .superblockLog2 = 10, .patches = 300};
  std::mt19937 random(4);
  std::uint32_t seen = 0;
  for (glsl::uint smallest = 0; smallest <= 10; ++smallest) {
    glsl::AtlasConfig config = configOf(scenario);
    config.range.smallest = smallest;
    config.merges = 1;
    QuadtreeAtlas atlas(config);
    std::uint32_t reduced = 0;
    for (int frame = 0; frame < 4; ++frame) {
      Wants wants;
      for (std::uint32_t patch = 0; patch < scenario.patches; ++patch)
        if (random() % 3 != 0) {
          const auto w = static_cast<std::uint32_t>(random() % 11);
          wants.push_back({patch, w, static_cast<std::uint32_t>(random() % (w + 1))});
        }
      feed(atlas, config, wants);
      reduced += atlas.blocksReduced();
      std::uint32_t blocks = 0;
      for (const MemoryTwin::Want& want : wants) {
        const glsl::uint level = atlas.patchStates()[want.patch].level;
        if (glsl::levelWidth(level) == 0) continue;
        ASSERT_GE(glsl::levelHeight(level), smallest);
        ++blocks;
      }
      EXPECT_GT(blocks, 0u);
      const MemorySnapshot snapshot = atlas.allocator().snapshot();
      EXPECT_EQ(snapshot.live.size(), blocks);
      const auto partition = checkPartition(snapshot);
      ASSERT_TRUE(partition) << "2^" << smallest << ": " << partition.error().message;
    }
    if (smallest == 10) {
      EXPECT_EQ(reduced, 0u) << "there is nothing smaller";
    }
    seen += reduced;
  }
  EXPECT_GT(seen, 0u) << "no want of memory was tested";
}

TEST(QuadtreeAtlas, ACameraThatJumpsFindsMemoryPackedAfresh) {
  glsl::AtlasConfig config = configOf({.name = "", .patches = 200});  // 64 x 64, roots of 8 x 8
  config.pressure.resets = 1;
  config.pressure.targetStart = 4096.0f;
  QuadtreeAtlas atlas(config);
  Wants wants;
  for (std::uint32_t i = 0; i < 60; ++i) wants.push_back({i, 3, 3});
  feed(atlas, config, wants);
  for (MemoryTwin::Want& want : wants) want = {want.patch + 100, 3, 2};
  feed(atlas, config, wants);
  EXPECT_EQ(atlas.resets(), 1u);
  EXPECT_EQ(atlas.failures(), 0u);
  // As many again, that fit beside those.
  for (std::uint32_t i = 0; i < 60; ++i) wants.push_back({i, 3, 2});
  feed(atlas, config, wants);
  EXPECT_EQ(atlas.resets(), 1u);
  EXPECT_EQ(atlas.failures(), 0u);
  // What is still seen is not new, what went out of sight in between is.
  const auto freshOf = [&](std::uint32_t patch) {
    const std::vector<glsl::PatchMeasure> measures = {{5.0f, 1.0f}};
    return sumIdeal(config, std::vector{patch}, measures, atlas.patchStates(), atlas.epoch()).fresh;
  };
  EXPECT_EQ(freshOf(100), 0u);
  wants.erase(wants.begin());
  feed(atlas, config, wants);
  EXPECT_EQ(freshOf(100), 32u);
  EXPECT_EQ(freshOf(101), 0u);
}

TEST(PlaceTracker, CountsAsWorkedByHand) {
  const auto at = [](glsl::uint x, glsl::uint w, glsl::uint h, glsl::uint epoch, bool transposed = false) {
    return glsl::PatchState{glsl::packOrigin(x, 0), glsl::packLevel(w, h, transposed), epoch};
  };
  PlaceTracker tracker(5);
  const auto expect = [](const PlaceChanges& c, bool reset, std::uint32_t stayed, std::uint32_t kept,
                         std::uint32_t moved, std::uint64_t texels) {
    EXPECT_EQ(c.reset, reset);
    EXPECT_EQ(c.stayed, stayed);
    EXPECT_EQ(c.kept, kept);
    EXPECT_EQ(c.moved, moved);
    EXPECT_EQ(c.movedTexels, texels);
  };
  const std::vector<std::uint32_t> all = {0, 1, 2, 3, 4};
  const std::vector<std::uint32_t> some = {0, 1, 2, 3};
  std::vector<glsl::PatchState> states = {at(0, 2, 1, 1), at(8, 2, 2, 1), at(16, 3, 0, 1), at(0, 0, 0, 1),
                                          at(32, 1, 1, 1)};
  expect(tracker.follow(all, states, 1), false, 0, 0, 0, 0);
  // 0 is seen the other way round, 1 moves, 2 grows, 3 gets its first block, 4 is out of sight.
  states[0] = at(0, 2, 1, 1, true);
  states[1] = at(64, 2, 2, 1);
  states[2] = at(16, 3, 1, 1);
  states[3] = at(128, 1, 0, 1);
  expect(tracker.follow(some, states, 1), false, 2, 1, 2, 16 + 16);
  // 4 comes back: it has no last place. 3 fails.
  states[3] = at(0, 0, 0, 1);
  expect(tracker.follow(all, states, 1), false, 3, 3, 0, 0);
  // A reset: 0 and 1 move, 2 happens to get its old place; 4's state is of the old epoch.
  states[0] = at(4, 2, 1, 2);
  states[1] = at(8, 2, 2, 2);
  states[2] = at(16, 3, 1, 2);
  states[3] = at(0, 1, 0, 2);
  expect(tracker.follow(all, states, 2), true, 0, 0, 2, 8 + 16);
  expect(tracker.follow({}, states, 2), false, 0, 0, 0, 0);
  expect(tracker.follow(all, states, 2), false, 0, 0, 0, 0);
}

}  // namespace
}  // namespace tessera
