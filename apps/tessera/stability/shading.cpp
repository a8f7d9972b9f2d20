// Materials, normals and lights at and past their limits.
#include <cmath>
#include <limits>

#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/exact.hpp"
#include "engine/scene/build.hpp"
#include "glsl/shared/tone.h"

namespace tessera::stability {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kDenormal = 1e-42f;

using Change = std::function<void(Scene&, Stage&)>;

/// A floor, a wall and a slanted board, textured and normal-mapped, each with a material of its own (1 to 3),
/// lit by a sun and a lamp, over a dim ambient that reaches everything.
std::pair<Scene, Stage> room() {
  Scene scene = build::emptyScene();
  Material material;
  material.baseColor.image = build::addCheckers(scene, 32, 4);
  material.normal.image = material.baseColor.image;
  material.metallicRoughness.image = build::addCheckers(scene, 16, 2);
  material.doubleSided = true;
  std::array<std::uint32_t, 3> m{};
  for (std::uint32_t& index : m) index = build::addMaterial(scene, material);
  build::place(scene, build::addGrid(scene, {-2, -1, 0}, {4, 0, 0}, {0, 0, -4}, 4, 4, m[0], true));
  build::place(scene, build::addGrid(scene, {-2, -1, -4}, {4, 0, 0}, {0, 3, 0}, 4, 3, m[1], true));
  build::place(
      scene, build::addGrid(scene, {-0.7f, -0.6f, -2}, {1.5f, 0.3f, 0}, {0, 0.8f, -0.6f}, 2, 2, m[2], true));
  scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(1, 0, 0, 1));
  build::finish(scene);
  Stage stage;
  StageLight sun;
  sun.light.type = LightType::Directional;
  sun.light.castsShadow = true;
  sun.keys.push_back({0.0, {1, 5, 2}, {0.2, 0, -2}, glm::vec3(1.0f), 2.0f});
  StageLight lamp;
  lamp.keys.push_back({0.0, {0.4, 0.3, -1.5}, {0, 0, 0}, glm::vec3(1.0f), 4.0f});
  stage.lights = {sun, lamp};
  stage.ambient = Ambient{glm::vec3(0.2f), glm::vec3(0.1f)};
  return {std::move(scene), std::move(stage)};
}

const std::vector<View>& views() {
  static const std::vector<View> all = {look({0.3, 0.5, 1.5}, {0, -0.2, -3}),
                                        look({0, -0.999, 0.5}, {0, -0.8, -4})};
  return all;
}

Case roomCase(const char* name, const char* why, const Change& change, Pixels pixels = Pixels::Lit) {
  return {name, why, "bad pixels", 0.0, Sense::AtMost, [change, pixels](Bench& bench) {
            auto [scene, stage] = room();
            change(scene, stage);
            return badPixels(bench, std::move(scene), std::move(stage), views(), pixels, {}, 0.15);
          }};
}

void eachMaterial(Scene& scene, const std::function<void(Material&)>& change) {
  for (std::size_t i = 1; i < scene.materials.size(); ++i) change(scene.materials[i]);
}

/// The three materials get one value each.
template <class Field, class Value>
void spread(Scene& scene, Field Material::*field, const std::array<Value, 3>& values) {
  for (std::size_t i = 0; i < 3; ++i) scene.materials[i + 1].*field = values[i];
}

/// Where the peak of a lobe is: 1 - (n . h)^2 for h at `angle` from n, in float, against the truth.
template <class Square>
double worstPeak(const Square& square) {
  double worst = 0.0;
  for (float angle = 1e-5f; angle < 1.0f; angle *= 1.3f) {
    const glm::vec3 n = glm::normalize(glm::vec3(0.3f, 0.9f, 0.2f));
    const glm::vec3 side = glm::normalize(glm::cross(n, glm::vec3(0.1f, 0.2f, 1.0f)));
    const glm::vec3 h = glm::normalize(n + side * std::tan(angle));
    const Exact sine = std::sin(angleOf(exact(n), exact(h)));
    worst = std::max(worst, relativeError(square(n, h), sine * sine));
  }
  return worst;
}

double badTones() {
  double bad = 0.0;
  float previous = -1.0f;
  for (const float x : {0.0f, kDenormal, 1e-6f, 0.1f, 1.0f, 100.0f, 65504.0f, 1e10f, 3e38f, kInfinity}) {
    const float y = glsl::toneCurve(x);
    bad += y >= 0.0f && y <= 1.0f && y >= previous ? 0.0 : 1.0;
    previous = y;
  }
  return bad + (glsl::toneCurve(-1.0f) == 0.0f ? 0.0 : 1.0) +
         (glsl::toneCurve(-kInfinity) == 0.0f ? 0.0 : 1.0);
}

}  // namespace

void addShadingCases(Cases& cases) {
  cases.push_back(
      roomCase("shading/roughness-0", "a mirror's lobe is a point: GGX divides by zero",
               [](Scene& s, Stage&) { eachMaterial(s, [](Material& m) { m.roughnessFactor = 0.0f; }); }));
  cases.push_back(roomCase("shading/roughness-1", "the widest lobe, metal and not", [](Scene& s, Stage&) {
    spread<float, float>(s, &Material::roughnessFactor, {1.0f, 1.0f, 0.999999f});
    spread<float, float>(s, &Material::metallicFactor, {0.0f, 1.0f, 0.5f});
  }));
  cases.push_back(roomCase("shading/facing-away",
                           "normals that point away from the eye and at right angles to it, as "
                           "interpolated ones do",
                           [](Scene& s, Stage&) {
                             for (std::size_t i = 0; i < s.vertices.normal.size(); ++i)
                               s.vertices.normal[i] = i % 3 == 0   ? -s.vertices.normal[i]
                                                      : i % 3 == 1 ? glm::vec3(1, 0, 0)
                                                                   : s.vertices.normal[i];
                           }));
  cases.push_back(
      roomCase("shading/light-behind", "lights that shine from behind every surface", [](Scene&, Stage& t) {
        t.lights[0].keys[0].position = {0, -5, -9};
        t.lights[0].keys[0].target = {0, 0, 0};
        t.lights[1].keys[0].position = {0, -1.5, -4.5};
      }));
  cases.push_back(roomCase("shading/light-on-surface",
                           "a lamp on a vertex, and one in the floor: the distance is 0",
                           [](Scene&, Stage& t) {
                             t.lights[1].keys[0].position = {-1, -1, -1};
                             StageLight other = t.lights[1];
                             other.light.type = LightType::Spot;
                             other.light.castsShadow = true;
                             other.keys[0].position = {0.3, -1, -2.2};
                             other.keys[0].target = other.keys[0].position;
                             t.lights.push_back(other);
                           }));
  cases.push_back(
      roomCase("shading/zero-normals", "normals of no length: the direction to the eye is taken",
               [](Scene& s, Stage&) { s.vertices.normal.assign(s.vertices.normal.size(), glm::vec3(0)); }));
  cases.push_back(roomCase("shading/tiny-normals", "normals of 1e-30 and 1e30, whose squares leave float32",
                           [](Scene& s, Stage&) {
                             for (std::size_t i = 0; i < s.vertices.normal.size(); ++i)
                               s.vertices.normal[i] *= i < 20 ? 1e-30f : 1e30f;
                           }));
  cases.push_back(
      roomCase("shading/zero-tangents", "tangents of no length, and along the normal", [](Scene& s, Stage&) {
        for (std::size_t i = 0; i < s.vertices.tangent.size(); ++i)
          s.vertices.tangent[i] = i % 2 == 0 ? glm::vec4(0.0f) : glm::vec4(s.vertices.normal[i], 1.0f);
      }));
  cases.push_back(roomCase("shading/degenerate-uvs",
                           "all of a mesh at one texture coordinate, and coordinates of 1e30",
                           [](Scene& s, Stage&) {
                             for (std::size_t i = 0; i < s.vertices.uv0.size(); ++i)
                               s.vertices.uv0[i] = i < 20 ? glm::vec2(0.1f) : s.vertices.uv0[i] * 1e30f;
                           }));
  cases.push_back(
      roomCase("shading/hdr", "emission, lights and colours to 65504 and past it", [](Scene& s, Stage& t) {
        spread<glm::vec3, glm::vec3>(s, &Material::emissiveFactor,
                                     {glm::vec3(65504.0f), glm::vec3(3e38f), glm::vec3(1e30f)});
        for (glm::vec4& color : s.vertices.color) color *= 1e20f;
        t.lights[0].keys[0].intensity = 65504.0f;
        t.lights[1].keys[0].intensity = 3e38f;
        t.ambient->sky = glm::vec3(65504.0f);
      }));
  cases.push_back(roomCase(
      "shading/denormal", "factors, colours, normals and lights that are denormal",
      [](Scene& s, Stage& t) {
        eachMaterial(s, [](Material& m) {
          m.baseColorFactor = glm::vec4(kDenormal);
          m.emissiveFactor = glm::vec3(kDenormal);
          m.roughnessFactor = kDenormal;
          m.metallicFactor = kDenormal;
          m.normalScale = kDenormal;
        });
        for (glm::vec3& n : s.vertices.normal) n *= kDenormal;
        for (glm::vec2& uv : s.vertices.uv0) uv *= kDenormal;
        t.lights[0].keys[0].intensity = kDenormal;
      },
      Pixels::Lit));
  cases.push_back(roomCase(
      "shading/infinite-factors",
      "factors that are infinite or not a number, as a host may set "
      "them: those of a material that has none are taken",
      [](Scene& s, Stage&) {
        spread<float, float>(s, &Material::roughnessFactor, {kNan, kInfinity, -kInfinity});
        spread<float, float>(s, &Material::metallicFactor, {kInfinity, kNan, -kInfinity});
        spread<float, float>(s, &Material::normalScale, {kNan, kInfinity, -kInfinity});
        spread<float, float>(s, &Material::occlusionStrength, {kNan, kInfinity, -kInfinity});
        spread<glm::vec4, glm::vec4>(s, &Material::baseColorFactor,
                                     {glm::vec4(kNan), glm::vec4(kInfinity), glm::vec4(kNan, 1, 1, 1)});
        spread<glm::vec3, glm::vec3>(s, &Material::emissiveFactor,
                                     {glm::vec3(kNan), glm::vec3(kInfinity), glm::vec3(-kInfinity)});
      }));
  cases.push_back(
      roomCase("shading/infinite-unlit", "the same of a material without light", [](Scene& s, Stage&) {
        eachMaterial(s, [](Material& m) { m.unlit = true; });
        spread<glm::vec4, glm::vec4>(s, &Material::baseColorFactor,
                                     {glm::vec4(kNan), glm::vec4(kInfinity), glm::vec4(kNan, 1, 1, 1)});
      }));
  cases.push_back(roomCase("shading/infinite-attributes",
                           "normals, tangents, texture coordinates and colours that are "
                           "infinite or not a number",
                           [](Scene& s, Stage&) {
                             for (std::size_t i = 0; i < s.vertices.position.size(); i += 3) {
                               const float bad = i % 2 == 0 ? kNan : kInfinity;
                               s.vertices.normal[i] = glm::vec3(bad, 0, 1);
                               s.vertices.tangent[i] = glm::vec4(bad);
                               s.vertices.uv0[i] = glm::vec2(0.3f, bad);
                               s.vertices.color[i] = glm::vec4(bad);
                             }
                           }));
  cases.push_back(roomCase("shading/infinite-positions",
                           "corners that are infinite or not a number: their triangles are "
                           "left out",
                           [](Scene& s, Stage&) {
                             s.vertices.position[3] = glm::vec3(kNan, 0, 0);
                             s.vertices.position[30] = glm::vec3(0, kInfinity, 0);
                             build::finish(s);
                           }));
  cases.push_back(
      roomCase("shading/infinite-lights",
               "lights whose intensity, place and direction are infinite or not a "
               "number",
               [](Scene&, Stage& t) {
                 t.lights[0].keys[0].intensity = kInfinity;
                 t.lights[1].keys[0].intensity = kNan;
                 StageLight other = t.lights[1];
                 other.keys[0] = {0.0, glm::dvec3(std::nan("")), {0, 0, 0}, glm::vec3(1.0f), 1.0f};
                 t.lights.push_back(other);
                 other.light.type = LightType::Directional;
                 other.keys[0] = {0.0, {1, 1, 1}, {1, 1, 1}, glm::vec3(1.0f), 1.0f};
                 t.lights.push_back(other);
               }));
  cases.push_back(roomCase("shading/infinite-nodes",
                           "a node whose place is infinite: what it carries is left out",
                           [](Scene& s, Stage&) {
                             s.nodes.resize(3);
                             s.nodes[1].translation = {std::numeric_limits<double>::infinity(), 0, 0};
                             s.nodes[2].scale = glm::dvec3(1e300);
                             build::place(s, 2, 1);
                             build::place(s, 2, 2);
                             build::finish(s);
                           }));
  cases.push_back({"shading/tone", "the tone curve from 0 to infinity: within 0 to 1, and never falling",
                   "bad values", 0.0, Sense::AtMost, [](Bench&) -> Result<double> { return badTones(); }});
  cases.push_back({"shading/narrow-peak", "1 - (n . h)^2 by the cross product, at the peak of a narrow lobe",
                   "relative error", 0.05, Sense::AtMost, [](Bench&) -> Result<double> {
                     return worstPeak([](const glm::vec3& n, const glm::vec3& h) {
                       const glm::vec3 x = glm::cross(n, h);
                       return glm::dot(x, x);
                     });
                   }});
  cases.push_back({"shading/printed-peak-fails", "the same as printed", "relative error", 1.0, Sense::AtLeast,
                   [](Bench&) -> Result<double> {
                     return worstPeak([](const glm::vec3& n, const glm::vec3& h) {
                       const float nh = glm::dot(n, h);
                       return 1.0f - nh * nh;
                     });
                   }});
}

}  // namespace tessera::stability
