// The node graph, and what hangs on it: instances, cameras, lights.
#include <algorithm>
#include <cmath>

#include "engine/scene/gltf_build.hpp"

namespace tessera {
namespace {

constexpr double kMaxFovY = 3.12413936106985;  // 179 degrees
constexpr std::size_t kMaxInstances = std::size_t{1} << 24;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// The parent of each node, -1 for roots. Errors: a node with two parents, or in a cycle.
Result<std::vector<int>> parentsOf(const GltfInput& input) {
  const auto& nodes = input.model.nodes;
  std::vector<int> parents(nodes.size(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const int child : nodes[i].children) {
      if (parents[at(child)] >= 0)
        return fail("{}: node {}: is a child of node {} and again of node {}", input.file, child,
                    parents[at(child)], i);
      parents[at(child)] = static_cast<int>(i);
    }
  }
  // With one parent at most, what no root reaches hangs on a cycle.
  std::vector<int> reached;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (parents[i] < 0) reached.push_back(static_cast<int>(i));
  std::vector<bool> seen(nodes.size(), false);
  for (std::size_t k = 0; k < reached.size(); ++k) {
    const std::size_t node = at(reached[k]);
    seen[node] = true;
    reached.insert(reached.end(), nodes[node].children.begin(), nodes[node].children.end());
  }
  if (const auto lost = std::ranges::find(seen, false); lost != seen.end()) {
    auto node = static_cast<int>(lost - seen.begin());
    for (std::size_t i = 0; i < nodes.size(); ++i) node = parents[at(node)];
    return fail("{}: node {}: is its own ancestor", input.file, node);
  }
  return parents;
}

/// The roots to draw. Errors: a scene that lists a node twice, or one that has a parent.
Result<std::vector<int>> rootsOf(const GltfInput& input, const std::vector<int>& parents) {
  const tinygltf::Model& model = input.model;
  std::vector<int> roots;
  if (model.scenes.empty()) {
    for (std::size_t i = 0; i < parents.size(); ++i)
      if (parents[i] < 0) roots.push_back(static_cast<int>(i));
    return roots;
  }
  std::vector<std::size_t> listedIn(parents.size(), model.scenes.size());
  for (std::size_t s = 0; s < model.scenes.size(); ++s) {
    for (const int node : model.scenes[s].nodes) {
      if (parents[at(node)] >= 0)
        return fail("{}: scene {}: node {} is not a root, its parent is node {}", input.file, s, node,
                    parents[at(node)]);
      if (listedIn[at(node)] == s) return fail("{}: scene {}: node {} is listed twice", input.file, s, node);
      listedIn[at(node)] = s;
    }
  }
  return model.scenes[at(std::max(model.defaultScene, 0))].nodes;
}

Result<void> readTransform(const GltfInput& input, int index, Node& out) {
  const tinygltf::Node& in = input.model.nodes[at(index)];
  const std::string element = fmt::format("node {}", index);
  if (!in.matrix.empty()) {
    const nlohmann::json& json = input.document.json["nodes"][at(index)];
    if (json.contains("translation") || json.contains("rotation") || json.contains("scale"))
      input.warnings.add("node has a matrix and translation, rotation or scale: the matrix is used", element);
    out.hasMatrix = true;
    for (std::size_t i = 0; i < 16; ++i)
      out.matrix[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = in.matrix[i];
    for (int column = 0; column < 4; ++column)
      if (const double value = out.matrix[column][3]; std::abs(value - (column == 3 ? 1.0 : 0.0)) > 1e-6)
        return fail("{}: {}: matrix has {} in column {} of the last row", input.file, element, value, column);
    return {};
  }
  if (!in.translation.empty()) out.translation = {in.translation[0], in.translation[1], in.translation[2]};
  if (!in.scale.empty()) out.scale = {in.scale[0], in.scale[1], in.scale[2]};
  if (!in.rotation.empty()) {
    const glm::dquat q(in.rotation[3], in.rotation[0], in.rotation[1], in.rotation[2]);
    const double length = glm::length(q);
    if (length < 1e-12) return fail("{}: {}: rotation has length {}", input.file, element, length);
    if (std::abs(length - 1.0) > 1e-3)
      input.warnings.add("rotation is not of unit length: normalised", element);
    out.rotation = q / length;
  }
  return {};
}

std::uint32_t lightOf(const tinygltf::Node& node) {
  const auto found = node.extensions.find("KHR_lights_punctual");
  return found == node.extensions.end()
             ? kNone
             : static_cast<std::uint32_t>(found->second.Get("light").GetNumberAsInt());
}

Result<Node> toNode(const GltfInput& input, int index) {
  const tinygltf::Node& in = input.model.nodes[at(index)];
  Node out;
  out.name = in.name.empty() ? fmt::format("node {}", index) : printable(in.name);
  if (auto ok = readTransform(input, index, out); !ok) return tl::unexpected(ok.error());
  if (in.mesh >= 0) out.mesh = static_cast<std::uint32_t>(in.mesh);
  if (in.camera >= 0) out.camera = static_cast<std::uint32_t>(in.camera);
  out.light = lightOf(in);
  if (in.skin >= 0) input.warnings.add("skins are not applied", fmt::format("node {}", index));
  return out;
}

Result<Camera> toCamera(const GltfInput& input, std::size_t index) {
  const tinygltf::Camera& in = input.model.cameras[index];
  Camera out;
  out.name = printable(in.name);
  out.perspective = in.type == "perspective";
  out.zNear = out.perspective ? in.perspective.znear : in.orthographic.znear;
  out.zFar = out.perspective ? in.perspective.zfar : in.orthographic.zfar;
  if (out.perspective) {
    out.fovY = in.perspective.yfov;
    if (out.fovY > kMaxFovY) {
      input.warnings.add("yfov is not below 179 degrees: made so", fmt::format("camera {}", index));
      out.fovY = kMaxFovY;
    }
  } else {
    out.yMag = std::abs(in.orthographic.ymag);
    if (in.orthographic.xmag == 0.0 || out.yMag == 0.0)
      return fail("{}: camera {}: xmag {} and ymag {} must not be 0", input.file, index, in.orthographic.xmag,
                  in.orthographic.ymag);
  }
  if ((!out.perspective || out.zFar != 0.0) && out.zFar <= out.zNear)
    return fail("{}: camera {}: zfar {} is not past znear {}", input.file, index, out.zFar, out.zNear);
  return out;
}

Result<Light> toLight(const GltfInput& input, std::size_t index) {
  const tinygltf::Light& in = input.model.lights[index];
  Light out;
  out.name = printable(in.name);
  if (in.type == "directional") out.type = LightType::Directional;
  if (in.type == "spot") out.type = LightType::Spot;
  if (!in.color.empty()) out.color = glm::vec3(glm::dvec3(in.color[0], in.color[1], in.color[2]));
  out.intensity = static_cast<float>(in.intensity);
  out.range = static_cast<float>(in.range);
  if (out.type == LightType::Spot) {
    out.innerCone = static_cast<float>(in.spot.innerConeAngle);
    out.outerCone = static_cast<float>(in.spot.outerConeAngle);
    if (!(out.outerCone > 0.0f))
      return fail("{}: light {}: outerConeAngle {} is not above 0", input.file, index,
                  in.spot.outerConeAngle);
    if (out.innerCone >= out.outerCone) {
      // A hard edge, as exporters write it; the falloff divides by the difference.
      input.warnings.add("innerConeAngle is not below outerConeAngle: made so",
                         fmt::format("light {}", index));
      out.innerCone = out.outerCone * 0.999f;
    }
  }
  out.castsShadow = in.extras.Has("tessera_shadow") && in.extras.Get("tessera_shadow").IsBool() &&
                    in.extras.Get("tessera_shadow").Get<bool>();
  return out;
}

}  // namespace

Result<void> buildCamerasAndLights(const GltfInput& input, Scene& scene) {
  for (std::size_t i = 0; i < input.model.cameras.size(); ++i) {
    auto camera = toCamera(input, i);
    if (!camera) return tl::unexpected(camera.error());
    scene.cameras.push_back(std::move(*camera));
  }
  for (std::size_t i = 0; i < input.model.lights.size(); ++i) {
    auto light = toLight(input, i);
    if (!light) return tl::unexpected(light.error());
    scene.lights.push_back(std::move(*light));
  }
  return {};
}

Result<std::vector<std::uint32_t>> buildNodes(const GltfInput& input, Scene& scene) {
  const auto parents = parentsOf(input);
  if (!parents) return tl::unexpected(parents.error());
  auto roots = rootsOf(input, *parents);
  if (!roots) return tl::unexpected(roots.error());

  std::vector<std::uint32_t> made(parents->size(), kNone);
  // Depth first with a stack of our own: files may nest deeper than the program's. Last in, first out: so
  // reversed.
  std::vector<int> stack(roots->rbegin(), roots->rend());
  while (!stack.empty()) {
    const int index = stack.back();
    stack.pop_back();
    auto node = toNode(input, index);
    if (!node) return tl::unexpected(node.error());
    const int parent = (*parents)[at(index)];
    node->parent = parent < 0 ? kNone : made[at(parent)];
    made[at(index)] = static_cast<std::uint32_t>(scene.nodes.size());
    scene.nodes.push_back(std::move(*node));
    const auto& children = input.model.nodes[at(index)].children;
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
  return made;
}

Result<void> buildInstances(const GltfInput& input, Scene& scene) {
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh == kNone) continue;
    const Mesh& mesh = scene.meshes[scene.nodes[n].mesh];
    if (mesh.primitiveCount > kMaxInstances - scene.instances.size())
      return fail("{}: node '{}': {} primitives more are past the limit of {} instances", input.file,
                  scene.nodes[n].name, mesh.primitiveCount, kMaxInstances);
    for (std::uint32_t i = 0; i < mesh.primitiveCount; ++i)
      scene.instances.push_back({static_cast<std::uint32_t>(n), mesh.firstPrimitive + i});
  }
  return {};
}

}  // namespace tessera
