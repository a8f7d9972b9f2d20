// Scales that mirror, flatten or stretch.
#include <cmath>
#include <random>

#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/exact.hpp"
#include "engine/frame/scene_buffers.hpp"
#include "engine/scene/build.hpp"
#include "glsl/shared/normal.h"

namespace tessera::stability {

namespace {

/// A bumpy, normal-mapped, textured sheet, its vertices and normals already taken through diag(scale)^-1,
/// under a node of that scale: the picture is the same for any scale, if normals and tangents are right.
Scene sheet(const glm::dvec3& scale) {
  Scene scene = build::emptyScene();
  scene.nodes.resize(2);
  scene.nodes[1].scale = scale;
  Material material;
  material.roughnessFactor = 0.4f;
  material.baseColor.image = build::addCheckers(scene, 64, 8);
  material.normal.image = material.baseColor.image;
  material.normalScale = 0.4f;
  const auto lit = build::addMaterial(scene, material);
  constexpr int kCells = 12;
  const auto grid = build::addGrid(scene, {-1.5f, -1, -3}, {3, 0, 0}, {0, 2, 0}, kCells, kCells, lit);
  build::place(scene, grid, 1);
  Primitive& primitive = scene.primitives[grid];
  const bool mirrored = scale.x * scale.y * scale.z < 0.0;
  primitive.bounds = {};
  for (std::size_t i = 0; i < scene.vertices.position.size(); ++i) {
    glm::vec3& p = scene.vertices.position[i];
    const double bump = 0.3 * std::sin(2.0 * p.x) * std::cos(3.0 * p.y);
    const glm::dvec3 at(p.x, p.y, static_cast<double>(p.z) + bump);
    const glm::dvec3 along(1.0, 0.0, 0.6 * std::cos(2.0 * p.x) * std::cos(3.0 * p.y));
    const glm::dvec3 up(0.0, 1.0, -0.9 * std::sin(2.0 * p.x) * std::sin(3.0 * p.y));
    const glm::dvec3 normal = glm::normalize(glm::cross(along, up));
    p = glm::vec3(at / scale);
    // Not made one long: between vertices the engine mixes normals of the mesh, and of unit ones the shorter
    // of two stretched normals would count for more.
    scene.vertices.normal[i] = glm::vec3(normal * scale);
    scene.vertices.tangent.emplace_back(glm::vec3(along / scale), mirrored ? -1.0f : 1.0f);
    primitive.bounds.add(glm::dvec3(p));
  }
  if (mirrored)
    for (std::size_t i = 0; i + 2 < scene.indices.size(); i += 3)
      std::swap(scene.indices[i + 1], scene.indices[i + 2]);
  build::finish(scene);
  return scene;
}

Stage lights() {
  Stage stage;
  StageLight sun;
  sun.light.type = LightType::Directional;
  sun.keys.push_back({0.0, {1, 2, 1}, {0, 0, -3}, glm::vec3(1.0f), 3.0f});
  stage.lights.push_back(sun);
  stage.ambient = Ambient{glm::vec3(0.2f), glm::vec3(0.05f)};
  return stage;
}

const std::vector<View>& views() {
  static const std::vector<View> all = {look({0, 0, 0}, {0, 0, -1}), look({0.9, 0.5, -1.5}, {0, 0, -3})};
  return all;
}

Case sheetCase(const char* name, const char* why, const glm::dvec3& scale,
               std::span<const Method> methods = kMethods, double bound = 50.0) {
  return {name, why, "dB", bound, Sense::AtLeast, [scale, methods](Bench& bench) {
            // Splitting makes normals one long again, of the mesh.
            EngineOptions options;
            options.splitEdges = 0.0;
            return leastPsnr(bench, {sheet({1, 1, 1}), lights(), views()}, {sheet(scale), lights(), views()},
                             options, methods);
          }};
}

/// Those whose texels hang on a triangle's shape in the mesh.
constexpr std::array<Method, 2> kByPatch = {Method::Rect, Method::Texel};
constexpr std::array<Method, 3> kByTriangle = {Method::Forward, Method::Tess, Method::Over};

/// A lit board under a node that flattens it, beside one that is as it should be.
Case flatCase(const char* name, const char* why, const glm::dvec3& scale) {
  return {name, why, "bad pixels", 0.0, Sense::AtMost, [scale](Bench& bench) {
            Scene scene = build::emptyScene();
            scene.nodes.resize(3);
            scene.nodes[1].scale = scale;
            scene.nodes[1].translation = {0.1, 0.2, -2.0};
            // A parent's scale and a child's turn: not a scale along any axis.
            scene.nodes[2].parent = 1;
            scene.nodes[2].rotation = glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3)));
            Material material;
            material.doubleSided = true;
            material.roughnessFactor = 0.0f;
            material.normal.image = build::addCheckers(scene, 16, 4);
            const auto lit = build::addMaterial(scene, material);
            const auto board =
                build::addGrid(scene, {-0.7f, -0.5f, 0}, {1.4f, 0.1f, 0.3f}, {0, 1, 0.2f}, 3, 3, lit);
            build::place(scene, board, 0);
            build::place(scene, board, 1);
            build::place(scene, board, 2);
            build::place(scene, build::addGrid(scene, {-3, -2, -5}, {6, 0, 0}, {0, 4, 0}, 3, 3, lit));
            scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(1, 0, 0, 1));
            build::finish(scene);
            return badPixels(bench, std::move(scene), lights(), views(), Pixels::Lit, {}, 0.3);
          }};
}

struct Turned {
  glsl::InstanceGpu instance;
  glm::vec3 normal;
  ExactVec truth;  // not normalized
};

/// Rotations after scales of up to 1e4, mirrored and singular ones among them, and unit normals.
const std::vector<Turned>& turnedNormals() {
  static const std::vector<Turned> all = [] {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Turned> made;
    for (int i = 0; i < 5000; ++i) {
      glm::dvec3 scale(std::pow(10.0, 4.0 * unit(random)), std::pow(10.0, 4.0 * unit(random)), 1.0);
      if (i % 3 == 0) scale.x = -scale.x;
      if (i % 5 == 0) scale.z = 0.0;
      const glm::dquat turn =
          glm::normalize(glm::dquat(unit(random), unit(random), unit(random), unit(random)));
      glm::dmat4 world = glm::mat4_cast(turn);
      for (int c = 0; c < 3; ++c) world[c] *= scale[c];
      Turned t{};
      for (int row = 0; row < 3; ++row)
        (row == 0   ? t.instance.row0
         : row == 1 ? t.instance.row1
                    : t.instance.row2) = glm::vec4(world[0][row], world[1][row], world[2][row], 0.0);
      if (mirrors(world)) t.instance.flags = glsl::kInstanceMirrored;
      t.normal = glm::normalize(glm::vec3(unit(random), unit(random), unit(random) + 1.5));
      // The cofactor matrix of a turn and a scale is the turn after the scale's cofactors.
      const glm::dvec3 cofactors(scale.y * scale.z, scale.z * scale.x, scale.x * scale.y);
      const glm::dvec3 truth =
          glm::mat3_cast(turn) * (cofactors * glm::dvec3(t.normal)) * (mirrors(world) ? -1.0 : 1.0);
      t.truth = {truth.x, truth.y, truth.z};
      made.push_back(t);
    }
    return made;
  }();
  return all;
}

/// The largest angle off the truth, in degrees; 180 where the normal is not finite.
template <class Transform>
double worstNormal(const Transform& transform) {
  double worst = 0.0;
  for (const Turned& t : turnedNormals()) {
    const glm::vec3 n = glsl::safeNormalize(transform(t.instance, t.normal), glm::vec3(0.0f));
    const Exact angle = angleOf(exact(n), t.truth);
    worst = std::max(
        worst, std::isfinite(angle) && glm::length(n) > 0.5f ? static_cast<double>(angle) * 57.29578 : 180.0);
  }
  return worst;
}

glm::vec3 byInverse(const glsl::InstanceGpu& m, const glm::vec3& n) {
  const glm::mat3 rows(glm::vec3(m.row0), glm::vec3(m.row1), glm::vec3(m.row2));
  return glm::inverse(rows) * n;
}

double worstUnit(bool safe) {
  double worst = 0.0;
  for (int e = -37; e <= 38; ++e)
    for (const glm::vec3 shape : {glm::vec3(1, 0, 0), glm::vec3(0.5f, -0.3f, 0.8f), glm::vec3(1, 1, 1)}) {
      const glm::vec3 v = shape * std::pow(10.0f, static_cast<float>(e));
      const glm::vec3 n = safe ? glsl::safeNormalize(v, glm::vec3(0.0f)) : v / std::sqrt(glm::dot(v, v));
      const Exact length = lengthOf(exact(n));
      worst = std::max(worst, std::isfinite(length) ? static_cast<double>(std::abs(length - 1)) : 1e9);
    }
  return worst;
}

}  // namespace

void addTransformCases(Cases& cases) {
  cases.push_back(
      sheetCase("transforms/mirrored", "a mirrored mesh under a mirroring node, normal-mapped", {-1, 1, 1}));
  cases.push_back(sheetCase("transforms/mirrored-thrice", "mirrored along all axes", {-1, -1, -1}));
  cases.push_back(
      sheetCase("transforms/turned-by-scale", "two negative scales: a turn, not a mirror", {-1, 1, -1}));
  cases.push_back(sheetCase("transforms/non-uniform-1e4",
                            "10,000-fold scale along x: normals go the other way than positions", {1e4, 1, 1},
                            kByTriangle));
  cases.push_back(sheetCase("transforms/non-uniform-both", "1e-2 along x, 100 along y, mirrored",
                            {1e-2, -1e2, 1}, kByTriangle));
  cases.push_back(sheetCase(
      "transforms/non-uniform-patches",
      "the same 10,000-fold scale by patches, which are paired by triangles' shapes in the mesh, once "
      "for all instances: other patches, so texels lie elsewhere and are filtered otherwise",
      {1e4, 1, 1}, kByPatch, 35.0));
  cases.push_back(flatCase("transforms/scale-zero-z",
                           "a board of no thickness, and turned under that scale: its normal "
                           "matrix has rank 1",
                           {1, 1, 0}));
  cases.push_back(flatCase("transforms/scale-zero-xy", "a board that has become a line", {0, 0, 1}));
  cases.push_back(flatCase("transforms/scale-zero",
                           "a board that has become a point: normals have no direction, the "
                           "one towards the eye is taken",
                           {0, 0, 0}));
  cases.push_back(
      flatCase("transforms/scale-1e-20", "a scale whose cofactors leave float32", {1e-20, 1e-20, 1e-20}));
  cases.push_back(
      {"transforms/cofactor-normals",
       "normals by cofactors under scales of 1e-4 to 1e4, mirrored and "
       "singular, against long double. A stretched normal is a difference of products: that costs the digits",
       "degrees", 0.1, Sense::AtMost,
       [](Bench&) -> Result<double> { return worstNormal(glsl::transformNormal); }});
  cases.push_back({"transforms/inverse-fails", "the same by the inverse transpose", "degrees", 90.0,
                   Sense::AtLeast, [](Bench&) -> Result<double> { return worstNormal(byInverse); }});
  cases.push_back({"transforms/unit-length", "vectors of length 1e-37 to 1e38 made one long", "error", 3e-7,
                   Sense::AtMost, [](Bench&) -> Result<double> { return worstUnit(true); }});
  cases.push_back({"transforms/plain-unit-fails", "the same by v / sqrt(v . v), whose square leaves float32",
                   "error", 0.5, Sense::AtLeast, [](Bench&) -> Result<double> { return worstUnit(false); }});
}

}  // namespace tessera::stability
