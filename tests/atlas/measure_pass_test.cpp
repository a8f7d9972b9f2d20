// The measuring pass, and the bias that follows from it, on scenes of random patches.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include "atlas/rect/memory.hpp"
#include "engine/gl/timer.hpp"
#include "glsl/shared/bindings.h"
#include "glsl/shared/scene.h"
#include "tests/atlas/measure_reference.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

/// Instances of one random primitive of pairs, triples and singles, all visible, seen from `views`.
struct PatchScene {
  PatchScene(std::uint32_t pairs, std::uint32_t triples, std::uint32_t singles, std::uint32_t instanceCount,
             float size)
      : patchCount((pairs + triples + singles) * instanceCount) {
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    const std::uint32_t each = pairs + triples + singles;
    for (std::uint32_t p = 0; p < each; ++p) {
      const glm::vec3 center = glm::vec3(normal(random), normal(random), normal(random)) * 10.0f;
      const std::uint32_t first = static_cast<std::uint32_t>(positions.size() / 3);
      const std::uint32_t triangles = p < pairs ? 2 : p < pairs + triples ? 3 : 1;
      for (std::uint32_t v = 0; v < triangles + 2; ++v) {
        const glm::vec3 corner = center + glm::vec3(normal(random), normal(random), normal(random)) * size;
        positions.insert(positions.end(), {corner.x, corner.y, corner.z});
      }
      patches.push_back({first, first + 1, first + 2, triangles > 1 ? first + 3 : first + 1,
                         triangles > 2 ? first + 4 : first, triangles});
    }
    for (std::uint32_t i = 0; i < instanceCount; ++i) {
      glsl::InstanceGpu instance{};
      const auto row = [&] {
        return glm::vec4(normal(random), normal(random), normal(random), 5 * normal(random));
      };
      instance.row0 = row();
      instance.row1 = row();
      instance.row2 = row();
      instance.patchBase = i * each;
      instance.pairs = pairs;
      instance.triples = triples;
      instance.singles = singles;
      instances.push_back(instance);
      for (std::uint32_t p = 0; p < each; ++p) instanceOf.push_back(i);
    }
  }

  /// Uploads, binds, and makes the given share of the patches visible.
  void upload(const std::vector<glsl::ViewGpu>& views, std::uint32_t visibleCount) {
    std::vector<glsl::ViewGpu> padded = views;
    padded.resize(RECT_VIEWS);
    std::vector<std::uint32_t> list = {visibleCount};
    for (std::uint32_t i = 0; i < visibleCount; ++i) list.push_back(patchCount - 1 - i);
    ++frame;
    std::vector<std::uint32_t> marks(patchCount, 0u);
    for (std::uint32_t i = 0; i < visibleCount; ++i) marks[list[i + 1]] = frame;
    const std::vector<std::uint32_t> groups = {(visibleCount + RECT_GROUP - 1) / RECT_GROUP, 1, 1};
    buffers.clear();
    const auto add = [&](auto values, GLuint binding) {
      buffers.emplace_back(values);
      buffers.back().bindStorage(binding);
    };
    add(positions, BIND_POSITIONS);
    add(instances, BIND_INSTANCES);
    add(patches, BIND_PATCHES);
    add(instanceOf, BIND_PATCH_INSTANCE);
    add(list, BIND_VISIBLE);
    add(marks, BIND_VISIBLE_MARK);
    buffers.emplace_back(padded);
    buffers.back().bindUniform(BIND_VIEWS);
    dispatch = gl::Buffer(groups);
    visible.assign(list.begin() + 1, list.end());
  }

  [[nodiscard]] test::Reference expected(std::uint32_t patch, const glsl::ViewGpu& view,
                                         float& rounding) const {
    const glsl::InstanceGpu& instance = instances[instanceOf[patch]];
    const glsl::PatchGeometry& g = patches[patch - instance.patchBase];
    const auto corner = [&](std::uint32_t v) {
      return glsl::transformPoint(instance, {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]}) -
             glm::vec3(view.eye);
    };
    const test::Corners v = {corner(g.v0), corner(g.v1), corner(g.v2), corner(g.v3), corner(g.v4)};
    float shortest = 1e9f;
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t k = 0; k < i; ++k)
        if (v[i] != v[k]) shortest = std::min(shortest, glm::distance(v[i], v[k]));
    // A driver may fuse the products of the transformation, which moves a corner by an ulp or two of
    // coordinates of up to 64.
    rounding = 3e-7f + 4.0f * 64.0f / 16777216.0f / shortest;
    return test::referenceMeasure(v, g.triangles, static_cast<test::Long>(view.eye.w));
  }

  std::uint32_t patchCount;
  std::uint32_t frame = 0;
  std::vector<float> positions;
  std::vector<glsl::PatchGeometry> patches;
  std::vector<glsl::InstanceGpu> instances;
  std::vector<std::uint32_t> instanceOf;
  std::vector<std::uint32_t> visible;
  std::vector<gl::Buffer> buffers;
  gl::Buffer dispatch;
};

glsl::ViewGpu viewFrom(float x, float y, float z, float pixelsPerRadian) {
  return {glm::mat4(1.0f), glm::vec4(x, y, z, pixelsPerRadian)};
}

std::uint64_t onesOf(const glsl::AtlasState& state) {
  std::uint64_t ones = 0;
  for (const glsl::IdealSum& sum : state.ideal) ones += sum.ones;
  return ones;
}

/// I, patches of one texel included.
std::uint64_t idealOf(const glsl::AtlasState& state) {
  std::uint64_t ideal = onesOf(state);
  for (const glsl::IdealSum& sum : state.ideal) ideal += (std::uint64_t{sum.high} << 32) + sum.low;
  return ideal;
}

class MeasurePass : public test::GlTest {
 protected:
  MeasurePass() : programs(test::context()) {}
  RectMemory make(const RectMemoryOptions& options, std::uint32_t patches) {
    auto made = RectMemory::create(programs, options, patches);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  gl::ProgramCache programs;
};

TEST_F(MeasurePass, IsTheSharedFormula) {
  PatchScene scene(300, 200, 100, 5, 0.3f);
  const std::vector<glsl::ViewGpu> views = {viewFrom(0, 0, 30, 900), viewFrom(0.5f, 0, 30, 900),
                                            viewFrom(-40, 5, 0, 500)};
  for (const std::uint32_t viewCount : {1u, 3u}) {
    scene.upload(views, scene.patchCount - 7);
    RectMemory memory = make({}, scene.patchCount);
    memory.measure(scene.dispatch, viewCount);
    gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const auto measures = memory.measures().readAll<glsl::PatchMeasure>(scene.visible.size());
    const glsl::AtlasState state = memory.readState();
    test::Long worst = 0;
    std::size_t compared = 0;
    std::uint64_t ideal = 0;
    std::uint32_t ones = 0;
    for (std::size_t i = 0; i < measures.size(); ++i) {
      const glsl::uint texels = glsl::idealTexels(measures[i], 0.0f, {0, 8, 10});
      ideal += texels;
      ones += texels == 1 ? 1 : 0;
      float rounding = 0.0f;  // relative, of the edges' lengths
      test::Reference best = scene.expected(scene.visible[i], views[0], rounding);
      for (std::uint32_t v = 1; v < viewCount; ++v) {
        const test::Reference other = scene.expected(scene.visible[i], views[v], rounding);
        if (other.logArea > best.logArea) best = other;
      }
      // Flat triangles multiply the rounding of their edges.
      if (!(best.condition < 1e4L)) continue;
      ++compared;
      const test::Long error = std::abs(static_cast<test::Long>(measures[i].logArea) - best.logArea);
      ASSERT_LE(error, 2e-5L + 3 * static_cast<test::Long>(rounding) * best.condition)
          << "patch " << scene.visible[i];
      if (viewCount == 1) {
        // GLSL allows log2 three units in the last place, and an aspect is the difference of two of some -17.
        ASSERT_NEAR(measures[i].logAspect, static_cast<float>(best.logAspect), 3e-5f + 3.0f * rounding);
      }
      if (best.condition < 100) worst = std::max(worst, error);
    }
    EXPECT_GT(compared, measures.size() * 9 / 10);
    std::printf("%u views: largest error of log2 area, well-conditioned: %.2g\n", viewCount,
                static_cast<double>(worst));
    const std::uint64_t summed = idealOf(state);
    EXPECT_NEAR(static_cast<double>(summed), static_cast<double>(ideal),
                1e-5 * static_cast<double>(ideal) + 2.0);
    EXPECT_NEAR(static_cast<double>(onesOf(state)), ones, 2.0);
    EXPECT_GT(ones, 0u);
    // Every frame sums anew.
    memory.allocate(scene.dispatch, scene.frame);
    memory.measure(scene.dispatch, viewCount);
    EXPECT_EQ(idealOf(memory.readState()), summed);
    EXPECT_EQ(onesOf(memory.readState()), onesOf(state));
  }
}

TEST_F(MeasurePass, TheIdealAreaPasses32Bits) {
  // 70000 patches of 2^20 texels each: 2^36.
  PatchScene scene(70000, 0, 0, 1, 5.0f);
  scene.upload({viewFrom(0, 0, 1, 1e9f)}, scene.patchCount);
  RectMemoryOptions options;
  options.superblockLog2 = 10;
  options.targetShare = 0.75f;
  RectMemory memory = make(options, scene.patchCount);
  memory.measure(scene.dispatch, 1);
  const glsl::AtlasState state = memory.readState();
  EXPECT_EQ(idealOf(state), std::uint64_t{70000} << 20);
  memory.allocate(scene.dispatch, scene.frame);
  const RectStatistics statistics = memory.readStatistics();
  EXPECT_NEAR(statistics.bias, std::log2(70000.0 * 1048576.0 / (0.75 * 4096 * 2048)), 1e-3);
  EXPECT_EQ(statistics.failures, 0u);
  memory.measure(scene.dispatch, 1);
  EXPECT_EQ(idealOf(memory.readState()), std::uint64_t{70000} << 20) << "a frame's sum went on into the next";
}

TEST_F(MeasurePass, NothingVisible) {
  PatchScene scene(10, 0, 0, 1, 1.0f);
  scene.upload({viewFrom(0, 0, 30, 900)}, 0);
  RectMemory memory = make({}, scene.patchCount);
  for (int frame = 0; frame < 3; ++frame) {
    memory.measure(scene.dispatch, 1);
    memory.allocate(scene.dispatch, scene.frame);
  }
  const RectStatistics statistics = memory.readStatistics();
  EXPECT_EQ(statistics.visiblePatches, 0u);
  EXPECT_EQ(statistics.samples, 0u);
  EXPECT_EQ(statistics.bias, 0.0f);
  EXPECT_EQ(statistics.frames, 3u);
  EXPECT_TRUE(checkPartition(memory.readSnapshot()));
}

TEST_F(MeasurePass, PressureBringsDemandIntoTheAtlas) {
  PatchScene scene(4000, 500, 500, 4, 0.5f);
  RectMemoryOptions options;
  options.width = options.height = 512;
  options.superblockLog2 = 6;
  RectMemory memory = make(options, scene.patchCount);
  std::uint32_t lateFailures = 0;
  float wanted = 0.0f;
  for (std::uint32_t frame = 1; frame <= 60; ++frame) {
    // The camera turns about and comes near: ten times and more of what the atlas holds.
    const float turn = 0.02f * static_cast<float>(frame);
    scene.upload({viewFrom(60 * std::sin(turn), 3, 60 * std::cos(turn), 2500)},
                 scene.patchCount - 100 * frame);
    memory.measure(scene.dispatch, 1);
    const glsl::AtlasState measured = memory.readState();
    wanted = static_cast<float>(idealOf(measured)) / (512.0f * 512.0f);
    memory.allocate(scene.dispatch, scene.frame);
    const RectStatistics statistics = memory.readStatistics();
    EXPECT_LE(statistics.liveTexels, 512u * 512u);
    if (frame <= 20) continue;
    lateFailures += statistics.failures;
    EXPECT_GT(statistics.liveTexels, 512u * 512u / 4) << "the bias leaves most of the atlas empty";
  }
  const RectStatistics statistics = memory.readStatistics();
  std::printf(
      "demand %.1f atlases: bias %.2f, live %.2f, target %.2f, resets %u, failures after frame 20: %u\n",
      static_cast<double>(wanted), static_cast<double>(statistics.bias),
      static_cast<double>(statistics.liveTexels) / (512.0 * 512.0),
      static_cast<double>(statistics.target) / (512.0 * 512.0), statistics.resets, lateFailures);
  EXPECT_GT(wanted, 5.0f);
  EXPECT_LE(lateFailures, scene.patchCount / 100);
  EXPECT_LE(statistics.resets, 4u);
  EXPECT_TRUE(checkPartition(memory.readSnapshot()));
  // Without the bias the same demand cannot be met.
  options.pressureBias = false;
  RectMemory without = make(options, scene.patchCount);
  without.measure(scene.dispatch, 1);
  without.allocate(scene.dispatch, scene.frame);
  EXPECT_GT(without.readStatistics().failures, scene.patchCount / 4);
}

TEST_F(MeasurePass, TheTargetIsCutByPressureAndGrowsBack) {
  PatchScene scene(2000, 0, 0, 1, 0.5f);
  RectMemoryOptions options;
  options.width = options.height = 512;
  options.superblockLog2 = 6;
  options.targetShare = options.targetLargest = 0.5f;
  options.targetCut = 0.75f;
  options.targetGrowth = 1.0078125f;
  options.biasFloor = -4.0f;
  options.quietFrames = 4;
  options.highWater = 0.4f;  // half the atlas is wanted, so each reset is followed by another till S fits
  RectMemory memory = make(options, scene.patchCount);
  const float largest = 0.5f * 512 * 512;
  const auto frame = [&](std::uint32_t visible) {
    scene.upload({viewFrom(0, 0, 60, 5000)}, visible);
    memory.measure(scene.dispatch, 1);
    memory.allocate(scene.dispatch, scene.frame);
    return memory.readStatistics();
  };
  EXPECT_EQ(frame(scene.patchCount).target, largest);
  RectStatistics statistics = frame(scene.patchCount);
  EXPECT_EQ(statistics.resets, 1u);
  EXPECT_EQ(statistics.target, largest * 0.75f);
  for (int i = 0; i < 40 && statistics.load > 0.4f; ++i) statistics = frame(scene.patchCount);
  EXPECT_LE(statistics.load, 0.4f) << "S was not cut far enough to pass under the mark";
  memory.reset();
  float target = statistics.target;
  const std::uint32_t few = scene.patchCount / 4;
  for (int i = 0; i < 4; ++i) EXPECT_EQ(frame(few).target, target) << "grew in the quiet time";
  for (int i = 0; i < 3; ++i) {
    statistics = frame(few);
    EXPECT_FLOAT_EQ(statistics.target, target * 1.0078125f);
    target = statistics.target;
  }
  // What asks for less than S even at the lowest bias is not limited by S: it stays.
  EXPECT_EQ(frame(1).bias, -4.0f);
  const float rests = frame(1).target;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(frame(1).target, rests);
}

TEST_F(MeasurePass, AboveTheSoftMarkTheTargetShrinks) {
  PatchScene scene(2000, 0, 0, 1, 0.5f);
  RectMemoryOptions options;
  options.width = options.height = 512;
  options.superblockLog2 = 6;
  options.biasFloor = -4.0f;
  options.softWater = 0.5f;
  options.targetShare = 0.65f;
  options.highWater = 1.0f;
  options.targetGrowth = 1.01f;
  RectMemory memory = make(options, scene.patchCount);
  options.merge = false;
  RectMemory plain = make(options, scene.patchCount);
  const auto frame = [&](RectMemory& of) {
    scene.upload({viewFrom(0, 0, 60, 5000)}, scene.patchCount);
    of.measure(scene.dispatch, 1);
    of.allocate(scene.dispatch, scene.frame);
    return of.readStatistics();
  };
  constexpr float kTexels = 512.0f * 512.0f;
  EXPECT_EQ(frame(memory).target, 0.65f * kTexels);
  RectStatistics last;
  for (int i = 0; i < 120; ++i) last = frame(memory);
  EXPECT_LE(static_cast<float>(last.liveTexels), 0.51f * kTexels);
  EXPECT_GT(static_cast<float>(last.liveTexels), 0.40f * kTexels);
  EXPECT_EQ(frame(plain).target, 0.65f * kTexels);
  EXPECT_EQ(frame(plain).target, 0.65f * kTexels) << "the published strategies know no soft mark";
}

TEST_F(MeasurePass, CountsWhatTheLastFrameDidNotSee) {
  PatchScene scene(600, 0, 0, 1, 0.5f);
  RectMemory memory = make({}, scene.patchCount);
  const auto newTexels = [&](std::uint32_t visible) {
    scene.upload({viewFrom(0, 0, 60, 5000)}, visible);
    memory.measure(scene.dispatch, 1);
    const glsl::AtlasState measured = memory.readState();
    std::uint64_t fresh = 0;
    std::uint64_t all = 0;
    for (const glsl::IdealSum& sum : measured.ideal) {
      fresh += (std::uint64_t{sum.newHigh} << 32) + sum.newLow;
      all += (std::uint64_t{sum.high} << 32) + sum.low;
    }
    memory.allocate(scene.dispatch, scene.frame);
    return std::pair(fresh, all);
  };
  const auto first = newTexels(scene.patchCount / 2);
  EXPECT_EQ(first.first, first.second);
  EXPECT_GT(first.first, 0u);
  EXPECT_EQ(newTexels(scene.patchCount / 2).first, 0u);
  const auto third = newTexels(scene.patchCount);
  EXPECT_EQ(third.first, third.second - first.second);
  EXPECT_EQ(newTexels(scene.patchCount / 2).first, 0u);
  EXPECT_EQ(newTexels(scene.patchCount).first, third.first)
      << "what went out of sight is new when it comes back";
}

TEST_F(MeasurePass, ConstantBiasHalvesTexels) {
  PatchScene scene(5000, 0, 0, 1, 0.3f);
  scene.upload({viewFrom(0, 0, 60, 900)}, scene.patchCount);
  RectMemoryOptions options;
  options.pressureBias = false;
  RectMemory memory = make(options, scene.patchCount);
  const auto samples = [&](float bias) {
    memory.setBias(bias);
    memory.reset();
    memory.measure(scene.dispatch, 1);
    memory.allocate(scene.dispatch, scene.frame);
    EXPECT_EQ(memory.readStatistics().failures, 0u);
    EXPECT_EQ(memory.readStatistics().bias, bias);
    return static_cast<double>(memory.readStatistics().samples);
  };
  const double native = samples(0.0f);
  EXPECT_NEAR(samples(-2.0f) / native, 4.0, 0.15);
  EXPECT_NEAR(samples(1.0f) / native, 0.5, 0.03);
}

// Printed, not judged: an absolute time of a software renderer says little. The share of a frame is in the
// report of `tessera compare`.
TEST_F(MeasurePass, CostOfSixtyThousandPatches) {
  PatchScene scene(50000, 5000, 5000, 1, 0.1f);
  RectMemory memory = make({}, scene.patchCount);
  gl::Timer timer(gl::timerModeFor(test::context().info()));
  for (const bool moving : {false, true}) {
    std::vector<double> measuring;
    std::vector<double> allocating;
    for (int frame = 0; frame < 30; ++frame) {
      const float eye = moving ? 60.0f + 4.0f * static_cast<float>(frame % 2) : 60.0f;
      scene.upload({viewFrom(0, 0, eye, 900)}, scene.patchCount);
      timer.begin();
      memory.measure(scene.dispatch, 1);
      timer.end();
      measuring.push_back(timer.milliseconds());
      timer.begin();
      memory.allocate(scene.dispatch, scene.frame);
      timer.end();
      allocating.push_back(timer.milliseconds());
    }
    const auto median = [](std::vector<double>& values) {
      std::nth_element(values.begin(), values.begin() + 15, values.end());
      return values[15];
    };
    std::printf("60000 patches, %s: measure %.2f ms, allocate %.2f ms (median of 30), %u failures\n",
                moving ? "levels changing" : "steady", median(measuring), median(allocating),
                memory.readStatistics().failures);
  }
  EXPECT_EQ(memory.readStatistics().visiblePatches, 60000u);
}

/// Offsets of a member as the driver lays the block out.
GLint offsetOf(GLuint program, const char* name) {
  const GLuint index = gl::api().GetProgramResourceIndex(program, GL_BUFFER_VARIABLE, name);
  if (index == GL_INVALID_INDEX) return -1;
  const GLenum property = GL_OFFSET;
  GLint value = -1;
  gl::api().GetProgramResourceiv(program, GL_BUFFER_VARIABLE, index, 1, &property, 1, nullptr, &value);
  return value;
}

TEST_F(MeasurePass, StructsHaveTheSameLayoutInBothLanguages) {
  auto found = programs.get({"pass/rect_plan.comp"});
  ASSERT_TRUE(found);
  GLuint program = (*found)->get();
#define EXPECT_MEMBER(member) \
  EXPECT_EQ(offsetOf(program, "atlas." #member), static_cast<GLint>(offsetof(glsl::AtlasState, member)))
#define EXPECT_CONFIG(member)                           \
  EXPECT_EQ(offsetOf(program, "atlas.config." #member), \
            static_cast<GLint>(offsetof(glsl::AtlasState, config) + offsetof(glsl::AtlasConfig, member)))
#define EXPECT_LEVEL(member)                               \
  EXPECT_EQ(offsetOf(program, "atlas.levels[0]." #member), \
            static_cast<GLint>(offsetof(glsl::AtlasState, levels) + offsetof(glsl::LevelState, member)))
#define EXPECT_BIN(member)                               \
  EXPECT_EQ(offsetOf(program, "atlas.bins[0]." #member), \
            static_cast<GLint>(offsetof(glsl::AtlasState, bins) + offsetof(glsl::BinState, member)))
  EXPECT_CONFIG(width);
  EXPECT_CONFIG(height);
  EXPECT_CONFIG(superblockLog2);
  EXPECT_CONFIG(superblocks);
  EXPECT_CONFIG(patchInstances);
  EXPECT_CONFIG(views);
  EXPECT_CONFIG(biased);
  EXPECT_CONFIG(columns);
  EXPECT_CONFIG(stacks);
  EXPECT_CONFIG(merges);
  EXPECT_CONFIG(mergeLoad);
  EXPECT_CONFIG(constantBias);
  EXPECT_CONFIG(lowestBias);
  EXPECT_CONFIG(hysteresis);
  EXPECT_CONFIG(range.smallest);
  EXPECT_CONFIG(range.largest);
  EXPECT_CONFIG(range.aspect);
  EXPECT_CONFIG(pressure.highWater);
  EXPECT_CONFIG(pressure.softWater);
  EXPECT_CONFIG(pressure.targetStart);
  EXPECT_CONFIG(pressure.targetLargest);
  EXPECT_CONFIG(pressure.targetSmallest);
  EXPECT_CONFIG(pressure.targetCut);
  EXPECT_CONFIG(pressure.targetGrowth);
  EXPECT_CONFIG(pressure.quietFrames);
  EXPECT_CONFIG(pressure.resets);
  EXPECT_CONFIG(pressure.adapts);
  EXPECT_MEMBER(requestGroupsX);
  EXPECT_MEMBER(requestGroupsY);
  EXPECT_MEMBER(requestGroupsZ);
  EXPECT_MEMBER(epoch);
  EXPECT_MEMBER(mergeGroupsX);
  EXPECT_MEMBER(mergeGroupsY);
  EXPECT_MEMBER(mergeGroupsZ);
  EXPECT_MEMBER(mergeHeight);
  EXPECT_MEMBER(superblocksFree);
  EXPECT_MEMBER(pressureBias);
  EXPECT_MEMBER(cutTexels);
  EXPECT_MEMBER(pressure.target);
  EXPECT_MEMBER(pressure.quiet);
  EXPECT_MEMBER(pressure.sinceReset);
  EXPECT_MEMBER(pressure.sinceCut);
  EXPECT_MEMBER(pressure.wait);
  EXPECT_MEMBER(pressure.pending);
  EXPECT_MEMBER(pressure.reset);
  EXPECT_MEMBER(events.failures);
  EXPECT_MEMBER(events.moved);
  EXPECT_MEMBER(events.movedTexels);
  EXPECT_MEMBER(events.freed);
  EXPECT_MEMBER(events.merged);
  EXPECT_MEMBER(events.reduced);
  EXPECT_MEMBER(events.waiting);
  EXPECT_MEMBER(visible);
  EXPECT_MEMBER(resets);
  EXPECT_MEMBER(frames);
  EXPECT_LEVEL(stackCount);
  EXPECT_LEVEL(requested);
  EXPECT_LEVEL(slotOffset);
  EXPECT_LEVEL(slotCount);
  EXPECT_LEVEL(existing);
  EXPECT_LEVEL(lost);
  EXPECT_LEVEL(stackBase);
  EXPECT_LEVEL(stackCapacity);
  EXPECT_LEVEL(lastRequested);
  EXPECT_BIN(carryOffset);
  EXPECT_BIN(carrySuperblock);
  EXPECT_BIN(firstPopped);
  EXPECT_BIN(popped);
  EXPECT_BIN(sourceSuperblock);
  EXPECT_EQ(offsetOf(program, "atlas.ideal[0].ones"),
            static_cast<GLint>(offsetof(glsl::AtlasState, ideal) + offsetof(glsl::IdealSum, ones)));
  EXPECT_EQ(offsetOf(program, "atlas.ideal[1].low"),
            static_cast<GLint>(offsetof(glsl::AtlasState, ideal) + sizeof(glsl::IdealSum)));
  const auto strideOf = [&](const char* name) {
    const GLuint index = gl::api().GetProgramResourceIndex(program, GL_BUFFER_VARIABLE, name);
    const GLenum property = GL_TOP_LEVEL_ARRAY_STRIDE;
    GLint value = -1;
    if (index != GL_INVALID_INDEX)
      gl::api().GetProgramResourceiv(program, GL_BUFFER_VARIABLE, index, 1, &property, 1, nullptr, &value);
    return value;
  };
  auto assign = programs.get({"pass/rect_assign.comp"});
  ASSERT_TRUE(assign);
  program = (*assign)->get();
  EXPECT_EQ(strideOf("patchStates[0].origin"), static_cast<GLint>(sizeof(glsl::PatchState)));
  EXPECT_EQ(offsetOf(program, "patchStates[0].level"), static_cast<GLint>(offsetof(glsl::PatchState, level)));
  EXPECT_EQ(offsetOf(program, "patchStates[0].epoch"), static_cast<GLint>(offsetof(glsl::PatchState, epoch)));
  auto measure = programs.get({"pass/rect_measure.comp"});
  ASSERT_TRUE(measure);
  program = (*measure)->get();
  EXPECT_EQ(strideOf("measures[0].logArea"), static_cast<GLint>(sizeof(glsl::PatchMeasure)));
  EXPECT_EQ(strideOf("patches[0].v0"), static_cast<GLint>(sizeof(glsl::PatchGeometry)));
  EXPECT_EQ(strideOf("instances[0].row0"), static_cast<GLint>(sizeof(glsl::InstanceGpu)));
}

}  // namespace
}  // namespace tessera
