// The memory of the tessellation gatherer's atlas, driven over visible sets and sizes that no camera would
// ask for.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <random>

#include "atlas/tess/tess_memory.hpp"
#include "glsl/shared/tess_measure.h"
#include "tests/atlas/visible_feed.hpp"
#include "tests/gl_test.hpp"
#include "tests/tess/slots.hpp"

namespace tessera {
namespace {

using glsl::TessMeasure;
using glsl::TessShape;
using glsl::TessState;

/// A triangle with a base of `base` texels, `height` of it high, its height's foot a share `foot` from one
/// end, and its corners in any order.
TessMeasure measureOf(float base, float height, float foot, unsigned turn) {
  const std::array<float, 3> edges = {base, base * std::hypot(1.0f - foot, height),
                                      base * std::hypot(foot, height)};
  return {edges[turn % 3], edges[(turn + 1) % 3], edges[(turn + 2) % 3], base * height};
}
TessMeasure measureOfLevel(std::uint32_t level) {
  return measureOf(static_cast<float>(level) - 0.5f, 0.8f, 0.5f, 0);
}

struct Want {
  std::uint32_t triangle;
  TessMeasure measure;
};
using Wants = std::vector<Want>;

TessMemoryOptions optionsOf(int width, int height, bool pressureBias) {
  TessMemoryOptions options;
  options.width = width;
  options.height = height;
  options.pressureBias = pressureBias;
  return options;
}

bool sameSize(const TessShape& a, const TessShape& b) {
  return a.kind == b.kind && a.size == b.size && a.form >> 16u == b.form >> 16u;
}

/// Feeds a TessMemory, and checks after every frame what must hold of it.
class Driver {
 public:
  Driver(const TessMemoryOptions& options, std::uint32_t triangles)
      : programs_(test::context()), feed_(triangles) {
    auto made = TessMemory::create(programs_, options, triangles);
    if (!made) {
      ADD_FAILURE() << made.error().message;
      return;
    }
    memory = std::move(*made);
    painter_.emplace(memory.textureWidth(), memory.textureHeight());
    states = memory.readStates();
    state = memory.readState();
  }

  void frame(const Wants& wants) {
    std::vector<std::uint32_t> visible;
    std::vector<TessMeasure> measures;
    std::uint32_t ideal = 0;
    for (const Want& want : wants) {
      visible.push_back(want.triangle);
      measures.push_back(want.measure);
      const auto texels = glsl::texelsOfShape(
          glsl::shapeAt(want.measure, std::exp2(-0.5f * state.config.constantBias), state.config.limits));
      ideal += texels > 1 ? texels : 0;
    }
    feed_.see(visible);
    if (!measures.empty()) memory.measures().write(std::span<const TessMeasure>(measures));
    // What the measuring pass sums up.
    memory.stateBuffer().writeValue(ideal,
                                    offsetof(glsl::TessAtlasState, ideal) + offsetof(glsl::TessIdeal, low));
    memory.allocate(feed_.dispatch(), feed_.frame());
    SCOPED_TRACE(testing::Message() << "frame " << feed_.frame());
    const std::vector<TessState> before = std::move(states);
    const std::uint32_t epochBefore = state.epoch;
    states = memory.readStates();
    state = memory.readState();
    statistics = memory.readStatistics();
    wasReset = state.epoch != epochBefore;
    bins_ = memory.readBins();
    const std::string wrong = painter_->paint(visible, state, states, bins_);
    EXPECT_EQ(wrong, "");
    checkShapes(wants, before);
    checkCounts(wants);
    checkCells();
  }

  TessMemory memory;
  std::vector<TessState> states;
  glsl::TessAtlasState state{};
  TessStatistics statistics;
  bool wasReset = false;
  std::uint64_t kept = 0;        // places that stayed, so far
  std::uint64_t failures = 0;    // so far
  std::uint64_t lostTexels = 0;  // since the last reset

 private:
  void checkShapes(const Wants& wants, const std::vector<TessState>& before) {
    // The same formula in C++ decides otherwise where a length lies on the border of two shapes.
    std::uint32_t borders = 0;
    std::uint32_t failed = 0;
    for (const Want& want : wants) {
      const TessState& now = states[want.triangle];
      const TessState& old = before[want.triangle];
      ASSERT_EQ(now.epoch, state.epoch) << want.triangle;
      ASSERT_EQ(now.pending, 0u) << want.triangle;
      const bool known = old.epoch == state.epoch;
      const TessShape expected =
          glsl::selectShape(want.measure, state.config.constantBias, state.bias, state.config.limits,
                            old.shape, known ? state.config.hysteresis : -1.0f);
      const bool single = now.shape.kind == glsl::kTessSingle;
      if (single && expected.kind != glsl::kTessSingle)
        ++failed;
      else if (!sameSize(now.shape, expected))
        ++borders;
      if (!known || single || !sameSize(old.shape, now.shape)) continue;
      ASSERT_EQ(old.place0, now.place0) << "triangle " << want.triangle << " moved";
      if (glsl::overOfShape(now.shape).columns1 > 0 && glsl::kindOf(now.shape.kind) == glsl::kTessOver) {
        ASSERT_EQ(old.place1, now.place1) << "triangle " << want.triangle << " moved";
      }
      ++kept;
    }
    EXPECT_LE(borders, 1 + wants.size() / 500);
    EXPECT_NEAR(failed, state.events.failures, borders);
    failures += state.events.failures;
  }

  void checkCounts(const Wants& wants) {
    TessStatistics found;
    for (const Want& want : wants) {
      const TessShape& shape = states[want.triangle].shape;
      const std::uint32_t texels = glsl::texelsOfShape(shape);
      const std::uint32_t kind = glsl::kindOf(shape.kind);
      found.samples += texels;
      found.singles += kind == glsl::kTessSingle ? 1 : 0;
      found.lSamples += kind == glsl::kTessL ? texels : 0;
      found.slanted += kind == glsl::kTessOver ? 1 : 0;
      found.liveTexels += kind == glsl::kTessSingle ? 0 : texels;
      if (kind != glsl::kTessOver) continue;
      const glsl::OverShape over = glsl::overOfShape(shape);
      for (std::uint32_t thread = 0; thread < texels; ++thread) {
        const glsl::OverCell cell = glsl::overCellOf(thread, over);
        if (!cell.used) continue;
        const bool inside = glsl::overInside(cell.at, glsl::overColumns(over, cell.side), over.rows);
        ++(inside ? found.inside : found.outside);
      }
    }
    EXPECT_EQ(statistics.visible, wants.size());
    EXPECT_EQ(statistics.samples, found.samples);
    EXPECT_EQ(statistics.singles, found.singles);
    EXPECT_EQ(statistics.lSamples, found.lSamples);
    EXPECT_EQ(statistics.slanted, found.slanted);
    EXPECT_EQ(statistics.inside, found.inside);
    EXPECT_EQ(statistics.outside, found.outside);
    EXPECT_EQ(statistics.liveTexels, found.liveTexels);
    EXPECT_EQ(statistics.failures, state.events.failures);
  }

  /// Each slot of each cell is held by a triangle, free, or counted as lost.
  void checkCells() {
    if (wasReset) lostTexels = lostSlots_ = 0;
    lostTexels += state.events.lostTexels;
    lostSlots_ += state.events.lost;
    std::uint64_t halves = 2 * lostTexels;  // half texels: half a cell may have an odd number
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      const glsl::TessBin& bin = bins_[i];
      std::uint64_t slots = painter_->held()[i];
      const std::uint32_t hadSpare = bin.spare != glsl::kNoPlace ? 1 : 0;
      if (bin.requested == 0) {
        slots += static_cast<std::uint32_t>(bin.stackCount) + hadSpare;
      } else {
        // What this frame took is counted off by the next one.
        EXPECT_LE(bin.provided, bin.requested);
        slots += static_cast<std::uint32_t>(bin.stackCount) - (bin.given - hadSpare);
        slots += (bin.provided - bin.given) & 1u;
      }
      EXPECT_LE(bin.stackCount, static_cast<int>(bin.stackCapacity)) << "bin " << i;
      halves += slots * bin.cellWidth * bin.cellHeight;
    }
    EXPECT_LE(halves, 2 * statistics.cellTexels);
    EXPECT_GE(halves + lostSlots_, 2 * statistics.cellTexels);
    EXPECT_LE(statistics.cellTexels + statistics.freeTexels,
              std::uint64_t{state.config.width} * state.config.height);
  }

  gl::ProgramCache programs_;
  test::VisibleFeed feed_;
  std::uint64_t lostSlots_ = 0;  // since the last reset
  std::optional<test::SlotPainter> painter_;
  std::vector<glsl::TessBin> bins_;
};

/// A scene's worth of triangles whose sizes wander.
class Walk {
 public:
  struct Options {
    const char* name = "";
    int width = 512;
    int height = 512;
    bool pressureBias = true;
    std::uint32_t triangles = 1500;
    double visible = 0.7;   // share of the triangles
    double appears = 0.05;  // share of the triangles that appear or vanish each frame
    float least = -1.0f;    // log2 of the base, texels
    float most = 5.0f;
    float change = 0.1f;   // of the base, log2, a frame
    float slanted = 0.4f;  // share of triangles that are
    int frames = 40;
    int cutEvery = 1000;  // frames from one camera cut to the next
  };

  Walk(const Options& options, unsigned seed) : options_(options), random_(seed), all_(options.triangles) {
    for (Triangle& triangle : all_) start(triangle);
  }

  Wants next() {
    const bool cut = ++frame_ % options_.cutEvery == 0;
    Wants wants;
    for (std::uint32_t i = 0; i < all_.size(); ++i) {
      Triangle& t = all_[i];
      if (cut) start(t);
      if (unit() < options_.appears) t.seen = unit() < options_.visible;
      t.base = std::clamp(t.base + options_.change * (2.0f * static_cast<float>(unit()) - 1.0f),
                          options_.least, options_.most);
      if (t.seen) wants.push_back({i, measureOf(std::exp2(t.base), t.height, t.foot, t.turn)});
    }
    std::shuffle(wants.begin(), wants.end(), random_);
    return wants;
  }

 private:
  struct Triangle {
    bool seen = false;
    float base = 0.0f;
    float height = 0.0f;
    float foot = 0.0f;
    unsigned turn = 0;
  };
  double unit() { return std::uniform_real_distribution<double>()(random_); }
  void start(Triangle& t) {
    t.seen = unit() < options_.visible;
    t.base = options_.least + (options_.most - options_.least) * static_cast<float>(unit());
    t.foot = static_cast<float>(unit());
    t.height = unit() < static_cast<double>(options_.slanted)
                   ? 0.25f * std::exp2(-8.0f * static_cast<float>(unit()))
                   : 0.3f + 0.5f * static_cast<float>(unit());
    t.turn = static_cast<unsigned>(random_());
  }

  Options options_;
  std::mt19937 random_;
  std::vector<Triangle> all_;
  int frame_ = 0;
};

void PrintTo(const Walk::Options& options, std::ostream* out) { *out << options.name; }

class TessMemoryWalks : public test::GlTest, public ::testing::WithParamInterface<Walk::Options> {};

TEST_P(TessMemoryWalks, EveryTriangleHasAPlaceOfItsOwn) {
  const Walk::Options& options = GetParam();
  Driver driver(optionsOf(options.width, options.height, options.pressureBias), options.triangles);
  Walk walk(options, 11);
  for (int frame = 0; frame < options.frames; ++frame) {
    driver.frame(walk.next());
    if (HasFailure()) return;
  }
  std::printf("%llu places kept, %u resets, %llu failures, %.0f %% of the atlas live\n",
              static_cast<unsigned long long>(driver.kept), driver.statistics.resets,
              static_cast<unsigned long long>(driver.failures),
              100.0 * static_cast<double>(driver.statistics.liveTexels) / (options.width * options.height));
  if (options.change < 1.0f) {
    EXPECT_GT(driver.kept, 0u);
  }
  // With a bias that may rise, every frame finds room for all in its own rounds.
  if (options.pressureBias) {
    EXPECT_EQ(driver.failures, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(
    TessMemory, TessMemoryWalks,
    ::testing::Values(
        Walk::Options{.name = "plain"},
        Walk::Options{.name = "roomyWithoutBias",
                      .width = 1024,
                      .height = 1024,
                      .pressureBias = false,
                      .triangles = 600},
        Walk::Options{.name = "everythingVisible", .visible = 1.0, .appears = 0.0},
        Walk::Options{.name = "allLsChangeEachFrame", .change = 3.0f, .slanted = 0.0f},
        Walk::Options{.name = "allChangeEachFrame", .least = 0.0f, .change = 3.0f},
        Walk::Options{.name = "allBlocks", .triangles = 500, .most = 8.0f, .slanted = 1.0f},
        Walk::Options{.name = "tenTimesTheCapacity", .width = 256, .height = 256, .most = 6.5f},
        Walk::Options{
            .name = "tenTimesWithoutBias", .width = 256, .height = 256, .pressureBias = false, .most = 6.5f},
        Walk::Options{
            .name = "largeOnes", .width = 1024, .height = 512, .triangles = 40, .least = 4.0f, .most = 10.0f},
        Walk::Options{
            .name = "manySmallOnes", .triangles = 30000, .least = -2.0f, .most = 2.0f, .frames = 12},
        Walk::Options{.name = "cameraCuts", .cutEvery = 5}),
    [](const auto& one) { return std::string(one.param.name); });

class TessMemoryGl : public test::GlTest {};

// A triangle alone, of every size that there is; then all levels at once, and nothing at all.
TEST_F(TessMemoryGl, EveryLevelAloneAndAllAtOnce) {
  Driver driver(optionsOf(512, 512, false), glsl::kLargestLevel);
  // Level 1 is none: what is no longer than a texel is one.
  for (std::uint32_t level = 2; level <= glsl::kLargestLevel; level += level < 20 || level == 64 ? 1 : 11) {
    driver.frame({{level % 7, measureOfLevel(level)}});
    ASSERT_EQ(driver.states[level % 7].shape.kind, glsl::kindOfL(level));
    if (HasFailure()) return;
  }
  for (const float base : {1.5f, 17.0f, 200.0f, 990.0f, 5000.0f})
    for (const float height : {0.0f, 1e-3f, 0.05f, 0.2f})
      for (const float foot : {0.0f, 0.3f, 1.0f}) {
        driver.frame({{3, measureOf(base, height, foot, 1)}});
        ASSERT_EQ(glsl::kindOf(driver.states[3].shape.kind), glsl::kTessOver) << base << " " << height;
        if (HasFailure()) return;
      }
  driver.frame({});
  EXPECT_EQ(driver.statistics.samples, 0u);
  driver.frame({{5, measureOf(0.5f, 0.8f, 0.5f, 0)}});
  EXPECT_EQ(driver.statistics.singles, 1u);
  driver.frame({});

  Driver all(optionsOf(4096, 3072, false), glsl::kLargestLevel);
  Wants wants;
  for (std::uint32_t level = 2; level <= glsl::kLargestLevel; ++level)
    wants.push_back({level - 1, measureOfLevel(level)});
  all.frame(wants);
  EXPECT_EQ(all.failures, 0u);
  EXPECT_EQ(all.statistics.singles, 0u);
}

TEST_F(TessMemoryGl, ACameraCutFindsRoomInTheSameFrame) {
  Driver driver(optionsOf(512, 512, true), 4000);
  const auto wants = [](std::uint32_t first, std::uint32_t level) {
    Wants all;
    for (std::uint32_t i = 0; i < 2000; ++i) all.push_back({first + i, measureOfLevel(level + i % 5)});
    return all;
  };
  driver.frame(wants(0, 9));
  driver.frame(wants(0, 9));
  EXPECT_EQ(driver.failures, 0u);
  const float calm = driver.statistics.bias;
  // Other triangles, in other bins: what the last frame left has no room for them.
  Wants other;
  for (std::uint32_t i = 2000; i < 4000; ++i) other.push_back({i, measureOf(40.0f, 0.2f, 0.5f, i)});
  driver.frame(other);
  EXPECT_EQ(driver.statistics.failures, 0u);
  EXPECT_TRUE(driver.wasReset);
  EXPECT_GT(driver.statistics.bias, calm);
  // 100 times as many as there is room for, and back.
  driver.frame(wants(0, 100));
  EXPECT_EQ(driver.statistics.failures, 0u);
  driver.frame(wants(0, 9));
  EXPECT_EQ(driver.statistics.failures, 0u);
}

// Without a bias that may rise, what does not fit is one texel, is counted, and asks again.
TEST_F(TessMemoryGl, OutOfMemoryIsATexelAndCounted) {
  Driver driver(optionsOf(256, 256, false), 500);
  Wants wants;
  for (std::uint32_t i = 0; i < 500; ++i) wants.push_back({i, measureOfLevel(30)});
  driver.frame(wants);
  const std::uint32_t failures = driver.statistics.failures;
  EXPECT_GT(failures, 300u);
  EXPECT_EQ(driver.statistics.singles, failures);
  // Cells of 32 x 47 texels for two Ls each: eight side by side, five rows.
  EXPECT_EQ(500 - failures, 80u);
  wants.resize(60);
  driver.frame(wants);
  EXPECT_EQ(driver.statistics.failures, 0u);
  EXPECT_EQ(driver.statistics.singles, 0u);
}

// Of two halves of which one finds room, that one is counted as lost until memory is reset.
TEST_F(TessMemoryGl, HalvesWithoutTheOtherAreCountedAsLost) {
  Driver driver(optionsOf(256, 256, false), 400);
  driver.memory.holdReset(true);
  Wants wants;
  for (std::uint32_t i = 0; i < 400; ++i)
    wants.push_back({i, measureOf(60.0f, 0.2f, 0.2f + 0.0015f * static_cast<float>(i), i)});
  for (int frame = 0; frame < 3; ++frame) {
    driver.frame(wants);
    if (HasFailure()) return;
  }
  EXPECT_GT(driver.lostTexels, 0u);
  EXPECT_GT(driver.statistics.failures, 0u);
}

TEST_F(TessMemoryGl, AHeldResetWaitsAndAnAskedOneHappens) {
  Driver driver(optionsOf(256, 256, true), 500);
  Wants wants;
  for (std::uint32_t i = 0; i < 400; ++i) wants.push_back({i, measureOfLevel(10)});
  driver.frame(wants);
  driver.frame(wants);
  EXPECT_EQ(driver.failures, 0u);
  const std::uint32_t epoch = driver.state.epoch;
  driver.memory.holdReset(true);
  driver.memory.reset();
  for (std::uint32_t i = 400; i < 500; ++i) wants.push_back({i, measureOf(80.0f, 0.2f, 0.5f, i)});
  const std::uint64_t kept = driver.kept;
  driver.frame(wants);
  EXPECT_EQ(driver.state.epoch, epoch) << "held";
  EXPECT_GT(driver.statistics.failures, 0u) << "and so there is no room";
  EXPECT_GE(driver.kept, kept);
  driver.memory.holdReset(false);
  driver.frame(wants);
  EXPECT_GT(driver.state.epoch, epoch);
  EXPECT_EQ(driver.statistics.failures, 0u);
}

TEST_F(TessMemoryGl, FullStacksCountWhatTheyForget) {
  // More halves of one size than a stack of blocks remembers, gone at once.
  Driver driver(optionsOf(512, 512, false), 2000);
  Wants wants;
  for (std::uint32_t i = 0; i < 2000; ++i) wants.push_back({i, measureOf(6.0f, 0.0f, 0.5f, i)});
  driver.frame(wants);
  EXPECT_EQ(driver.statistics.failures, 0u);
  driver.frame({wants[0]});
  EXPECT_GT(driver.state.events.lost, 1000u);
  EXPECT_GT(driver.lostTexels, 0u);
  driver.frame(wants);
  driver.memory.reset();
  driver.frame(wants);
  EXPECT_EQ(driver.lostTexels, 0u);
  EXPECT_EQ(driver.statistics.failures, 0u);
}

TEST_F(TessMemoryGl, OptionsOutOfRangeAreNamed) {
  gl::ProgramCache programs(test::context());
  const auto refuses = [&](const char* what, const auto& change) {
    TessMemoryOptions options;
    change(options);
    const auto made = TessMemory::create(programs, options, 10);
    ASSERT_FALSE(made) << what;
    EXPECT_NE(made.error().message.find(what), std::string::npos) << made.error().message;
  };
  const float nan = std::nanf("");
  refuses("width", [](auto& o) { o.width = 255; });
  refuses("height", [](auto& o) { o.height = 16385; });
  refuses("bias", [&](auto& o) { o.bias = nan; });
  refuses("bias floor", [](auto& o) { o.biasFloor = 0.5f; });
  refuses("target share", [](auto& o) { o.targetShare = 0.0f; });
  refuses("largest target", [](auto& o) { o.targetLargest = 0.1f; });
  refuses("slanted", [&](auto& o) { o.slanted = nan; });
  refuses("hysteresis", [&](auto& o) { o.hysteresis = nan; });
  refuses("quiet frames", [](auto& o) { o.quietFrames = -1; });
}

}  // namespace
}  // namespace tessera
