// A scene as the engine sees it: structure-of-arrays geometry, materials, nodes, lights, cameras, animation.
// No GL. Built by gltf.hpp; read-only afterwards.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "engine/image/image.hpp"

namespace tessera {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// Axis-aligned box; empty when min > max.
struct Box {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};

  [[nodiscard]] bool empty() const { return min.x > max.x || min.y > max.y || min.z > max.z; }
  void add(const glm::dvec3& p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  void add(const Box& b) {
    min = glm::min(min, b.min);
    max = glm::max(max, b.max);
  }
  [[nodiscard]] glm::dvec3 centre() const { return (min + max) * 0.5; }
  [[nodiscard]] double diagonal() const { return empty() ? 0.0 : glm::length(max - min); }
};

/// Vertices of all primitives, one array an attribute. `position` and `normal` always have one entry a
/// vertex; the others are either as long as `position` or empty when no primitive of the scene needs them.
struct Vertices {
  std::vector<glm::vec3> position;  // metres, in the space of the mesh
  std::vector<glm::vec3> normal;    // unit length, or the face normal where the file has none or a zero one
  std::vector<glm::vec4> tangent;   // xyz unit, w = +1 or -1 (sign of the bitangent); only with normal maps
  std::vector<glm::vec2> uv0;
  std::vector<glm::vec2> uv1;
  std::vector<glm::vec4> color;  // linear RGBA, 1 where a primitive has none
};

/// One draw's worth of triangles: always an indexed triangle list, indices absolute into Vertices.
struct Primitive {
  std::uint32_t firstIndex = 0;
  std::uint32_t indexCount = 0;  // a multiple of 3, > 0
  std::uint32_t firstVertex = 0;
  std::uint32_t vertexCount = 0;
  std::uint32_t material = 0;  // index into Scene::materials, always valid
  bool hasColor = false;
  bool hasUv1 = false;
  Box bounds;  // in the space of the mesh
};

struct Mesh {
  std::string name;
  std::uint32_t firstPrimitive = 0;
  std::uint32_t primitiveCount = 0;
};

enum class AlphaMode : std::uint8_t { Opaque, Mask, Blend };
enum class Filter : std::uint8_t { Nearest, Linear };
enum class Mip : std::uint8_t { None, Nearest, Linear };
enum class Wrap : std::uint8_t { Repeat, Mirror, Clamp };

struct Sampler {
  Filter mag = Filter::Linear;
  Filter min = Filter::Linear;
  Mip mip = Mip::Linear;
  Wrap wrapS = Wrap::Repeat;
  Wrap wrapT = Wrap::Repeat;
  bool operator==(const Sampler&) const = default;
};

/// A use of an image by a material. KHR_texture_transform is folded into `uvTransform`:
/// uv' = (m * (u, v, 1)).xy with rows of the 2x3 matrix in uvTransform[0], uvTransform[1].
struct TextureSlot {
  std::uint32_t image = kNone;  // index into Scene::images; kNone = slot unused
  Sampler sampler;
  std::uint8_t uvSet = 0;  // 0 or 1
  std::array<glm::vec3, 2> uvTransform{glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)};
  bool hasTransform = false;
  [[nodiscard]] bool used() const { return image != kNone; }
};

/// glTF 2.0 metallic-roughness material, with KHR_materials_unlit and KHR_materials_emissive_strength.
struct Material {
  std::string name;
  glm::vec4 baseColorFactor{1.0f};  // linear
  float metallicFactor = 1.0f;
  float roughnessFactor = 1.0f;
  glm::vec3 emissiveFactor{0.0f};  // linear, emissive strength already multiplied in
  float normalScale = 1.0f;
  float occlusionStrength = 1.0f;
  float alphaCutoff = 0.5f;
  AlphaMode alphaMode = AlphaMode::Opaque;
  bool doubleSided = false;
  bool unlit = false;
  TextureSlot baseColor;          // sRGB
  TextureSlot metallicRoughness;  // linear: g = roughness, b = metallic
  TextureSlot normal;             // linear
  TextureSlot occlusion;          // linear: r
  TextureSlot emissive;           // sRGB
};

/// A decoded image of the scene. An image may be used both as sRGB and linear; each use gets its own texture.
struct SceneImage {
  std::string name;
  Image image;
};

enum class LightType : std::uint8_t { Directional, Point, Spot };

/// KHR_lights_punctual, in the space of its node (shines along -z). Lux for directional, candela for the
/// others.
struct Light {
  std::string name;
  LightType type = LightType::Point;
  glm::vec3 color{1.0f};
  float intensity = 1.0f;
  float range = 0.0f;  // metres; 0 = unlimited
  float innerCone = 0.0f;
  float outerCone = 0.785398163f;  // radians
  bool castsShadow = false;        // glTF cannot say it: extras {"tessera_shadow": true} on the light does
};

struct Camera {
  std::string name;
  bool perspective = true;
  double fovY = 0.8;    // radians, perspective only
  double zNear = 0.05;  // metres
  double zFar = 0.0;    // 0 = infinite
  double yMag = 1.0;    // orthographic only: half height in metres
};

struct Node {
  std::string name;
  std::uint32_t parent = kNone;  // always smaller than the node's own index: nodes are sorted parents first
  std::uint32_t mesh = kNone;
  std::uint32_t camera = kNone;
  std::uint32_t light = kNone;
  // Local transform: either a matrix, or translation, rotation and scale (animated nodes are always the
  // latter).
  bool hasMatrix = false;
  glm::dmat4 matrix{1.0};
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 scale{1.0};
};

/// A primitive placed by a node: the unit of drawing. Instances are listed by node, then primitive.
struct Instance {
  std::uint32_t node = 0;
  std::uint32_t primitive = 0;
};

enum class Interpolation : std::uint8_t { Linear, Step, Cubic };
enum class AnimatedProperty : std::uint8_t { Translation, Rotation, Scale };

struct AnimationChannel {
  std::uint32_t node = 0;
  AnimatedProperty property = AnimatedProperty::Translation;
  Interpolation interpolation = Interpolation::Linear;
  std::vector<float> times;  // seconds, strictly increasing
  std::vector<glm::vec4>
      values;  // one a time (three for Cubic: in-tangent, value, out-tangent); rotations xyzw
};

struct Animation {
  std::string name;
  double duration = 0.0;  // seconds
  std::vector<AnimationChannel> channels;
};

struct Scene {
  std::string file;  // as given to the loader
  Vertices vertices;
  std::vector<std::uint32_t> indices;
  std::vector<Primitive> primitives;
  std::vector<Mesh> meshes;
  std::vector<Material> materials;  // at least one: a primitive without material gets the glTF default
  std::vector<SceneImage> images;
  std::vector<Node> nodes;
  std::vector<Instance> instances;
  std::vector<Light> lights;
  std::vector<Camera> cameras;
  std::vector<Animation> animations;
  /// What the file asks for that is not applied, one line each: "skin on node 'arm': drawn at rest".
  std::vector<std::string> warnings;
  Box bounds;  // of all instances at time 0, world space

  [[nodiscard]] std::uint64_t triangleCount() const;  // as instanced
  [[nodiscard]] bool animated() const;  // any channel drives a node that leads to geometry, light or camera
};

/// World transforms at one time. Recomputed by `evaluate`; double so that far-away scenes keep their digits.
struct SceneState {
  double time = 0.0;
  std::vector<glm::dmat4> world;  // one a node
};

/// Evaluates all animations of the scene at `time` seconds (each loops over its own duration) into `state`.
void evaluate(const Scene& scene, double time, SceneState& state);

/// One entry a node: true if an animation channel drives the node or one of its ancestors.
std::vector<bool> movingNodes(const Scene& scene);

/// True if the world matrix mirrors (negative determinant): front faces are clockwise then.
bool mirrors(const glm::dmat4& world);

}  // namespace tessera
