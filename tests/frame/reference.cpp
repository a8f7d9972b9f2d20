#include "tests/frame/reference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace tessera::test {

namespace {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;

constexpr double kPi = 3.14159265358979323846;

double decodeSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double encodeSrgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// Narkowicz 2015.
double film(double x) { return std::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0); }

struct Triangle {
  std::array<dvec3, 3> corner;
  std::array<dvec3, 3> normal;   // world, unit
  std::array<dvec4, 3> tangent;  // world; w = sign of the bitangent in the world
  std::array<std::uint32_t, 3> vertex;
  std::uint32_t material = 0;
  bool colored = false;
};

struct Hit {
  const Triangle* triangle = nullptr;
  dvec3 weights{0.0};
  double distance = std::numeric_limits<double>::infinity();
  bool front = true;
};

/// A surface as light meets it.
struct Surface {
  dvec3 point;
  dvec3 side;    // normal without bumps, towards the eye's side
  dvec3 normal;  // with bumps
  dvec3 base;
  dvec3 emissive;
  double metallic;
  double roughness;
  double occlusion;
};

/// GGX distribution and Smith shadowing of a surface, as functions of cosines.
struct Lobe {
  double alpha;
  [[nodiscard]] double distribution(double nh) const {
    const double d = nh * nh * (alpha * alpha - 1.0) + 1.0;
    return alpha * alpha / (kPi * d * d);
  }
  [[nodiscard]] double lambda(double cosine) const {
    const double tan2 = 1.0 / (cosine * cosine) - 1.0;
    return 0.5 * (std::sqrt(1.0 + alpha * alpha * tan2) - 1.0);
  }
  [[nodiscard]] double shadowing(double nv, double nl) const { return 1.0 / (1.0 + lambda(nv) + lambda(nl)); }
};

dvec3 schlick(const dvec3& f0, double vh) { return f0 + (1.0 - f0) * std::pow(1.0 - vh, 5.0); }

/// Scale and bias of f0 in the reflection of light that arrives evenly from everywhere, `nv` the cosine to
/// the eye (Karis 2014, mobile form). Metals of middling roughness come out up to a fifth darker than by
/// integrating the lobe.
dvec2 environmentShare(double roughness, double nv) {
  const double rx = 1.0 - roughness;
  const double ry = 0.0425 - 0.0275 * roughness;
  const double rz = 1.04 - 0.572 * roughness;
  const double rw = 0.022 * roughness - 0.04;
  const double a004 = std::min(rx * rx, std::exp2(-9.28 * nv)) * rx + ry;
  return {rz - 1.04 * a004, rw + 1.04 * a004};
}

class Tracer {
 public:
  Tracer(const Scene& scene, const Lighting& lighting) : scene_(scene), lighting_(lighting) {
    SceneState state;
    evaluate(scene, 0.0, state);
    for (const Instance& instance : scene.instances) add(instance, state.world[instance.node]);
  }

  /// 8-bit sRGB, or nothing where the ray meets no surface.
  [[nodiscard]] std::optional<dvec3> color(const dvec3& eye, const dvec3& direction) const {
    const Hit hit = nearest(eye, direction, true, std::numeric_limits<double>::infinity());
    if (hit.triangle == nullptr) return std::nullopt;
    const Material& material = scene_.materials[hit.triangle->material];
    const dvec4 base = baseOf(hit);
    dvec3 linear = glm::clamp(dvec3(base), 0.0, 1.0);
    if (!material.unlit) {
      const dvec3 radiance = shade(surfaceOf(hit, material, eye, direction), eye) * lighting_.exposure;
      linear = {film(radiance.x), film(radiance.y), film(radiance.z)};
    }
    return 255.0 * dvec3(encodeSrgb(linear.x), encodeSrgb(linear.y), encodeSrgb(linear.z));
  }

 private:
  void add(const Instance& instance, const glm::dmat4& world) {
    const Primitive& primitive = scene_.primitives[instance.primitive];
    const glm::dmat3 directions(world);
    const glm::dmat3 normals = glm::transpose(glm::inverse(directions));
    const double hand = glm::determinant(directions) < 0.0 ? -1.0 : 1.0;
    for (std::uint32_t i = 0; i < primitive.indexCount; i += 3) {
      Triangle t;
      t.material = primitive.material;
      t.colored = primitive.hasColor;
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t v = scene_.indices[primitive.firstIndex + i + c];
        t.vertex[c] = v;
        t.corner[c] = dvec3(world * dvec4(scene_.vertices.position[v], 1.0));
        t.normal[c] = glm::normalize(normals * dvec3(scene_.vertices.normal[v]));
        if (scene_.vertices.tangent.empty()) continue;
        const dvec4 tangent(scene_.vertices.tangent[v]);
        t.tangent[c] = dvec4(directions * dvec3(tangent), hand * tangent.w);
      }
      // glTF: a mirrored instance has its winding reversed.
      if (hand < 0.0) {
        std::swap(t.vertex[1], t.vertex[2]);
        std::swap(t.corner[1], t.corner[2]);
        std::swap(t.normal[1], t.normal[2]);
        std::swap(t.tangent[1], t.tangent[2]);
      }
      triangles_.push_back(t);
    }
  }

  template <typename T>
  static auto interpolate(const Hit& hit, const std::vector<T>& values) {
    using Wide = glm::vec<T::length(), double>;
    Wide sum(0.0);
    if (values.empty()) return sum;
    for (int c = 0; c < 3; ++c)
      sum += hit.weights[c] * Wide(values[hit.triangle->vertex[static_cast<std::size_t>(c)]]);
    return sum;
  }

  [[nodiscard]] dvec4 texel(const TextureSlot& slot, const Hit& hit, bool srgb) const {
    const dvec2 plain =
        slot.uvSet == 1 ? interpolate(hit, scene_.vertices.uv1) : interpolate(hit, scene_.vertices.uv0);
    const dvec3 h(plain, 1.0);
    const dvec2 uv(glm::dot(dvec3(slot.uvTransform[0]), h), glm::dot(dvec3(slot.uvTransform[1]), h));
    const Image& image = scene_.images[slot.image].image;
    const auto index = [](double t, int size, Wrap wrap) {
      if (wrap == Wrap::Repeat) t -= std::floor(t);
      return std::clamp(static_cast<int>(std::floor(t * size)), 0, size - 1);
    };
    const std::uint8_t* p =
        image.at(index(uv.x, image.width, slot.sampler.wrapS), index(uv.y, image.height, slot.sampler.wrapT));
    dvec4 value(p[0] / 255.0, p[1] / 255.0, p[2] / 255.0, p[3] / 255.0);
    if (srgb) value = dvec4(decodeSrgb(value.x), decodeSrgb(value.y), decodeSrgb(value.z), value.w);
    return value;
  }

  [[nodiscard]] dvec4 baseOf(const Hit& hit) const {
    const Material& material = scene_.materials[hit.triangle->material];
    dvec4 base(material.baseColorFactor);
    if (material.baseColor.used()) base *= texel(material.baseColor, hit, true);
    if (hit.triangle->colored) base *= interpolate(hit, scene_.vertices.color);
    return base;
  }

  /// The nearest surface along the ray, before `farthest`. With `cull`, single-sided backs are not there.
  [[nodiscard]] Hit nearest(const dvec3& from, const dvec3& direction, bool cull, double farthest) const {
    Hit best;
    best.distance = farthest;
    for (const Triangle& t : triangles_) {
      const dvec3 e1 = t.corner[1] - t.corner[0];
      const dvec3 e2 = t.corner[2] - t.corner[0];
      const dvec3 face = glm::cross(e1, e2);
      const double slope = glm::dot(face, direction);
      if (slope == 0.0) continue;
      const double distance = glm::dot(face, t.corner[0] - from) / slope;
      if (distance <= 1e-6 || distance >= best.distance) continue;
      const dvec3 p = from + distance * direction - t.corner[0];
      const double area = glm::dot(face, face);
      const double w1 = glm::dot(glm::cross(p, e2), face) / area;
      const double w2 = glm::dot(glm::cross(e1, p), face) / area;
      if (w1 < 0.0 || w2 < 0.0 || w1 + w2 > 1.0) continue;
      const Material& material = scene_.materials[t.material];
      const Hit hit{&t, {1.0 - w1 - w2, w1, w2}, distance, slope < 0.0};
      if (cull && !material.doubleSided && !hit.front) continue;
      if (material.alphaMode == AlphaMode::Mask && baseOf(hit).w < static_cast<double>(material.alphaCutoff))
        continue;
      best = hit;
    }
    return best;
  }

  [[nodiscard]] Surface surfaceOf(const Hit& hit, const Material& material, const dvec3& eye,
                                  const dvec3& direction) const {
    Surface s;
    s.point = eye + hit.distance * direction;
    dvec3 n(0.0);
    dvec4 tangent(0.0);
    for (int c = 0; c < 3; ++c) {
      n += hit.weights[c] * hit.triangle->normal[static_cast<std::size_t>(c)];
      tangent += hit.weights[c] * hit.triangle->tangent[static_cast<std::size_t>(c)];
    }
    n = glm::normalize(n);
    s.side = hit.front ? n : -n;
    if (material.normal.used()) {
      const dvec3 t = glm::normalize(dvec3(tangent) - n * glm::dot(n, dvec3(tangent)));
      const dvec3 b = glm::cross(n, t) * (tangent.w < 0.0 ? -1.0 : 1.0);
      const dvec3 bump = 2.0 * dvec3(texel(material.normal, hit, false)) - 1.0;
      const auto scale = static_cast<double>(material.normalScale);
      n = glm::normalize(t * bump.x * scale + b * bump.y * scale + n * bump.z);
    }
    s.normal = hit.front ? n : -n;
    s.base = dvec3(baseOf(hit));
    s.metallic = static_cast<double>(material.metallicFactor);
    s.roughness = static_cast<double>(material.roughnessFactor);
    if (material.metallicRoughness.used()) {
      const dvec4 value = texel(material.metallicRoughness, hit, false);
      s.roughness *= value.y;
      s.metallic *= value.z;
    }
    s.occlusion = 1.0;
    if (material.occlusion.used())
      s.occlusion +=
          static_cast<double>(material.occlusionStrength) * (texel(material.occlusion, hit, false).x - 1.0);
    s.emissive = dvec3(material.emissiveFactor);
    if (material.emissive.used()) s.emissive *= dvec3(texel(material.emissive, hit, true));
    return s;
  }

  /// The share of the light's radiance that arrives before the cosine, and the unit direction to the light.
  [[nodiscard]] double arriving(const LightSample& light, const dvec3& point, dvec3& l) const {
    double share = 1.0;
    double distance = 1e6;
    l = -light.direction;
    if (light.type != LightType::Directional) {
      const dvec3 d = light.position - point;
      distance = glm::length(d);
      l = d / distance;
      share = 1.0 / (distance * distance);
      if (light.range > 0.0f)
        share *= std::clamp(1.0 - std::pow(distance / static_cast<double>(light.range), 4.0), 0.0, 1.0);
    }
    if (light.type == LightType::Spot) {
      const double inner = std::cos(static_cast<double>(light.innerCone));
      const double outer = std::cos(static_cast<double>(light.outerCone));
      const double inside = (glm::dot(light.direction, -l) - outer) / (inner - outer);
      share *= std::pow(std::clamp(inside, 0.0, 1.0), 2.0);
    }
    if (share > 0.0 && light.castsShadow) {
      const Hit hit = nearest(point + 1e-4 * l, l, false, distance - 1e-3);
      if (hit.triangle != nullptr) share = 0.0;
    }
    return share;
  }

  [[nodiscard]] dvec3 shade(const Surface& s, const dvec3& eye) const {
    const dvec3 v = glm::normalize(eye - s.point);
    const double nv = std::max(glm::dot(s.normal, v), 1e-4);
    const Lobe lobe{s.roughness * s.roughness};
    const dvec3 diffuse = s.base * (1.0 - s.metallic);
    const dvec3 f0 = glm::mix(dvec3(0.04), s.base, s.metallic);
    dvec3 sum = s.emissive;
    for (const LightSample& light : lighting_.lights) {
      dvec3 l;
      const double share = arriving(light, s.point, l);
      // A bump may look at a light that its surface hides.
      if (light.castsShadow && glm::dot(s.side, l) <= 0.0) continue;
      const double nl = glm::dot(s.normal, l);
      if (nl <= 0.0 || share <= 0.0) continue;
      const dvec3 h = glm::normalize(v + l);
      const dvec3 fresnel = schlick(f0, glm::dot(v, h));
      const double glossy =
          lobe.distribution(glm::dot(s.normal, h)) * lobe.shadowing(nv, nl) / (4.0 * nv * nl);
      sum += ((1.0 - fresnel) * diffuse / kPi + fresnel * glossy) * dvec3(light.radiance) * (share * nl);
    }
    const dvec3 sky(lighting_.ambient.sky);
    const dvec3 ground(lighting_.ambient.ground);
    if (sky == dvec3(0.0) && ground == dvec3(0.0)) return sum;
    // Between sky and ground by height, for the diffuse part; the mirrored direction sees the boundary
    // blurred.
    const dvec3 around = glm::mix(ground, sky, 0.5 + 0.5 * s.normal.y);
    const dvec3 r = 2.0 * glm::dot(s.normal, v) * s.normal - v;
    const dvec3 mirrored = glm::mix(ground, sky, std::clamp(0.5 + 0.5 * r.y / (0.5 + s.roughness), 0.0, 1.0));
    const dvec2 share = environmentShare(s.roughness, nv);
    return sum + s.occlusion * (diffuse * around + (f0 * share.x + share.y) * mirrored);
  }

  const Scene& scene_;
  const Lighting& lighting_;
  std::vector<Triangle> triangles_;
};

}  // namespace

Stage stageOf(const Lighting& lighting) {
  Stage stage;
  stage.ambient = lighting.ambient;
  stage.exposure = static_cast<float>(lighting.exposure);
  for (const LightSample& sample : lighting.lights) {
    StageLight light;
    light.light.type = sample.type;
    light.light.range = sample.range;
    light.light.innerCone = sample.innerCone;
    light.light.outerCone = sample.outerCone;
    light.light.castsShadow = sample.castsShadow;
    light.keys.push_back({0.0, sample.position, sample.position + sample.direction, sample.radiance, 1.0f});
    stage.lights.push_back(light);
  }
  return stage;
}

Reference trace(const Scene& scene, const Lighting& lighting, const View& view) {
  const Tracer tracer(scene, lighting);
  const dvec3 right = glm::cross(view.forward, view.up);
  const double half = std::tan(0.5 * view.fovY);
  Reference reference{view.width, view.height, {}};
  for (int y = 0; y <= 2 * view.height; ++y)
    for (int x = 0; x <= 2 * view.width; ++x) {
      const double px = static_cast<double>(x - view.width) / view.height * half;
      const double py = static_cast<double>(view.height - y) / view.height * half;
      const auto color = tracer.color(view.eye, glm::normalize(view.forward + px * right + py * view.up));
      reference.points.push_back(color ? glm::vec4(glm::vec3(*color), 255.0f) : glm::vec4(0.0f));
    }
  return reference;
}

Comparison compare(const Image& image, const Reference& reference, int radius, double tolerance) {
  Comparison result;
  if (image.width != reference.width || image.height != reference.height) {
    result.outside = reference.points.size();
    result.first = fmt::format("picture of {} x {} against {} x {}", image.width, image.height,
                               reference.width, reference.height);
    return result;
  }
  int told = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      constexpr float kInfinity = std::numeric_limits<float>::infinity();
      glm::vec4 low(kInfinity);
      glm::vec4 high(-kInfinity);
      for (int j = std::max(2 * y + 1 - radius, 0); j <= std::min(2 * y + 1 + radius, 2 * image.height); ++j)
        for (int i = std::max(2 * x + 1 - radius, 0); i <= std::min(2 * x + 1 + radius, 2 * image.width);
             ++i) {
          glm::vec4 value = reference.point(i, j);
          low.a = std::min(low.a, value.a);
          high.a = std::max(high.a, value.a);
          if (value.a == 0.0f) continue;  // a miss says nothing of the colours of those that hit
          value.a = low.a;
          low = glm::min(low, value);
          value.a = high.a;
          high = glm::max(high, value);
        }
      const std::uint8_t* p = image.at(x, y);
      const bool covered = low.a > 0.0f;
      bool tight = covered;
      bool outside = static_cast<float>(p[3]) < low.a || static_cast<float>(p[3]) > high.a;
      for (int c = 0; p[3] > 0 && high.a > 0.0f && c < 3; ++c) {
        const double value = p[c];
        outside = outside || value < static_cast<double>(low[c]) - tolerance ||
                  value > static_cast<double>(high[c]) + tolerance;
        tight = tight && high[c] - low[c] <= 4.0f;
      }
      result.covered += covered ? 1 : 0;
      result.tight += tight ? 1 : 0;
      result.outside += outside ? 1 : 0;
      result.outsideWithin += outside && covered ? 1 : 0;
      if (outside && told++ < 4)
        result.first += fmt::format(
            "\n  ({}, {}): {} {} {} {}, allowed {:.1f}-{:.1f} {:.1f}-{:.1f} {:.1f}-{:.1f} {}-{}", x, y, p[0],
            p[1], p[2], p[3], low.r, high.r, low.g, high.g, low.b, high.b, low.a, high.a);
    }
  return result;
}

}  // namespace tessera::test
