// The scene on the GPU: vertex arrays, instances, patches, materials, textures.
#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "engine/frame/batches.hpp"
#include "engine/frame/features.hpp"
#include "engine/gl/objects.hpp"
#include "glsl/shared/material.h"

namespace tessera {

struct SceneBuffers {
  gl::Buffer positions, normals, tangents, uv0, uv1, colors;
  gl::Buffer indices;
  gl::Buffer instances;  // InstanceGpu: opaque and masked ones, then blended ones
  gl::Buffer patches;    // PatchGeometry
  gl::Buffer patchInstance;
  gl::Buffer materials;  // MaterialGpu, materialStride bytes apart
  std::size_t materialStride = 0;
  gl::VertexArray vertexArray;
  std::vector<gl::Texture> textures;
  std::vector<gl::Sampler> samplers;

  struct Binding {
    GLuint texture = 0;
    GLuint sampler = 0;
  };
  std::vector<std::array<Binding, 5>> materialBindings;  // by material, by slot; 0 = unused
  std::size_t textureBytes = 0;
  std::size_t geometryBytes = 0;

  /// Binds what every scene-reading shader may ask for.
  void bind() const;
  /// How many instances of a draw share a record of the instances: 1, but where each is drawn several times.
  void stepInstances(unsigned divisor) const;
  void bindMaterial(std::uint32_t material, const Permutation& permutation) const;
};

/// Uploads everything; images that are uploaded are freed from `scene` on the way, so that the peak stays
/// low.
Result<SceneBuffers> upload(Scene& scene, const DrawScene& draw);

/// The GPU records of the draw scene's instances followed by the blended ones, relative to `anchor`.
std::vector<glsl::InstanceGpu> instanceRecords(const Scene& scene, const DrawScene& draw,
                                               const SceneState& state, const glm::dvec3& anchor);

}  // namespace tessera
