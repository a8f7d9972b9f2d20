#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>

#include <gtest/gtest.h>

#include "glsl/shared/tess_measure.h"
#include "tests/tessellation/reference.hpp"

namespace tessera {
namespace {

using glm::vec3;
using glsl::OverShape;
using glsl::TessMeasure;
using glsl::TessShape;
using glsl::uint;
using test::Long;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kPixels = 1000.0f;  // a radian
// Thresholds that some triangles are past, every one, and none.
constexpr glsl::TessLimits kSlanted{4.0f, 254.0f, glsl::kOverWidest};
constexpr glsl::TessLimits kAll{0.5f, 254.0f, glsl::kOverWidest};
constexpr glsl::TessLimits kNone{1e9f, 254.0f, glsl::kOverWidest};

TessMeasure measure(vec3 a, vec3 b, vec3 c) { return glsl::measureTriangle(a, b, c, kPixels); }
TessShape shapeOf(vec3 a, vec3 b, vec3 c) { return glsl::shapeAt(measure(a, b, c), 1.0f, kSlanted); }
bool same(const TessShape& a, const TessShape& b) {
  return a.kind == b.kind && a.size == b.size && a.form == b.form;
}

/// Whatever it is, it can be placed, spawned and stored.
void expectValid(const TessShape& shape) {
  const uint kind = glsl::kindOf(shape.kind);
  ASSERT_NE(kind, glsl::kTessNone);
  if (kind == glsl::kTessL) {
    ASSERT_GE(glsl::levelOfKind(shape.kind), 1u);
    ASSERT_LE(glsl::levelOfKind(shape.kind), glsl::kLargestLevel);
  }
  if (kind != glsl::kTessOver) return;
  const OverShape over = glsl::overOfShape(shape);
  ASSERT_LE(over.apex, 2u);
  ASSERT_GE(over.rows, 1u);
  ASSERT_LE(over.rows, 129u);
  ASSERT_GT(over.columns0 + over.columns1, 1u);
  ASSERT_GT(glsl::overCount(over), 0u);
  for (const uint columns : {over.columns0, over.columns1}) {
    if (columns == 0) continue;
    // The bin that it goes to has blocks of its size.
    ASSERT_GE(columns, 2u);
    ASSERT_LE(columns, 1025u);
    ASSERT_EQ(glsl::overBinBlock(glsl::overBin(columns, over.rows)), glm::uvec2(columns, over.rows));
  }
  for (uint thread = 0; thread < glsl::overCount(over); thread += 7) {
    const vec3 p = glsl::overEven(glsl::overCellOf(thread, over), over);
    ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  }
}

TEST(TessMeasure, ShapesByHand) {
  // Pixels of a millionth of a radian: a triangle's angles are its lengths.
  const auto at = [](float x, float y) { return vec3(x * 1e-5f, y * 1e-5f, -10.0f); };
  const auto measure = [](vec3 a, vec3 b, vec3 c) { return glsl::measureTriangle(a, b, c, 1e6f); };
  const auto shapeOf = [&](vec3 a, vec3 b, vec3 c) {
    return glsl::shapeAt(measure(a, b, c), 1.0f, kSlanted);
  };
  const auto shape = [&](float x, float y, float apex) { return shapeOf(at(0, 0), at(x, 0), at(apex, y)); };
  EXPECT_EQ(shape(0.99f, 0.5f, 0.4f).kind, glsl::kTessSingle);
  EXPECT_EQ(shape(1.5f, 1.2f, 0.7f).kind, glsl::kindOfL(2));
  EXPECT_EQ(shape(3.5f, 3.0f, 1.5f).kind, glsl::kindOfL(4));
  EXPECT_EQ(shape(63.5f, 50.0f, 30.0f).kind, glsl::kindOfL(64));
  EXPECT_EQ(shape(64.5f, 50.0f, 30.0f).kind, glsl::kindOfL(65));
  EXPECT_EQ(shape(253.5f, 200.0f, 120.0f).kind, glsl::kindOfL(254));
  EXPECT_EQ(shape(700.0f, 600.0f, 300.0f).kind, glsl::kindOfL(glsl::kLargestLevel));
  const TessMeasure m = measure(at(0, 0), at(40, 0), at(15, 3.5f));
  EXPECT_NEAR(m.edge2, 40.0f, 1e-2f);
  EXPECT_NEAR(m.height, 3.5f, 1e-2f);
  const TessShape slanted = shape(40.0f, 3.5f, 15.0f);
  ASSERT_EQ(slanted.kind, glsl::kTessOver);
  const OverShape over = glsl::overOfShape(slanted);
  EXPECT_EQ(over.apex, 2u);
  EXPECT_EQ(over.rows, 5u);
  EXPECT_EQ(over.columns0, 1u + 15u);
  EXPECT_EQ(over.columns1, 1u + 26u);  // 25 steps are rounded up to 26
  EXPECT_NEAR(glsl::overFoot(over), 15.0f / 40.0f, 1e-3f);
  // Just on either side of the threshold: 4 to 1.
  EXPECT_EQ(glsl::kindOf(shape(40.0f, 10.1f, 15.0f).kind), glsl::kTessL);
  EXPECT_EQ(glsl::kindOf(shape(40.0f, 9.9f, 15.0f).kind), glsl::kTessOver);
  // Mirrored, turned and seen from behind: only lengths count.
  EXPECT_EQ(glsl::overOfShape(shapeOf(at(15, 3.5f), at(40, 0), at(0, 0))).rows, 5u);
  EXPECT_EQ(glsl::overOfShape(shapeOf(at(0, 0), at(15, 3.5f), at(40, 0))).apex, 1u);
  EXPECT_EQ(shapeOf(-at(0, 0), -at(3.5f, 0), -at(1.5f, 3)).kind, glsl::kindOfL(4));
  // Each method alone.
  EXPECT_EQ(glsl::shapeAt(measure(at(0, 0), at(20, 0), at(10, 17)), 1.0f, kAll).kind, glsl::kTessOver);
  EXPECT_EQ(glsl::shapeAt(measure(at(0, 0), at(20, 0), at(10, 0)), 1.0f, kNone).kind, glsl::kindOfL(20));
  // A bias of 2 halves lengths.
  EXPECT_EQ(
      glsl::selectShape(measure(at(0, 0), at(63.5f, 0), at(30, 50)), 2.0f, 0.0f, kSlanted, {}, -1.0f).kind,
      glsl::kindOfL(32));
}

TEST(TessMeasure, LengthsAgainstLongDouble) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  using Vector = std::array<Long, 3>;
  const auto wide = [](vec3 v) { return test::Bary{v.x, v.y, v.z}; };
  const auto cross = [](const Vector& a, const Vector& b) {
    return Vector{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto dot = [](const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  for (int i = 0; i < 30000; ++i) {
    // All around the eye, from far away and small to reaching past it.
    const float distance = std::exp2(unit(random) * 6.0f + 3.0f);
    const float size = distance * std::exp2(unit(random) * 5.0f - 4.0f);
    const vec3 middle = vec3(unit(random), unit(random), unit(random)) * distance;
    std::array<vec3, 3> v;
    for (vec3& corner : v) corner = middle + vec3(unit(random), unit(random), unit(random)) * size;
    const TessMeasure m = measure(v[0], v[1], v[2]);
    const std::array<float, 3> found = {m.edge0, m.edge1, m.edge2};
    std::array<Long, 3> edges{};
    for (std::size_t edge = 0; edge < 3; ++edge) {
      const Vector a = wide(v[(edge + 1) % 3]);
      const Vector b = wide(v[(edge + 2) % 3]);
      const Vector c = cross(a, b);
      edges[edge] = kPixels * std::atan2(std::sqrt(dot(c, c)), dot(a, b));
      ASSERT_NEAR(static_cast<double>(found[edge]), static_cast<double>(edges[edge]),
                  1e-3 + 1e-5 * static_cast<double>(edges[edge]));
    }
    // The height of the flat triangle with these edges, by Heron. Around the eye no flat triangle has them.
    const Long longest = std::max({edges[0], edges[1], edges[2]});
    const Long s = (edges[0] + edges[1] + edges[2]) / 2;
    const Long square = s * (s - edges[0]) * (s - edges[1]) * (s - edges[2]);
    const Long height = 2 * std::sqrt(std::max(square, Long{0})) / longest;
    if (height < 0.05L * longest) continue;
    ASSERT_NEAR(static_cast<double>(m.height), static_cast<double>(height),
                1e-3 + 1e-3 * static_cast<double>(height));
  }
}

TEST(TessMeasure, TrianglesAroundTheEyeAskForWhatAnEyeCanSee) {
  const float half = kPixels * 3.1416f;
  // A floor from far ahead to behind the eye: edges are half a turn at most.
  const TessMeasure floor = measure({-1, -1, -100}, {1, -1, -100}, {0, -1, 5});
  EXPECT_LE(glsl::longestOf(floor), half);
  EXPECT_GT(glsl::longestOf(floor), 0.9f * half);
  // A corner that all but touches the eye, on either side of its plane.
  for (const float z : {-0.09f, -1e-3f, -1e-6f, 0.0f, 1e-6f, 1e-3f}) {
    const TessMeasure m = measure({0.01f, 0.01f, z}, {1, 0, -10}, {0, 1, -10});
    EXPECT_LE(glsl::longestOf(m), half) << z;
    EXPECT_GT(glsl::longestOf(m), 10.0f) << z;
    const vec3 w = glsl::depthWeights({0.01f, 0.01f, z}, {1, 0, -10}, {0, 1, -10});
    EXPECT_GT(std::min({w.x, w.y, w.z}), 0.0f) << z;
  }
  // Wholly behind the eye, as another view of the visible set may see it: the size that it has from there.
  EXPECT_EQ(shapeOf({0, 0, 10}, {0.195f, 0, 10}, {0.1f, 0.17f, 10}).kind, glsl::kindOfL(20));
  // The eye on a corner, and in the middle of the triangle.
  expectValid(shapeOf({0, 0, 0}, {1, 0, -1}, {0, 1, -1}));
  expectValid(shapeOf({1, 0, 0}, {-1, 1, 0}, {0, -1, 0}));
}

// The camera that looks at the triangle from the eye: a step in even coordinates is the same step on its
// screen.
TEST(TessMeasure, WeightsMakeSamplesEvenOnTheScreenThatFacesTheTriangle) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  for (int i = 0; i < 20000; ++i) {
    const vec3 middle = vec3(unit(random), unit(random), unit(random)) * 10.0f;
    if (glm::length(middle) < 1.0f) continue;
    std::array<vec3, 3> v;
    for (vec3& corner : v)
      corner = middle + vec3(unit(random), unit(random), unit(random)) * (0.5f * glm::length(middle));
    const vec3 axis = v[0] + v[1] + v[2];
    const vec3 depth(glm::dot(v[0], axis), glm::dot(v[1], axis), glm::dot(v[2], axis));
    if (std::min({depth.x, depth.y, depth.z}) < 1e-3f * std::max({depth.x, depth.y, depth.z})) continue;
    const vec3 w = glsl::depthWeights(v[0], v[1], v[2]);
    ASSERT_EQ(std::max({w.x, w.y, w.z}), 1.0f);
    const vec3 even = test::randomBary(random);
    const vec3 b = glsl::surfaceFromEven(even, w);
    const vec3 point = b.x * v[0] + b.y * v[1] + b.z * v[2];
    // On the plane at depth 1 along the axis.
    const auto screen = [&](vec3 p) { return p / glm::dot(p, axis); };
    const vec3 expected = even.x * screen(v[0]) + even.y * screen(v[1]) + even.z * screen(v[2]);
    const float scale =
        std::max({glm::length(screen(v[0])), glm::length(screen(v[1])), glm::length(screen(v[2]))});
    ASSERT_LT(glm::length(screen(point) - expected), 2e-5f * scale) << i;
  }
}

/// A triangle of any kind: flat, a point, a needle, around the eye, or with numbers that are none.
std::array<vec3, 3> hostileTriangle(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::array<vec3, 3> v;
  for (vec3& corner : v)
    corner = vec3(unit(random), unit(random), unit(random)) * std::exp2(unit(random) * 20.0f);
  const auto any = [&] { return static_cast<std::size_t>(random() % 3); };
  switch (random() % 12) {
    case 0:
      v[1] = v[0] + (v[2] - v[0]) * 0.3f;
      break;
    case 1:
      v[1] = v[0];
      break;
    case 2:
      v[2] = v[1] = v[0];
      break;
    case 3:
      v[1] = v[0] + vec3(1e-7f, 0, 0) * glm::length(v[2] - v[0]);
      break;
    case 4:
      v[any()].z = -1e-6f;
      break;
    case 5:
      v[any()] = vec3(0.0f);
      break;
    case 6: {
      const float bad[] = {kNan, kInfinity, -kInfinity, 1e38f, -1e38f, 1e-40f};
      v[any()][static_cast<int>(any())] = bad[random() % 6];
      break;
    }
    case 7:
      v[0].z = -1.0f, v[1].z = -1e4f, v[2].z = -1e6f;
      break;
    case 8:  // the eye on an edge
      v[1] = -v[0] * 0.3f;
      break;
    case 9:  // and inside
      v[2] = -(v[0] + v[1]);
      break;
    default:
      break;
  }
  return v;
}

TEST(TessMeasure, HostileTrianglesGetValidSamples) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  int kinds[4] = {};
  for (int i = 0; i < 100000; ++i) {
    const auto v = hostileTriangle(random);
    const float pixels = std::exp2(unit(random) * 8.0f);
    const TessMeasure m = glsl::measureTriangle(v[0], v[1], v[2], pixels);
    for (const float length : {m.edge0, m.edge1, m.edge2, m.height})
      ASSERT_TRUE(length >= 0.0f && length <= 3.1416f * pixels) << i << ": " << length;
    const glsl::TessLimits& threshold = random() % 4 != 0 ? kSlanted : (random() % 2 == 0 ? kAll : kNone);
    const TessShape shape = glsl::shapeAt(m, std::exp2(unit(random) * 8.0f), threshold);
    expectValid(shape);
    // Whatever is said to have been before.
    const auto word = [&] { return static_cast<uint>(random()); };
    const TessShape before{word(), word(), word()};
    const TessShape selected =
        glsl::selectShape(m, unit(random) * 20.0f, unit(random) * 20.0f, threshold, before, -1.0f);
    expectValid(selected);
    const TessShape kept =
        glsl::selectShape(m, unit(random) * 20.0f, unit(random) * 20.0f, threshold, selected, 0.1f);
    expectValid(kept);
    const vec3 w = glsl::depthWeights(v[0], v[1], v[2]);
    for (int axis = 0; axis < 3; ++axis) ASSERT_TRUE(w[axis] > 0.0f && w[axis] <= 1.0f) << i;
    if (HasFatalFailure()) {
      ADD_FAILURE() << "triangle " << i << ": lengths " << m.edge0 << " " << m.edge1 << " " << m.edge2 << " "
                    << m.height;
      return;
    }
    ++kinds[glsl::kindOf(shape.kind)];
  }
  for (const uint kind : {glsl::kTessSingle, glsl::kTessL, glsl::kTessOver}) EXPECT_GT(kinds[kind], 3000);
}

TEST(TessMeasure, LengthsThatAreNoneGiveValidShapes) {
  for (const float bad : {kNan, kInfinity, -kInfinity, -1.0f, 0.0f, 3e38f, 1e-40f})
    for (int field = 0; field < 4; ++field)
      for (const float scale : {1.0f, kNan, kInfinity, 0.0f, 1e30f}) {
        TessMeasure m{20.0f, 19.0f, 18.0f, 2.0f};
        (field == 0 ? m.edge0 : field == 1 ? m.edge1 : field == 2 ? m.edge2 : m.height) = bad;
        for (const glsl::TessLimits& threshold : {kSlanted, kAll, kNone}) {
          expectValid(glsl::shapeAt(m, scale, threshold));
          ASSERT_FALSE(HasFatalFailure()) << bad << " in field " << field << ", scale " << scale;
          expectValid(glsl::selectShape(m, bad, bad, threshold, {glsl::kindOfL(3), 0, 0}, bad));
          ASSERT_FALSE(HasFatalFailure()) << bad << " in field " << field << ", scale " << scale;
        }
      }
  EXPECT_EQ(glsl::shapeAt({0, 0, 0, 0}, 1.0f, kSlanted).kind, glsl::kTessSingle);
  EXPECT_EQ(glsl::depthWeights(vec3(0.0f), vec3(0.0f), vec3(0.0f)), vec3(1.0f));
}

/// A measure with a base of `base`, log-uniform slantedness and any foot.
TessMeasure plausibleMeasure(std::mt19937& random, float base) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const float foot = unit(random);
  const float tallest =
      std::sqrt(std::max(1.0f - std::max(foot, 1.0f - foot) * std::max(foot, 1.0f - foot), 0.0f));
  const float height = tallest * base * std::exp2(-unit(random) * 8.0f);
  std::array<float, 3> edges = {base, std::hypot((1.0f - foot) * base, height),
                                std::hypot(foot * base, height)};
  std::rotate(edges.begin(), edges.begin() + random() % 3, edges.end());
  return {edges[0], edges[1], edges[2], height};
}

TEST(TessMeasure, LargerTrianglesGetMoreSamples) {
  std::mt19937 random(4);
  for (int i = 0; i < 500; ++i) {
    const TessMeasure m = plausibleMeasure(random, 1.0f);
    TessShape last = glsl::shapeAt(m, 0.5f, kSlanted);
    EXPECT_EQ(last.kind, glsl::kTessSingle);
    for (float scale = 0.5f; scale < 4000.0f; scale *= 1.013f) {
      const TessShape shape = glsl::shapeAt(m, scale, kSlanted);
      const uint kind = glsl::kindOf(shape.kind);
      if (glsl::kindOf(last.kind) != glsl::kTessSingle) {
        ASSERT_EQ(kind, glsl::kindOf(last.kind)) << "size alone changes the kind";
      }
      if (kind == glsl::kTessL && kind == glsl::kindOf(last.kind)) {
        ASSERT_GE(shape.kind, last.kind);
      }
      if (kind == glsl::kTessOver && kind == glsl::kindOf(last.kind)) {
        const OverShape a = glsl::overOfShape(last);
        const OverShape b = glsl::overOfShape(shape);
        ASSERT_EQ(a.apex, b.apex);
        ASSERT_GE(b.rows, a.rows) << scale;
        // A half that is no longer dropped takes its part of the base: each is rounded up by an eighth.
        ASSERT_GE(9 * glsl::overStepsOf(b) + 18, 8 * glsl::overStepsOf(a)) << scale;
      }
      ASSERT_LE(glsl::texelsOfShape(shape), 1000u * 131u);
      last = shape;
    }
  }
}

// Memory that runs short must reach those that are larger than any shape, too.
TEST(TessMeasure, PressureIsTakenOffWhatTheLimitsLeave) {
  constexpr glsl::TessLimits kSmall{4.0f, 100.0f, 200.0f};
  const TessMeasure wide{5000.0f, 4000.0f, 4000.0f, 3000.0f};
  EXPECT_EQ(glsl::selectShape(wide, 0.0f, 0.0f, kSmall, {}, -1.0f).kind, glsl::kindOfL(100));
  EXPECT_EQ(glsl::selectShape(wide, 0.0f, 2.0f, kSmall, {}, -1.0f).kind, glsl::kindOfL(50));
  EXPECT_EQ(glsl::selectShape(wide, 0.0f, -2.0f, kSmall, {}, -1.0f).kind, glsl::kindOfL(100));
  const TessMeasure slanted{6400.0f, 3200.0f, 3201.0f, 50.0f};
  const OverShape whole = glsl::overOfShape(glsl::selectShape(slanted, 0.0f, 0.0f, kSmall, {}, -1.0f));
  const OverShape half = glsl::overOfShape(glsl::selectShape(slanted, 0.0f, 2.0f, kSmall, {}, -1.0f));
  EXPECT_NEAR(glsl::overStepsOf(whole), 200.0, 16.0);
  EXPECT_NEAR(glsl::overStepsOf(half), 100.0, 8.0);
}

// What a camera's trembling does: lengths that change by less than the hysteresis never change the shape.
TEST(TessMeasure, TrianglesNearTheThresholdStayWhatTheyAre) {
  const auto kind = [](float ratio, uint before, float hysteresis) {
    const float half = 20.0f;
    const TessMeasure m =
        measure({-half / kPixels, 0, -1}, {half / kPixels, 0, -1}, {0, 2 * half / ratio / kPixels, -1});
    const TessShape previous =
        before == glsl::kTessL ? TessShape{glsl::kindOfL(30), 0, 0} : TessShape{before, 0, 0};
    return glsl::kindOf(glsl::selectShape(m, 0.0f, 0.0f, kSlanted, previous, hysteresis).kind);
  };
  for (const uint before : {glsl::kTessNone, glsl::kTessL, glsl::kTessOver}) {
    // Past the threshold of 4 by more than a factor of 2^0.1 = 1.07, or not.
    EXPECT_EQ(kind(4.5f, before, 0.1f), glsl::kTessOver);
    EXPECT_EQ(kind(3.6f, before, 0.1f), glsl::kTessL);
    const bool was = before == glsl::kTessOver;
    EXPECT_EQ(kind(4.1f, before, 0.1f), before == glsl::kTessL ? glsl::kTessL : glsl::kTessOver);
    EXPECT_EQ(kind(3.9f, before, 0.1f), was ? glsl::kTessOver : glsl::kTessL);
    EXPECT_EQ(kind(4.1f, before, -1.0f), glsl::kTessOver);
    EXPECT_EQ(kind(3.9f, before, -1.0f), glsl::kTessL);
  }
}

TEST(TessMeasure, HysteresisKeepsTheShapeThatATriangleHas) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  constexpr float kHysteresis = 0.05f;
  int kinds[4] = {};
  int keptOne = 0;
  for (int i = 0; i < 60000; ++i) {
    const float base = std::exp2(unit(random) * 11.0f - 1.0f);
    const TessMeasure m = plausibleMeasure(random, base);
    // Biases are log2 of area, twice that of length.
    const float bias = unit(random) * 4.0f - 2.0f;
    const float shake = (unit(random) * 2.0f - 1.0f) * 1.98f * kHysteresis;
    const TessShape held = glsl::selectShape(m, bias, 0.0f, kSlanted, {}, -1.0f);
    const TessShape now = glsl::selectShape(m, bias, shake, kSlanted, held, kHysteresis);
    ++kinds[glsl::kindOf(held.kind)];
    ASSERT_TRUE(same(held, now)) << "kind " << glsl::kindOf(held.kind) << ", base " << base << ", height "
                                 << m.height << ", bias " << bias << ", shake " << shake;
    keptOne += same(now, glsl::selectShape(m, bias, shake, kSlanted, {}, -1.0f)) ? 0 : 1;
    // What changed by more than the hysteresis and a step is let go.
    const TessShape far = glsl::selectShape(m, bias, 4.0f, kSlanted, held, kHysteresis);
    if (glsl::kindOf(held.kind) != glsl::kTessSingle && base * std::exp2(-0.5f * bias) > 4.0f &&
        base * std::exp2(-0.5f * bias) < 200.0f) {
      ASSERT_FALSE(same(held, far));
      ASSERT_TRUE(same(far, glsl::selectShape(m, bias, 4.0f, kSlanted, {}, -1.0f)));
    }
  }
  for (const uint kind : {glsl::kTessSingle, glsl::kTessL, glsl::kTessOver}) EXPECT_GT(kinds[kind], 2000);
  std::printf("%d of 60000 have a shape that hysteresis kept\n", keptOne);
  EXPECT_GT(keptOne, 5000);
}

}  // namespace
}  // namespace tessera
