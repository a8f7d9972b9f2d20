#include "engine/stream/feed.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>
#include <unordered_map>

#include <glm/gtc/quaternion.hpp>

#include "codec/wire/mask.hpp"

namespace tessera {

namespace {

struct Place {
  std::uint32_t object;
  std::array<std::uint32_t, 5> bits;  // of the position and the mask's coordinates
  bool operator==(const Place&) const = default;
};
struct PlaceHash {
  std::size_t operator()(const Place& p) const {
    std::uint64_t hash = p.object;
    for (const std::uint32_t bits : p.bits) hash = (hash ^ bits) * 0x9e3779b97f4a7c15ull;
    return static_cast<std::size_t>(hash ^ (hash >> 31));
  }
};

/// Numbers of masks, by material; kNone where there is none.
/// What masksOf() reads of a material: those that agree in it have one mask.
using MaskKey = std::tuple<bool, float, float, std::uint32_t, Wrap, Wrap>;

std::vector<std::uint32_t> maskNumbers(const Scene& scene) {
  std::vector<std::uint32_t> numbers(scene.materials.size(), wire::kNone);
  std::map<MaskKey, std::uint32_t> known;
  for (std::size_t i = 0; i < numbers.size() && known.size() <= 0xffff; ++i) {
    const Material& material = scene.materials[i];
    const TextureSlot& slot = material.baseColor;
    const bool cut = material.alphaMode == AlphaMode::Mask;
    if (!cut && !(material.alphaMode == AlphaMode::Blend && slot.used())) continue;
    const MaskKey key = {cut,
                         cut ? material.alphaCutoff : 0.0f,
                         material.baseColorFactor.a,
                         slot.image,
                         slot.sampler.wrapS,
                         slot.sampler.wrapT};
    numbers[i] = known.emplace(key, static_cast<std::uint32_t>(known.size())).first->second;
  }
  return numbers;
}

/// `alpha`: of a blended material beside its mask's.
std::uint32_t styleOf(const Material& material, std::uint32_t mask, float alpha) {
  const bool blend = material.alphaMode == AlphaMode::Blend;
  const auto share = static_cast<std::uint32_t>(std::lround(255.0f * std::clamp(alpha, 0.0f, 1.0f)));
  return (material.doubleSided ? glsl::kStyleDoubleSided : 0u) |
         (mask != wire::kNone ? glsl::kStyleMasked | (mask << 16u) : 0u) |
         (blend ? glsl::kStyleTransparent | (share << 8u) : 0u);
}

/// The factor, but where a mask holds it, and the mean of the corners'.
float alphaOf(const Scene& scene, const Primitive& primitive, std::span<const std::uint32_t> corners,
              bool masked) {
  float alpha = masked ? 1.0f : scene.materials[primitive.material].baseColorFactor.a;
  if (!primitive.hasColor || scene.vertices.color.empty()) return alpha;
  float sum = 0.0f;
  for (const std::uint32_t corner : corners) sum += scene.vertices.color[corner].a;
  return alpha * sum / static_cast<float>(corners.size());
}

/// Of a vertex of a masked material, on the grid that is sent: neighbours that only differ by less are one.
glm::vec2 maskCoordinate(const Scene& scene, const Material& material, std::uint32_t vertex) {
  const TextureSlot& slot = material.baseColor;
  if (!slot.used()) return glm::vec2(0.0f);
  const auto& uvs = slot.uvSet == 1 ? scene.vertices.uv1 : scene.vertices.uv0;
  if (vertex >= uvs.size()) return glm::vec2(0.0f);
  const glm::vec3 uv(uvs[vertex], 1.0f);
  const glm::vec2 at(glm::dot(slot.uvTransform[0], uv), glm::dot(slot.uvTransform[1], uv));
  const glm::vec2 most(wire::kMostMaskCoordinate);
  return glm::clamp(glm::round(at * wire::kMaskGrid) / wire::kMaskGrid, -most, most);
}

wire::Wrap wrapOf(Wrap wrap) {
  return wrap == Wrap::Clamp    ? wire::Wrap::Clamp
         : wrap == Wrap::Mirror ? wire::Wrap::Mirror
                                : wire::Wrap::Repeat;
}

}  // namespace

wire::Camera cameraOf(const View& view) {
  wire::Camera camera;
  camera.eye = view.eye;
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  const glm::dquat turn = glm::quat_cast(glm::dmat3(right, view.up, -view.forward));
  camera.orientation = {turn.x, turn.y, turn.z, turn.w};
  const double up = std::tan(view.fovY / 2.0);
  const double across = up * view.width / view.height;
  camera.slopes = {-across, across, -up, up};
  camera.zNear = view.zNear;
  camera.width = static_cast<std::uint32_t>(view.width);
  camera.height = static_cast<std::uint32_t>(view.height);
  return camera;
}

Result<View> viewOf(const wire::Camera& camera) {
  const double up = camera.slopes[3];
  const double across = camera.slopes[1];
  const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-6 * std::abs(a); };
  if (camera.width == 0 || camera.height == 0 || camera.width > wire::kMostViewSide ||
      camera.height > wire::kMostViewSide)
    return fail("a picture of {} x {}: sides are 1 to {}", camera.width, camera.height, wire::kMostViewSide);
  if (!(up > 0.0) || !near(up, -camera.slopes[2]) || !near(across, -camera.slopes[0]) ||
      !near(across * camera.height, up * camera.width))
    return fail("slopes {} {} {} {} are not those of square pixels around the axis", camera.slopes[0],
                camera.slopes[1], camera.slopes[2], camera.slopes[3]);
  if (camera.width * camera.height > wire::kMostViewPixels)
    return fail("a picture of {} x {}: more than {} pixels", camera.width, camera.height,
                wire::kMostViewPixels);
  for (const double slope : {up, across})
    if (!(slope >= wire::kLeastSlope && slope <= wire::kMostSlope))
      return fail("a slope of {} is outside [{}, {}]", slope, wire::kLeastSlope, wire::kMostSlope);
  if (!(camera.zNear >= kLeastNear && camera.zNear <= kMostNear))
    return fail("a near plane at {} is outside [{}, {}]", camera.zNear, kLeastNear, kMostNear);
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(camera.eye[axis]) <= kFarthestEye))
      return fail("an eye at {} on axis {}: farther out than {}", camera.eye[axis], axis, kFarthestEye);
  const glm::dvec4& q = camera.orientation;
  const glm::dquat turn = glm::normalize(glm::dquat(q.w, q.x, q.y, q.z));
  View view;
  view.eye = camera.eye;
  view.forward = turn * glm::dvec3(0.0, 0.0, -1.0);
  view.up = turn * glm::dvec3(0.0, 1.0, 0.0);
  view.fovY = 2.0 * std::atan(up);
  view.zNear = camera.zNear;
  view.width = static_cast<int>(camera.width);
  view.height = static_cast<int>(camera.height);
  return view;
}

std::vector<wire::MaskImage> masksOf(const Scene& scene) {
  std::vector<wire::MaskImage> masks;
  const std::vector<std::uint32_t> numbers = maskNumbers(scene);
  for (std::size_t m = 0; m < numbers.size(); ++m) {
    // The first of each; numbers rise by one.
    if (numbers[m] != masks.size()) continue;
    const Material& material = scene.materials[m];
    wire::MaskImage mask;
    mask.number = static_cast<std::uint16_t>(numbers[m]);
    mask.cutoff = material.alphaMode == AlphaMode::Mask ? material.alphaCutoff : 0.0f;
    mask.width = mask.height = 1;
    const auto scaled = [&](double alpha) {
      return static_cast<std::uint8_t>(
          std::lround(std::clamp(alpha * material.baseColorFactor.a, 0.0, 255.0)));
    };
    mask.alpha = {scaled(255.0)};
    const TextureSlot& slot = material.baseColor;
    if (slot.used() && !scene.images[slot.image].image.pixels.empty()) {
      const Image& image = scene.images[slot.image].image;
      mask.across = wrapOf(slot.sampler.wrapS);
      mask.up = wrapOf(slot.sampler.wrapT);
      wire::AlphaPlane plane{
          static_cast<std::uint32_t>(image.width), static_cast<std::uint32_t>(image.height), {}};
      for (std::size_t i = 3; i < image.pixels.size(); i += 4) plane.alpha.push_back(scaled(image.pixels[i]));
      if (std::adjacent_find(plane.alpha.begin(), plane.alpha.end(), std::not_equal_to<>()) ==
          plane.alpha.end())
        plane = {1, 1, {plane.alpha.front()}};
      while (std::max(plane.width, plane.height) > wire::kMostMaskSide)
        plane = wire::halved(plane.width, plane.height, plane.alpha);
      mask.width = plane.width;
      mask.height = plane.height;
      mask.alpha = std::move(plane.alpha);
    }
    masks.push_back(std::move(mask));
  }
  return masks;
}

std::vector<wire::SentLight> lightsOf(std::span<const LightSample> lights, const glm::dvec3& eye) {
  std::vector<wire::SentLight> sent;
  const auto finite = [](const auto& v) {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
  };
  for (const LightSample& light : lights) {
    wire::SentLight one;
    one.type = light.type == LightType::Directional ? wire::FrameLight::Directional
               : light.type == LightType::Spot      ? wire::FrameLight::Spot
                                                    : wire::FrameLight::Point;
    one.position = glm::vec3(light.position - eye);
    one.direction = glm::vec3(light.direction);
    one.radiance = light.radiance;
    one.range = light.range;
    one.innerCone = light.innerCone;
    one.outerCone = light.outerCone;
    if (!finite(one.position) || !finite(one.direction) || !finite(one.radiance)) continue;
    if (sent.size() < wire::kMostLights) sent.push_back(one);
  }
  return sent;
}

std::vector<wire::Path> pathsOf(const Stage& stage) {
  std::vector<wire::Path> paths;
  for (const CameraPath& path : stage.paths) {
    if (paths.size() == wire::kMostPaths) break;
    wire::Path& sent = paths.emplace_back();
    sent.name = path.name;
    for (const CameraKey& key : path.keys) sent.keys.push_back({key.time, key.eye, key.target, key.fovY});
  }
  return paths;
}

GeometryFeed::GeometryFeed(const Engine& engine) {
  const Scene& scene = engine.scene();
  const DrawScene& draw = engine.drawScene();
  const bool tess = engine.tess() != nullptr;
  source_.method = tess ? wire::Method::Tess : wire::Method::Rect;
  source_.elements.resize(std::size_t{draw.patchInstances} * (tess ? 4 : 1));
  const std::vector<bool> moving = movingNodes(scene);
  const std::vector<std::uint32_t> masks = maskNumbers(scene);
  std::map<std::uint32_t, std::uint32_t> objectOf;
  std::unordered_map<Place, std::uint32_t, PlaceHash> known;
  for (std::uint32_t patch = 0; patch < draw.patchInstances; ++patch) {
    const std::uint32_t index = draw.instanceOfPatch[patch];
    const Instance& instance = draw.instances[index];
    const glm::dmat4& world = engine.state().world[instance.node];
    std::uint32_t object = 0;
    if (moving[instance.node]) {
      const auto [entry, added] =
          objectOf.emplace(instance.node, static_cast<std::uint32_t>(nodes_.size()) + 1);
      if (added) nodes_.push_back(instance.node);
      object = entry->second;
    }
    const glsl::PatchGeometry& g =
        draw.patches[draw.patchOffset[instance.primitive] + patch - draw.patchBase[index]];
    const std::array<std::uint32_t, 5> corners = {g.v0, g.v1, g.v2, g.v3, g.v4};
    wire::SourceElement element;
    element.triangles = static_cast<std::uint8_t>(g.triangles);
    element.mirrored = mirrors(world);
    const Primitive& primitive = scene.primitives[instance.primitive];
    const std::uint32_t materialIndex = primitive.material;
    const Material& material = scene.materials[materialIndex];
    const std::uint32_t mask = masks[materialIndex];
    const bool masked = mask != wire::kNone;
    element.style =
        styleOf(material, mask, alphaOf(scene, primitive, std::span(corners).first(g.triangles + 2), masked));
    for (std::size_t i = 0; i < g.triangles + 2; ++i) {
      glm::vec3 at = scene.vertices.position[corners[i]];
      if (object == 0) at = glm::vec3(world * glm::dvec4(at, 1.0));
      glm::vec2 within(0.0f);
      if (masked) within = maskCoordinate(scene, material, corners[i]);
      Place place{object, {}};
      std::memcpy(place.bits.data(), &at, sizeof(at));
      std::memcpy(place.bits.data() + 3, &within, sizeof(within));
      const auto [entry, added] = known.emplace(place, static_cast<std::uint32_t>(source_.vertices.size()));
      if (added) source_.vertices.push_back({at, object, within});
      element.vertex[i] = entry->second;
    }
    if (!tess) {
      source_.elements[patch] = element;
      continue;
    }
    for (std::uint32_t part = 0; part < g.triangles; ++part) {
      wire::SourceElement triangle = element;
      triangle.triangles = 1;
      triangle.vertex = {element.vertex[0], element.vertex[part + 1], element.vertex[part + 2], 0, 0};
      const std::array<std::uint32_t, 3> own = {corners[0], corners[part + 1], corners[part + 2]};
      triangle.style = styleOf(material, mask, alphaOf(scene, primitive, own, masked));
      source_.elements[glsl::triangleNumber(patch, part)] = triangle;
    }
  }
}

std::vector<wire::VisibleElement> GeometryFeed::visible(const Engine& engine) const {
  std::vector<wire::VisibleElement> elements;
  if (const RectAtlas* atlas = engine.atlas(); atlas != nullptr) {
    const auto states =
        atlas->memory().patchStates().readAll<glsl::PatchState>(engine.drawScene().patchInstances);
    for (const std::uint32_t patch : engine.visibleSet()->read())
      elements.push_back({patch, {states[patch].origin, states[patch].level}, wire::kNone});
    return elements;
  }
  const TessMemory& memory = engine.tess()->memory();
  const auto states = memory.readStates();
  const auto numbers = memory.readVisible();
  const auto first = static_cast<std::uint32_t>(source_.elements.size());
  std::map<std::uint32_t, std::uint32_t> owner;  // of blocks of pieces
  for (const std::uint32_t number : numbers)
    if (number < first && states[number].split != 0) owner[glsl::splitBlock(states[number].split)] = number;
  for (const std::uint32_t number : numbers) {
    const glsl::TessState& s = states[number];
    wire::VisibleElement element{
        number,
        {s.shape.kind, s.shape.size, s.shape.form, s.place0, s.place1, glsl::splitCount(s.split)},
        wire::kNone};
    if (number >= first) {
      element.parent = owner.at((number - first) / glsl::kSplitBlock);
      element.words[5] = glsl::packPiece(glsl::splitCount(states[element.parent].split),
                                         (number - first) % glsl::kSplitBlock);
    }
    // What a shape does not have is left from an earlier one.
    const std::uint32_t kind = glsl::kindOf(s.shape.kind);
    if (kind != glsl::kTessOver) element.words[1] = element.words[2] = element.words[4] = 0;
    elements.push_back(element);
  }
  return elements;
}

std::vector<wire::ObjectTransform> GeometryFeed::objects(const Engine& engine) const {
  std::vector<wire::ObjectTransform> objects(1);
  for (const std::uint32_t node : nodes_) objects.push_back({glm::dmat4x3(engine.state().world[node])});
  return objects;
}

}  // namespace tessera
