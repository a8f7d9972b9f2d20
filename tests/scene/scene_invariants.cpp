#include "scene_invariants.hpp"

#include <cmath>

#include <fmt/format.h>

namespace tessera::test {
namespace {

template <class V>
bool finite(const V& v) {
  for (int c = 0; c < v.length(); ++c)
    if (!std::isfinite(v[c])) return false;
  return true;
}

bool unit(const glm::vec3& v) { return std::abs(glm::length(v) - 1.0f) < 1e-4f; }

template <class V>
bool allFinite(const std::vector<V>& values) {
  for (const V& v : values)
    if (!finite(v)) return false;
  return true;
}

std::string brokenVertices(const Vertices& v) {
  const std::size_t count = v.position.size();
  const auto fits = [&](std::size_t size) { return size == 0 || size == count; };
  if (v.normal.size() != count) return "as many normals as positions";
  if (!fits(v.tangent.size()) || !fits(v.uv0.size()) || !fits(v.uv1.size()) || !fits(v.color.size()))
    return "optional attributes are absent or complete";
  if (!allFinite(v.position) || !allFinite(v.uv0) || !allFinite(v.uv1) || !allFinite(v.color))
    return "attributes are finite";
  for (const glm::vec3& n : v.normal)
    if (!unit(n)) return "normals are unit";
  for (const glm::vec4& t : v.tangent)
    if (!unit(glm::vec3(t)) || std::abs(t.w) != 1.0f) return "tangents are unit, w is a sign";
  return {};
}

std::string brokenPrimitives(const Scene& scene) {
  std::size_t nextIndex = 0;
  std::size_t nextVertex = 0;
  for (std::size_t i = 0; i < scene.primitives.size(); ++i) {
    const Primitive& p = scene.primitives[i];
    if (p.firstIndex != nextIndex || p.firstVertex != nextVertex)
      return fmt::format("primitive {} follows", i);
    if (p.indexCount == 0 || p.indexCount % 3 != 0) return fmt::format("primitive {} has whole triangles", i);
    if (p.material >= scene.materials.size()) return fmt::format("primitive {} has a material", i);
    nextIndex += p.indexCount;
    nextVertex += p.vertexCount;
    if (nextIndex > scene.indices.size() || nextVertex > scene.vertices.position.size())
      return fmt::format("primitive {} is within the arrays", i);
    for (std::size_t k = p.firstIndex; k < nextIndex; k += 3) {
      const std::uint32_t* t = &scene.indices[k];
      for (int c = 0; c < 3; ++c)
        if (t[c] < p.firstVertex || t[c] >= nextVertex)
          return fmt::format("primitive {} has its own vertices", i);
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
        return fmt::format("primitive {} repeats no index", i);
    }
  }
  if (nextIndex != scene.indices.size() || nextVertex != scene.vertices.position.size())
    return "nothing is left over";
  for (const Mesh& mesh : scene.meshes)
    if (std::size_t{mesh.firstPrimitive} + mesh.primitiveCount > scene.primitives.size())
      return "meshes have primitives";
  return {};
}

std::string brokenMaterials(const Scene& scene, bool pixels) {
  if (scene.materials.empty()) return "there is a material";
  for (const Material& m : scene.materials) {
    for (const TextureSlot* slot :
         {&m.baseColor, &m.metallicRoughness, &m.normal, &m.occlusion, &m.emissive}) {
      if (slot->used() && slot->image >= scene.images.size()) return "slots have images";
      if (slot->uvSet > 1) return "UV sets are 0 or 1";
    }
    if (!finite(m.baseColorFactor) || !finite(m.emissiveFactor)) return "factors are finite";
  }
  for (const SceneImage& image : scene.images) {
    if (image.name.empty()) return "images have names";
    if (pixels && (image.image.width < 1 ||
                   image.image.pixels.size() != static_cast<std::size_t>(image.image.width) *
                                                    static_cast<std::size_t>(image.image.height) * 4))
      return "images have pixels";
  }
  return {};
}

std::string brokenNodes(const Scene& scene) {
  std::size_t instances = 0;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (node.parent != kNone && node.parent >= i) return "parents come first";
    if (node.mesh != kNone && node.mesh >= scene.meshes.size()) return "nodes have their mesh";
    if (node.light != kNone && node.light >= scene.lights.size()) return "nodes have their light";
    if (node.camera != kNone && node.camera >= scene.cameras.size()) return "nodes have their camera";
    if (node.mesh != kNone) instances += scene.meshes[node.mesh].primitiveCount;
  }
  if (instances != scene.instances.size()) return "each primitive of each node is an instance";
  for (const Instance& instance : scene.instances)
    if (instance.node >= scene.nodes.size() || instance.primitive >= scene.primitives.size())
      return "instances have node and primitive";
  for (const Light& light : scene.lights)
    if (light.type == LightType::Spot && !(light.innerCone < light.outerCone)) return "cones are ordered";
  return {};
}

std::string brokenAnimations(const Scene& scene) {
  for (const Animation& animation : scene.animations) {
    for (const AnimationChannel& channel : animation.channels) {
      if (channel.node >= scene.nodes.size() || scene.nodes[channel.node].hasMatrix)
        return "channels have a free node";
      if (channel.times.empty()) return "channels have keys";
      const std::size_t perKey = channel.interpolation == Interpolation::Cubic ? 3 : 1;
      if (channel.values.size() != channel.times.size() * perKey) return "channels have a value a key";
      if (!allFinite(channel.values)) return "values are finite";
      for (std::size_t k = 1; k < channel.times.size(); ++k)
        if (!(channel.times[k] > channel.times[k - 1])) return "times increase";
      if (double{channel.times.back()} > animation.duration) return "keys end within the duration";
    }
  }
  return {};
}

}  // namespace

std::string brokenInvariant(const Scene& scene, bool pixels) {
  for (const std::string& broken :
       {brokenVertices(scene.vertices), brokenPrimitives(scene), brokenMaterials(scene, pixels),
        brokenNodes(scene), brokenAnimations(scene)})
    if (!broken.empty()) return broken;
  if (scene.triangleCount() == 0) return "there are triangles";
  if (scene.bounds.empty() || !std::isfinite(scene.bounds.diagonal())) return "bounds are finite";
  for (const std::string& warning : scene.warnings)
    if (warning.empty() || warning.find('\n') != std::string::npos) return "warnings are one line";
  return {};
}

}  // namespace tessera::test
