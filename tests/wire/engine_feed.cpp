#include "tests/wire/engine_feed.hpp"

#include <cstring>
#include <map>
#include <unordered_map>

#include <glm/gtc/quaternion.hpp>

namespace tessera::test {

namespace {

struct Place {
  std::uint32_t object;
  std::array<std::uint32_t, 3> bits;
  bool operator==(const Place&) const = default;
};
struct PlaceHash {
  std::size_t operator()(const Place& p) const {
    std::uint64_t hash = p.object;
    for (const std::uint32_t bits : p.bits) hash = (hash ^ bits) * 0x9e3779b97f4a7c15ull;
    return static_cast<std::size_t>(hash ^ (hash >> 31));
  }
};

std::uint32_t styleOf(const Material& material) {
  return (material.doubleSided ? glsl::kStyleDoubleSided : 0u) |
         (material.alphaMode == AlphaMode::Mask ? glsl::kStyleMasked : 0u);
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

EngineFeed::EngineFeed(const Engine& engine) {
  const Scene& scene = engine.scene();
  const DrawScene& draw = engine.drawScene();
  const bool tess = engine.tess() != nullptr;
  source_.method = tess ? wire::Method::Tess : wire::Method::Rect;
  source_.elements.resize(std::size_t{draw.patchInstances} * (tess ? 4 : 1));
  const std::vector<bool> moving = movingNodes(scene);
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
    element.style = styleOf(scene.materials[scene.primitives[instance.primitive].material]);
    for (std::size_t i = 0; i < g.triangles + 2; ++i) {
      glm::vec3 at = scene.vertices.position[corners[i]];
      if (object == 0) at = glm::vec3(world * glm::dvec4(at, 1.0));
      Place place{object, {}};
      std::memcpy(place.bits.data(), &at, sizeof(at));
      const auto [entry, added] = known.emplace(place, static_cast<std::uint32_t>(source_.vertices.size()));
      if (added) source_.vertices.push_back({at, object, {}});
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
      source_.elements[glsl::triangleNumber(patch, part)] = triangle;
    }
  }
}

std::vector<wire::VisibleElement> EngineFeed::visible(const Engine& engine) const {
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

std::vector<wire::ObjectTransform> EngineFeed::objects(const Engine& engine) const {
  std::vector<wire::ObjectTransform> objects(1);
  for (const std::uint32_t node : nodes_) objects.push_back({glm::dmat4x3(engine.state().world[node])});
  return objects;
}

}  // namespace tessera::test
