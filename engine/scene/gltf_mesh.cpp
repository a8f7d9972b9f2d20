// Meshes and primitives: attributes by semantic, triangles by mode.
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/scene/gltf_build.hpp"
#include "engine/scene/gltf_geometry.hpp"
#include "engine/scene/tangents.hpp"

namespace tessera {
namespace {

constexpr std::size_t kMaxVertices = std::size_t{1} << 26;
constexpr std::size_t kMaxIndices = std::size_t{1} << 28;

/// Which component types an attribute may have, as bits; n: normalized.
enum Format : unsigned {
  kFloat = 1,
  kByte = 2,
  kByteN = 4,
  kUbyte = 8,
  kUbyteN = 16,
  kShort = 32,
  kShortN = 64,
  kUshort = 128,
  kUshortN = 256,
};

struct Semantic {
  const char* name;
  std::size_t minComponents;
  std::size_t maxComponents;
  unsigned core;       // glTF 2.0 sec. 3.7.2.1
  unsigned quantized;  // more with KHR_mesh_quantization
};

constexpr Semantic kPosition{"POSITION", 3, 3, kFloat,
                             kByte | kByteN | kUbyte | kUbyteN | kShort | kShortN | kUshort | kUshortN};
constexpr Semantic kNormal{"NORMAL", 3, 3, kFloat, kByteN | kShortN};
constexpr Semantic kTangent{"TANGENT", 4, 4, kFloat, kByteN | kShortN};
constexpr Semantic kUv0{"TEXCOORD_0", 2, 2, kFloat | kUbyteN | kUshortN,
                        kByte | kByteN | kUbyte | kShort | kShortN | kUshort};
constexpr Semantic kUv1{"TEXCOORD_1", 2, 2, kUv0.core, kUv0.quantized};
constexpr Semantic kColor{"COLOR_0", 3, 4, kFloat | kUbyteN | kUshortN, 0};

unsigned formatOf(const tinygltf::Accessor& accessor) {
  switch (accessor.componentType) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return kFloat;
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return accessor.normalized ? kByteN : kByte;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return accessor.normalized ? kUbyteN : kUbyte;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return accessor.normalized ? kShortN : kShort;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return accessor.normalized ? kUshortN : kUshort;
    default:
      return 0;
  }
}

bool isVector(int type) {
  return type == TINYGLTF_TYPE_VEC2 || type == TINYGLTF_TYPE_VEC3 || type == TINYGLTF_TYPE_VEC4;
}

template <int N>
std::vector<glm::vec<N, float>> toVectors(const std::vector<float>& values, std::size_t width, float fill) {
  std::vector<glm::vec<N, float>> out(values.size() / width, glm::vec<N, float>(fill));
  for (std::size_t i = 0; i < out.size(); ++i)
    for (std::size_t c = 0; c < width; ++c) out[i][static_cast<int>(c)] = values[i * width + c];
  return out;
}

/// Replaces components that are not finite; returns whether there were any.
template <class V>
bool replaceNonFinite(std::vector<V>& values, float other) {
  bool any = false;
  for (V& v : values)
    for (int c = 0; c < v.length(); ++c)
      if (!std::isfinite(v[c])) {
        v[c] = other;
        any = true;
      }
  return any;
}

bool usableTangents(std::vector<glm::vec4>& tangents) {
  for (glm::vec4& tangent : tangents) {
    const glm::dvec3 direction(tangent);
    const double length = glm::length(direction);
    if (!std::isfinite(length) || length < 1e-6 || !std::isfinite(tangent.w) || tangent.w == 0.0f)
      return false;
    tangent = glm::vec4(glm::vec3(direction / length), tangent.w < 0.0f ? -1.0f : 1.0f);
  }
  return true;
}

/// What a material reads from vertices.
struct Needs {
  bool uv0 = false;
  bool uv1 = false;
  bool tangent = false;
};

Needs needsOf(const Material& material) {
  Needs needs;
  for (const TextureSlot* slot : {&material.baseColor, &material.metallicRoughness, &material.normal,
                                  &material.occlusion, &material.emissive}) {
    if (!slot->used()) continue;
    (slot->uvSet == 0 ? needs.uv0 : needs.uv1) = true;
  }
  needs.tangent = material.normal.used();
  return needs;
}

/// Appends a primitive's optional attribute to the scene's: both stay absent, or the gaps are filled.
template <class T>
void appendOrFill(std::vector<T>& to, const std::vector<T>& from, std::size_t before, std::size_t count,
                  T fill) {
  if (to.empty() && from.empty()) return;
  to.resize(before, fill);
  to.insert(to.end(), from.begin(), from.end());
  to.resize(before + count, fill);
}

class MeshBuilder {
 public:
  MeshBuilder(const GltfInput& input, Scene& scene) : input_(input), scene_(scene) {
    const auto& used = input.model.extensionsUsed;
    quantization_ = std::ranges::find(used, "KHR_mesh_quantization") != used.end();
  }

  Result<void> run() {
    std::vector<bool> shown(input_.model.meshes.size(), false);
    for (const Node& node : scene_.nodes)
      if (node.mesh != kNone) shown[node.mesh] = true;
    for (std::size_t m = 0; m < input_.model.meshes.size(); ++m) {
      const tinygltf::Mesh& in = input_.model.meshes[m];
      Mesh mesh{printable(in.name), static_cast<std::uint32_t>(scene_.primitives.size()), 0};
      for (std::size_t p = 0; p < in.primitives.size(); ++p) {
        element_ = fmt::format("mesh {}, primitive {}", m, p);
        if (auto ok = primitive(in.primitives[p], shown[m]); !ok) return ok;
      }
      mesh.primitiveCount = static_cast<std::uint32_t>(scene_.primitives.size()) - mesh.firstPrimitive;
      scene_.meshes.push_back(std::move(mesh));
    }
    if (scene_.materials.empty()) scene_.materials.emplace_back();
    return {};
  }

 private:
  template <class... Args>
  [[nodiscard]] tl::unexpected<Error> failHere(fmt::format_string<Args...> format, Args&&... args) const {
    return fail("{}: {}: {}", input_.file, element_, fmt::format(format, std::forward<Args>(args)...));
  }

  Result<void> primitive(const tinygltf::Primitive& in, bool shown) {
    if (!in.targets.empty()) input_.warnings.add("morph targets are not applied", element_);
    if (auto ok = checkAttributes(in); !ok) return ok;
    const auto position = in.attributes.find(kPosition.name);
    if (position == in.attributes.end()) {
      input_.warnings.add("primitive without POSITION is not drawn", element_);
      return {};
    }
    auto corners = cornersOf(in, input_.accessors.count(position->second));
    if (!corners) return tl::unexpected(corners.error());
    if (corners->empty()) return {};
    dropRepeatedIndices(*corners);
    if (corners->empty()) {
      input_.warnings.add("primitive has 0 triangles", element_);
      return {};
    }

    const std::uint32_t material = shown ? materialOf(in) : kNone;
    const Needs needs = shown ? needsOf(scene_.materials[material]) : Needs{};
    Geometry geometry;
    geometry.indices = std::move(*corners);
    const std::vector<std::uint32_t> vertices = compactor_.compact(geometry.indices);
    if (auto ok = readAttributes(in, needs, vertices, geometry); !ok) return ok;
    if (!shown) return {};
    weld(geometry);
    return append(geometry, material, needs);
  }

  /// Types and counts of all attributes, used or not.
  Result<void> checkAttributes(const tinygltf::Primitive& in) const {
    std::optional<std::size_t> count;
    for (const auto& [name, accessor] : in.attributes) {
      const std::size_t own = input_.accessors.count(accessor);
      if (count && own != *count)
        return failHere("{} has {} elements where others have {}", printable(name), own, *count);
      count = own;
    }
    if (count && *count >= kNone) return failHere("{} vertices are past the limit of {}", *count, kNone - 1);
    for (const Semantic& semantic : {kPosition, kNormal, kTangent, kUv0, kUv1, kColor})
      if (auto ok = checkAttribute(in, semantic); !ok) return ok;
    return {};
  }

  Result<void> checkAttribute(const tinygltf::Primitive& in, const Semantic& semantic) const {
    const auto found = in.attributes.find(semantic.name);
    if (found == in.attributes.end()) return {};
    const tinygltf::Accessor& accessor = input_.accessors.description(found->second);
    const std::size_t components = input_.accessors.components(found->second);
    const unsigned format = formatOf(accessor);
    if (!isVector(accessor.type) || components < semantic.minComponents ||
        components > semantic.maxComponents)
      return failHere("{}: accessor {} has {} components", semantic.name, found->second, components);
    if ((format & (semantic.core | semantic.quantized)) == 0)
      return failHere("{}: accessor {} has componentType {}, normalized {}", semantic.name, found->second,
                      accessor.componentType, accessor.normalized);
    if ((format & semantic.core) == 0 && !quantization_)
      input_.warnings.add("quantized attribute without KHR_mesh_quantization", element_);
    return {};
  }

  /// The vertex numbers of the triangles' corners; empty (with a warning) if the mode draws none.
  Result<std::vector<std::uint32_t>> cornersOf(const tinygltf::Primitive& in, std::size_t vertexCount) const {
    Topology topology = Topology::Triangles;
    if (in.mode == TINYGLTF_MODE_TRIANGLE_STRIP)
      topology = Topology::Strip;
    else if (in.mode == TINYGLTF_MODE_TRIANGLE_FAN)
      topology = Topology::Fan;
    const std::size_t count = in.indices >= 0 ? input_.accessors.count(in.indices) : vertexCount;
    const std::size_t perElement = topology == Topology::Triangles ? 1 : 3;
    if (count > (kMaxIndices - scene_.indices.size()) / perElement)
      return failHere("{} indices are past the limit of {} in a scene", count, kMaxIndices);

    std::vector<std::uint32_t> indices;
    if (in.indices >= 0) {
      auto read = readIndices(in, vertexCount);
      if (!read) return tl::unexpected(read.error());
      indices = std::move(*read);
    } else {
      indices.resize(count);
      for (std::size_t i = 0; i < count; ++i) indices[i] = static_cast<std::uint32_t>(i);
    }
    if (in.mode < TINYGLTF_MODE_TRIANGLES) {
      input_.warnings.add("points and lines are not drawn", element_);
      return std::vector<std::uint32_t>{};
    }
    if (topology == Topology::Triangles && indices.size() % 3 != 0)
      input_.warnings.add("indices after the last whole triangle are left out", element_);
    indices = triangleList(topology, indices);
    if (indices.empty()) input_.warnings.add("primitive has 0 triangles", element_);
    return indices;
  }

  Result<std::vector<std::uint32_t>> readIndices(const tinygltf::Primitive& in,
                                                 std::size_t vertexCount) const {
    const tinygltf::Accessor& accessor = input_.accessors.description(in.indices);
    std::uint32_t restart = 0;
    if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) restart = 0xff;
    if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) restart = 0xffff;
    if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) restart = 0xffffffff;
    if (accessor.type != TINYGLTF_TYPE_SCALAR || restart == 0 || accessor.normalized)
      return failHere("indices: accessor {} is not of plain unsigned scalars", in.indices);
    if (accessor.bufferView >= 0 &&
        input_.model.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride != 0)
      return failHere("indices: bufferView {} has a byteStride", accessor.bufferView);
    std::vector<std::uint32_t> indices = input_.accessors.integers(in.indices);
    for (const std::uint32_t index : indices) {
      if (index == restart) return failHere("index {} is the primitive restart value", index);
      if (index >= vertexCount) return failHere("index {} is past {} vertices", index, vertexCount);
    }
    return indices;
  }

  std::uint32_t materialOf(const tinygltf::Primitive& in) {
    if (in.material >= 0) return static_cast<std::uint32_t>(in.material);
    const std::size_t fromFile = input_.model.materials.size();
    if (scene_.materials.size() == fromFile) scene_.materials.emplace_back();
    return static_cast<std::uint32_t>(fromFile);
  }

  template <int N>
  std::vector<glm::vec<N, float>> read(const tinygltf::Primitive& in, const Semantic& semantic,
                                       const std::vector<std::uint32_t>& vertices, float fill) const {
    const auto found = in.attributes.find(semantic.name);
    if (found == in.attributes.end()) return {};
    return toVectors<N>(input_.accessors.floats(found->second, vertices),
                        input_.accessors.components(found->second), fill);
  }

  std::vector<glm::vec2> readUv(const tinygltf::Primitive& in, const Semantic& semantic,
                                const std::vector<std::uint32_t>& vertices) const {
    std::vector<glm::vec2> uv = read<2>(in, semantic, vertices, 0.0f);
    if (uv.empty())
      input_.warnings.add(fmt::format("a texture needs {}, which is missing: 0 is used", semantic.name),
                          element_);
    if (replaceNonFinite(uv, 0.0f))
      input_.warnings.add(fmt::format("{} is not finite: 0 is used", semantic.name), element_);
    return uv;
  }

  Result<void> readAttributes(const tinygltf::Primitive& in, const Needs& needs,
                              const std::vector<std::uint32_t>& vertices, Geometry& geometry) const {
    Vertices& out = geometry.vertices;
    out.position = read<3>(in, kPosition, vertices, 0.0f);
    for (std::size_t v = 0; v < out.position.size(); ++v) {
      const glm::vec3& p = out.position[v];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        return failHere("POSITION of vertex {} is ({}, {}, {})", vertices[v], p.x, p.y, p.z);
    }
    out.normal = read<3>(in, kNormal, vertices, 0.0f);
    if (needs.uv0) out.uv0 = readUv(in, kUv0, vertices);
    if (needs.uv1) out.uv1 = readUv(in, kUv1, vertices);
    // A tangent belongs to a normal: without normals the file's are to be ignored (glTF 2.0 sec. 3.7.2.1).
    if (needs.tangent && !out.normal.empty()) out.tangent = read<4>(in, kTangent, vertices, 0.0f);
    if (!usableTangents(out.tangent)) {
      input_.warnings.add("TANGENT has a zero or not finite value: generated instead", element_);
      out.tangent.clear();
    }
    readColor(in, vertices, out);
    if (out.normal.empty())
      makeFlat(geometry);
    else if (repairNormals(geometry) > 0)
      input_.warnings.add("NORMAL has a zero or not finite value: the faces' is used", element_);
    return {};
  }

  void readColor(const tinygltf::Primitive& in, const std::vector<std::uint32_t>& vertices,
                 Vertices& out) const {
    out.color = read<4>(in, kColor, vertices, 1.0f);
    if (replaceNonFinite(out.color, 1.0f)) input_.warnings.add("COLOR_0 is not finite: 1 is used", element_);
    for (glm::vec4& color : out.color) color = glm::max(color, glm::vec4(0.0f));
    // White is what a missing colour means: then shaders need not fetch it.
    if (std::ranges::all_of(out.color, [](const glm::vec4& c) { return c == glm::vec4(1.0f); }))
      out.color.clear();
  }

  Result<void> append(const Geometry& geometry, std::uint32_t material, const Needs& needs) {
    const Vertices& in = geometry.vertices;
    Vertices& out = scene_.vertices;
    const std::size_t before = out.position.size();
    const std::size_t count = in.position.size();
    if (count > kMaxVertices - before)
      return failHere("{} vertices are past the limit of {} in a scene", count, kMaxVertices);

    Primitive made;
    made.firstIndex = static_cast<std::uint32_t>(scene_.indices.size());
    made.indexCount = static_cast<std::uint32_t>(geometry.indices.size());
    made.firstVertex = static_cast<std::uint32_t>(before);
    made.vertexCount = static_cast<std::uint32_t>(count);
    made.material = material;
    made.hasColor = !in.color.empty();
    made.hasUv1 = !in.uv1.empty();
    for (const glm::vec3& p : in.position) made.bounds.add(glm::dvec3(p));

    out.position.insert(out.position.end(), in.position.begin(), in.position.end());
    out.normal.insert(out.normal.end(), in.normal.begin(), in.normal.end());
    appendOrFill(out.tangent, in.tangent, before, count, kNoTangent);
    appendOrFill(out.uv0, in.uv0, before, count, glm::vec2(0.0f));
    appendOrFill(out.uv1, in.uv1, before, count, glm::vec2(0.0f));
    appendOrFill(out.color, in.color, before, count, glm::vec4(1.0f));
    for (const std::uint32_t index : geometry.indices) scene_.indices.push_back(made.firstVertex + index);
    scene_.primitives.push_back(made);

    if (needs.tangent && in.tangent.empty())
      generateTangents(scene_, static_cast<std::uint32_t>(scene_.primitives.size() - 1),
                       scene_.materials[material].normal.uvSet);
    return {};
  }

  static constexpr glm::vec4 kNoTangent{1.0f, 0.0f, 0.0f, 1.0f};

  const GltfInput& input_;
  Scene& scene_;
  bool quantization_ = false;
  std::string element_;  // "mesh 3, primitive 0", the one being built
  VertexCompactor compactor_;
};

}  // namespace

Result<void> buildMeshes(const GltfInput& input, Scene& scene) { return MeshBuilder(input, scene).run(); }

}  // namespace tessera
