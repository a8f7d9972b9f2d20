// Sample patterns, L-packing, the perspective map, splitting, and numbers at the precision of floats.
#include <algorithm>
#include <random>
#include <set>

#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/exact.hpp"
#include "engine/scene/build.hpp"
#include "glsl/shared/interpolate.h"
#include "glsl/shared/lpack.h"
#include "glsl/shared/perspective_map.h"
#include "glsl/shared/scene.h"
#include "glsl/shared/tess_measure.h"
#include "glsl/shared/tess_split.h"

namespace tessera::stability {

namespace {

using glsl::TessLevels;
using glsl::TessPlace;

std::vector<TessLevels> patterns() {
  std::vector<TessLevels> all;
  for (glsl::uint level = 1; level <= glsl::kTessLargest; ++level) all.push_back(glsl::tessUniform(level));
  for (const glsl::uint outer : {1U, 2U, 31U, 64U})
    for (const glsl::uint inner : {1U, 2U, 3U, 63U, 64U}) all.push_back({outer, 64, 1, inner});
  return all;
}

/// Numbers that do not come back from their place, or places that their coordinates do not name.
double wrongThreads() {
  double wrong = 0.0;
  for (const TessLevels& levels : patterns())
    for (glsl::uint thread = 0; thread < glsl::tessCount(levels); ++thread) {
      const TessPlace place = glsl::tessPlaceOf(thread, levels);
      wrong += glsl::tessThread(place, levels) == thread ? 0.0 : 1.0;
      wrong += glsl::tessThread(glsl::tessPlaceAt(glsl::tessBary(place, levels), levels), levels) == thread
                   ? 0.0
                   : 1.0;
    }
  return wrong;
}

/// The same from coordinates as a tessellator rounds them: Mesa 22.3's are off by 2.5e-4.
template <class Place>
double wrongRounded(const Place& placeAt) {
  double wrong = 0.0;
  for (const TessLevels& levels : patterns())
    for (glsl::uint thread = 0; thread < glsl::tessCount(levels); ++thread)
      for (const float error : {-2.5e-4f, 2.5e-4f}) {
        glm::vec3 at = glsl::tessBary(glsl::tessPlaceOf(thread, levels), levels);
        // Coordinates on an edge are exactly 0 in OpenGL, and those of corners 1.
        for (int i = 0; i < 3; ++i)
          if (at[i] > 1e-6f && at[i] < 1.0f) at[i] += i == 1 ? -error : error;
        wrong += glsl::tessThread(placeAt(at, levels), levels) == thread ? 0.0 : 1.0;
      }
  return wrong;
}

/// Rings and steps by truncation instead of to the nearest.
TessPlace placeByTruncation(const glm::vec3& at, const TessLevels& levels) {
  const glsl::uint inner = glsl::tessInner(levels);
  const float least = std::min({at[0], at[1], at[2]});
  const glm::vec3 shifted = at;
  TessPlace place = glsl::tessPlaceAt(shifted, levels);
  place.ring = std::min(static_cast<glsl::uint>(least * static_cast<float>(3 * inner) * 0.5f), inner / 2);
  return place;
}

double wrongCounts() {
  double wrong = 0.0;
  for (glsl::uint count = glsl::kTessFewestSamples; count <= glsl::kTessMostSamples; ++count)
    wrong += glsl::tessCount(glsl::tessLevelsFor(count)) == count ? 0.0 : 1.0;
  return wrong;
}

const std::vector<glm::vec3>& evenPoints() {
  static const std::vector<glm::vec3> points = [] {
    std::vector<glm::vec3> all;
    for (int i = 0; i <= 40; ++i)
      for (int j = 0; i + j <= 40; ++j) {
        const glm::vec3 p(static_cast<float>(i) / 40.0f, static_cast<float>(j) / 40.0f,
                          static_cast<float>(40 - i - j) / 40.0f);
        all.push_back(p);
      }
    return all;
  }();
  return points;
}

std::vector<glm::vec3> weightsOf(float ratio) {
  return {{1, 1, ratio},
          {1, ratio, ratio},
          {ratio, 1, 1},
          {1, std::sqrt(ratio), ratio},
          {ratio, 1 / ratio * ratio, 1}};
}

/// Even coordinates to the surface and back, against where they began; and the surface point against long
/// double.
double worstRoundTrip(float ratio) {
  double worst = 0.0;
  for (const glm::vec3& raw : weightsOf(ratio)) {
    const glm::vec3 weights = glsl::perspectiveWeights(raw);
    for (const glm::vec3& p : evenPoints()) {
      const glm::vec3 b = glsl::surfaceFromEven(p, weights);
      const glm::vec3 back = glsl::evenFromSurface(b, weights);
      std::array<Exact, 3> share{};
      for (int i = 0; i < 3; ++i) share[static_cast<std::size_t>(i)] = Exact{p[i]} / Exact{weights[i]};
      const Exact sum = share[0] + share[1] + share[2];
      for (int i = 0; i < 3; ++i) {
        if (!std::isfinite(b[i]) || !std::isfinite(back[i])) return std::numeric_limits<double>::infinity();
        worst = std::max(worst, static_cast<double>(std::abs(back[i] - p[i])));
        const Exact truth = share[static_cast<std::size_t>(i)] / sum;
        if (truth > 0) worst = std::max(worst, relativeError(b[i], truth));
      }
    }
  }
  return worst;
}

/// How far from even on screen samples are that are even on the surface: p as b, put on the screen.
double worstUncorrected(float ratio) {
  double worst = 0.0;
  for (const glm::vec3& raw : weightsOf(ratio)) {
    const glm::vec3 weights = glsl::perspectiveWeights(raw);
    for (const glm::vec3& p : evenPoints()) {
      const glm::vec3 screen = glsl::evenFromSurface(p, weights);
      for (int i = 0; i < 3; ++i) worst = std::max(worst, static_cast<double>(std::abs(screen[i] - p[i])));
    }
  }
  return worst;
}

double badWeights() {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  double bad = 0.0;
  for (const float x : {0.0f, -1.0f, nan, inf, 1e-42f, 1e-20f, 1.0f, 3e38f})
    for (const float y : {0.0f, nan, 1e-12f, 1.0f, inf, 1e13f})
      for (const glm::vec3& raw : {glm::vec3(x, y, 1.0f), glm::vec3(1.0f, x, y), glm::vec3(y, 1.0f, x)}) {
        const glm::vec3 weights = glsl::perspectiveWeights(raw);
        for (const glm::vec3& p : evenPoints()) {
          const glm::vec3 b = glsl::surfaceFromEvenOutside(p * 1.2f - 0.0667f, weights);
          const bool good = std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.z) &&
                            std::abs(b.x + b.y + b.z - 1.0f) < 1e-4f;
          bad += good ? 0.0 : 1.0;
        }
      }
  return bad;
}

/// What is linear over the triangle, stored in the L's texels and filtered bilinearly at decoded places.
template <class Decode>
double worstDecode(const Decode& decode, std::initializer_list<glsl::uint> levels) {
  double worst = 0.0;
  for (const glsl::uint level : levels) {
    std::vector<float> texels(std::size_t{level + 2} * (level + 2), std::numeric_limits<float>::quiet_NaN());
    const auto texel = [&](glsl::uint x, glsl::uint y) -> float& {
      return texels[std::size_t{y} * (level + 2) + x];
    };
    const glm::vec3 slope(1.0f, -2.0f, 3.0f);
    const TessLevels pattern = glsl::tessUniform(level);
    for (glsl::uint thread = 0; thread < glsl::tessCount(pattern); ++thread) {
      const TessPlace place = glsl::tessPlaceOf(thread, pattern);
      const glsl::LTexels at = glsl::lTexelsOf(place, level);
      const float value = glm::dot(slope, glsl::tessBary(place, pattern));
      texel(at.first.x, at.first.y) = value;
      texel(at.second.x, at.second.y) = value;
    }
    for (const glm::vec3& p : evenPoints()) {
      const glm::vec2 at = decode(p, level);
      const glm::vec2 low = glm::floor(at);
      const glm::vec2 f = at - low;
      double sum = 0.0;
      for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 2; ++x) {
          const double weight =
              static_cast<double>((x == 0 ? 1.0f - f.x : f.x) * (y == 0 ? 1.0f - f.y : f.y));
          if (weight > 1e-5)
            sum += weight *
                   static_cast<double>(texel(static_cast<glsl::uint>(low.x) + static_cast<glsl::uint>(x),
                                             static_cast<glsl::uint>(low.y) + static_cast<glsl::uint>(y)));
        }
      // In steps: neighbours along the steepest edge differ by 5 / level.
      const double error = std::abs(sum - static_cast<double>(glm::dot(slope, p))) * level / 5.0;
      worst = std::isfinite(error) ? std::max(worst, error) : std::numeric_limits<double>::infinity();
    }
  }
  return worst;
}

double invalidShapes() {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> hard = {0.0f,  1e-42f, 0.5f, 1.0f,  1.5f, 2.5f, 63.5f, 64.0f,
                                   64.5f, 65.0f,  1e6f, 3e38f, inf,  nan,  -1.0f};
  const glsl::TessLimits limits{};
  double invalid = 0.0;
  for (const float a : hard)
    for (const float b : hard)
      for (const float height : hard)
        for (const float bias : {0.0f, 16.0f, -16.0f, nan, inf}) {
          glsl::TessLimits within = limits;
          within.level = 64.0f;
          within.columns = 512.0f;
          within.slanted = 1.6f;
          const glsl::TessShape shape =
              glsl::selectShape({a, b, std::max(a, b), height}, bias, 0.0f, within, {}, 0.05f);
          const glsl::uint kind = glsl::kindOf(shape.kind);
          bool good = kind == glsl::kTessSingle || kind == glsl::kTessL || kind == glsl::kTessOver;
          if (kind == glsl::kTessL)
            good = glsl::levelOfKind(shape.kind) >= 1 && glsl::levelOfKind(shape.kind) <= 64;
          if (kind == glsl::kTessOver) {
            const glsl::OverShape over = glsl::overOfShape(shape);
            good =
                over.rows >= 1 && over.columns0 + over.columns1 >= 2 && over.columns0 + over.columns1 <= 4095;
          }
          invalid += good ? 0.0 : 1.0;
        }
  return invalid;
}

double wrongPieces() {
  double wrong = 0.0;
  for (glsl::uint n = 2; n <= glsl::kSplitMost; ++n)
    for (glsl::uint index = 0; index < n * n; ++index) {
      const glm::mat3 corners = glsl::pieceCorners({index, n});
      const glm::vec3 centre = (corners[0] + corners[1] + corners[2]) / 3.0f;
      wrong += glsl::pieceAt(centre, n).index == index ? 0.0 : 1.0;
    }
  for (const float hard :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30f})
    wrong += glsl::pieceAt({hard, hard, hard}, 16).index < 256 ? 0.0 : 1.0;
  return wrong;
}

/// Triangle ids up to the last that the id target can hold, through `keep` and back.
template <class Keep>
double lostIds(const Keep& keep) {
  double lost = 0.0;
  for (glsl::uint patch = 1; patch < (1U << 30U) - 2; patch = patch * 3 + 1)
    for (const glsl::uint beside : {0U, 1U, 2U}) {
      const glsl::uint id = glsl::idOfTriangle(patch + beside, 0, 0, 0);
      lost += (keep(id) >> 2U) - 1 == patch + beside ? 0.0 : 1.0;
    }
  return lost;
}

Scene deepTriangle(float nearest, float farthest) {
  Scene scene = build::emptyScene();
  Material white = build::unlit();
  white.doubleSided = true;
  const auto material = build::addMaterial(scene, white);
  const float wide = farthest * 0.8f;
  build::place(scene, build::addTriangles(scene,
                                          {{0, -0.3f * nearest, -nearest},
                                           {wide, -0.3f * nearest, -farthest},
                                           {-wide, -0.4f * nearest, -farthest},
                                           {-2 * wide, -wide, -1.1f * farthest},
                                           {2 * wide, -wide, -1.1f * farthest},
                                           {0, 2 * wide, -1.1f * farthest}},
                                          material));
  build::finish(scene);
  return scene;
}

Result<double> deep(Bench& bench, float ratio) {
  EngineOptions options;
  options.splitEdges = 0.0;
  return badPixels(bench, deepTriangle(0.02f, 0.02f * ratio), {},
                   std::vector<View>{look({0, 0, 0}, {0, -0.2, -1}, 70.0, 0.001)}, Pixels::White, options);
}

/// An equilateral triangle whose edges are `pixels` long.
Result<double> levelOf(Bench& bench, float pixels) {
  Scene scene = build::emptyScene();
  Material white = build::unlit();
  const auto material = build::addMaterial(scene, white);
  const float side = pixels * glm::radians(60.0f) / static_cast<float>(kHeight);
  const float height = side * 0.8660254f;
  build::place(
      scene, build::addTriangles(
                 scene, {{-side / 2, -height / 3, -1}, {side / 2, -height / 3, -1}, {0, height * 2 / 3, -1}},
                 material));
  build::finish(scene);
  EngineOptions options;
  options.splitEdges = 0.0;
  return badPixels(bench, std::move(scene), {},
                   std::vector<View>{look({0, 0, 0}, {0, 0, -1}), look({0, 0, 0}, {0.003, 0.002, -1})},
                   Pixels::White, options);
}

}  // namespace

void addTessellationCases(Cases& cases) {
  cases.push_back({"tessellation/threads",
                   "all levels 1 to 64, and edges of levels far apart: numbers and places of "
                   "samples are one-to-one, through float coordinates",
                   "wrong samples", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return wrongThreads(); }});
  cases.push_back({"tessellation/rounded-coordinates",
                   "the same from coordinates 2.5e-4 off, as Mesa's tessellator "
                   "makes them",
                   "wrong samples", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return wrongRounded(glsl::tessPlaceAt); }});
  cases.push_back({"tessellation/truncation-fails",
                   "rings by truncation, as printed, miss the rings of such coordinates", "wrong samples",
                   1000.0, Sense::AtLeast,
                   [](Bench&) -> Result<double> { return wrongRounded(placeByTruncation); }});
  cases.push_back({"tessellation/sample-counts",
                   "levels that spawn exactly n samples, for every n from 3 to 3169: a "
                   "rounded square root is off at whole roots",
                   "wrong counts", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return wrongCounts(); }});
  cases.push_back({"tessellation/w-ratio-1e4", "corners 1e4 times as far as others: to the surface and back",
                   "relative error", 2e-6, Sense::AtMost,
                   [](Bench&) -> Result<double> { return worstRoundTrip(1e4f); }});
  cases.push_back({"tessellation/w-ratio-1e6", "corners 1e6 times as far", "relative error", 2e-6,
                   Sense::AtMost, [](Bench&) -> Result<double> { return worstRoundTrip(1e6f); }});
  cases.push_back({"tessellation/uncorrected-fails",
                   "samples even on the surface: of such a triangle nearly all lie on "
                   "one corner of the screen",
                   "share of the edge", 0.5, Sense::AtLeast,
                   [](Bench&) -> Result<double> { return worstUncorrected(1e4f); }});
  cases.push_back({"tessellation/any-weights",
                   "depths that are zero, negative, NaN, infinite, denormal: finite "
                   "coordinates that sum to 1, outside of the triangle as well",
                   "bad points", 0.0, Sense::AtMost, [](Bench&) -> Result<double> { return badWeights(); }});
  cases.push_back({"tessellation/l-decode",
                   "colours linear over a triangle come out of its L as they were, at levels 1 "
                   "to 64 of both parities",
                   "of a step", 2e-4, Sense::AtMost, [](Bench&) -> Result<double> {
                     return worstDecode(glsl::lDecodeExact, {1, 2, 3, 4, 7, 8, 31, 32, 63, 64});
                   }});
  cases.push_back({"tessellation/plain-decode-fails",
                   "Hladky 2019, eq. 4, as printed, is off on the lines from the "
                   "corners to the centre",
                   "of a step", 0.05, Sense::AtLeast, [](Bench&) -> Result<double> {
                     return worstDecode(glsl::lDecodePlain, {1, 2, 3, 4, 7, 8, 31, 32, 63, 64});
                   }});
  cases.push_back({"tessellation/any-shape",
                   "edges and heights at exact halves, at 64 and 65, NaN, infinite, negative: "
                   "a shape within the limits",
                   "invalid shapes", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return invalidShapes(); }});
  cases.push_back({"tessellation/pieces",
                   "pieces of split triangles by their number and by a point in them, of points "
                   "that are not finite too",
                   "wrong pieces", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return wrongPieces(); }});
  cases.push_back({"tessellation/ids", "triangle ids to the last one that 32 bits hold", "lost ids", 0.0,
                   Sense::AtMost,
                   [](Bench&) -> Result<double> { return lostIds([](glsl::uint id) { return id; }); }});
  cases.push_back({"tessellation/float-ids-fail",
                   "the same ids as floats, as varyings and float targets hold them: from "
                   "2^24 on neighbours are one",
                   "lost ids", 1.0, Sense::AtLeast, [](Bench&) -> Result<double> {
                     return lostIds(
                         [](glsl::uint id) { return static_cast<glsl::uint>(static_cast<float>(id)); });
                   }});
  for (const float pixels : {1.0f, 1.5f, 2.5f, 63.5f, 64.0f, 65.0f})
    cases.push_back({fmt::format("tessellation/edge-{}-pixels", pixels),
                     "an equilateral triangle whose level is " +
                         std::string(pixels == 64.0f   ? "the largest of one pattern"
                                     : pixels == 65.0f ? "one past the largest: it is split"
                                     : pixels == 1.0f  ? "1"
                                                       : "an exact half"),
                     "bad pixels", 0.0, Sense::AtMost,
                     [pixels](Bench& bench) { return levelOf(bench, pixels); }});
  cases.push_back({"tessellation/depth-1e4", "a triangle from 2 cm to 200 m, not split: every pixel white",
                   "bad pixels", 0.0, Sense::AtMost, [](Bench& bench) { return deep(bench, 1e4f); }});
  cases.push_back({"tessellation/depth-1e6", "a triangle from 2 cm to 20 km, not split", "bad pixels", 0.0,
                   Sense::AtMost, [](Bench& bench) { return deep(bench, 1e6f); }});
}

}  // namespace tessera::stability
