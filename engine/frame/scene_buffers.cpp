#include "engine/frame/scene_buffers.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

GLint minFilter(const Sampler& sampler) {
  const bool linear = sampler.min == Filter::Linear;
  switch (sampler.mip) {
    case Mip::None:
      return linear ? GL_LINEAR : GL_NEAREST;
    case Mip::Nearest:
      return linear ? GL_LINEAR_MIPMAP_NEAREST : GL_NEAREST_MIPMAP_NEAREST;
    case Mip::Linear:
      return linear ? GL_LINEAR_MIPMAP_LINEAR : GL_NEAREST_MIPMAP_LINEAR;
  }
  return GL_LINEAR_MIPMAP_LINEAR;
}

GLint wrapMode(Wrap wrap) {
  switch (wrap) {
    case Wrap::Repeat:
      return GL_REPEAT;
    case Wrap::Mirror:
      return GL_MIRRORED_REPEAT;
    case Wrap::Clamp:
      return GL_CLAMP_TO_EDGE;
  }
  return GL_REPEAT;
}

glsl::MaterialGpu materialRecord(const Material& material) {
  glsl::MaterialGpu gpu;
  gpu.baseColor = material.baseColorFactor;
  gpu.emissive = glm::vec4(material.emissiveFactor, material.alphaCutoff);
  gpu.factors = glm::vec4(material.metallicFactor, material.roughnessFactor, material.normalScale,
                          material.occlusionStrength);
  const std::array<const TextureSlot*, 5> slots = {&material.baseColor, &material.metallicRoughness,
                                                   &material.normal, &material.occlusion, &material.emissive};
  for (std::size_t i = 0; i < slots.size(); ++i) {
    gpu.uvRows[2 * i] = glm::vec4(slots[i]->uvTransform[0], static_cast<float>(slots[i]->uvSet));
    gpu.uvRows[2 * i + 1] = glm::vec4(slots[i]->uvTransform[1], 0.0f);
  }
  return gpu;
}

constexpr GLuint kInstanceBinding = 8;

/// InstanceGpu as attributes that step once an instance: see lib/instance.glsl.
void bindInstances(const SceneBuffers& buffers) {
  const GLuint array = buffers.vertexArray.get();
  const GladGLContext& gl = gl::api();
  gl.VertexArrayVertexBuffer(array, kInstanceBinding, buffers.instances.get(), 0, sizeof(glsl::InstanceGpu));
  gl.VertexArrayBindingDivisor(array, kInstanceBinding, 1);
  for (GLuint row = 0; row < 5; ++row) {
    const GLuint location = kInstanceBinding + row;
    const GLuint offset = row * 16;
    gl.EnableVertexArrayAttrib(array, location);
    if (row < 3)
      gl.VertexArrayAttribFormat(array, location, 4, GL_FLOAT, GL_FALSE, offset);
    else
      gl.VertexArrayAttribIFormat(array, location, 4, GL_UNSIGNED_INT, offset);
    gl.VertexArrayAttribBinding(array, location, kInstanceBinding);
  }
}

class TextureUploader {
 public:
  TextureUploader(Scene& scene, SceneBuffers& buffers) : scene_(scene), buffers_(buffers) {}

  SceneBuffers::Binding use(const TextureSlot& slot, bool srgb) {
    return {texture(slot.image, srgb), sampler(slot.sampler)};
  }

 private:
  GLuint texture(std::uint32_t image, bool srgb) {
    const auto key = std::make_pair(image, srgb);
    if (const auto found = textures_.find(key); found != textures_.end()) return found->second;
    const Image& pixels = scene_.images[image].image;
    const int levels = std::bit_width(static_cast<unsigned>(std::max(pixels.width, pixels.height)));
    gl::Texture texture(srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, pixels.width, pixels.height, levels);
    texture.upload(0, GL_RGBA, GL_UNSIGNED_BYTE, pixels.pixels.data());
    gl::api().GenerateTextureMipmap(texture.get());
    buffers_.textureBytes += texture.bytes();
    const GLuint name = texture.get();
    buffers_.textures.push_back(std::move(texture));
    textures_.emplace(key, name);
    return name;
  }

  GLuint sampler(const Sampler& sampler) {
    const auto key = std::make_tuple(sampler.mag, sampler.min, sampler.mip, sampler.wrapS, sampler.wrapT);
    if (const auto found = samplers_.find(key); found != samplers_.end()) return found->second;
    gl::Sampler made = gl::Sampler::make();
    made.set(GL_TEXTURE_MIN_FILTER, minFilter(sampler));
    made.set(GL_TEXTURE_MAG_FILTER, sampler.mag == Filter::Linear ? GL_LINEAR : GL_NEAREST);
    made.set(GL_TEXTURE_WRAP_S, wrapMode(sampler.wrapS));
    made.set(GL_TEXTURE_WRAP_T, wrapMode(sampler.wrapT));
    const GLuint name = made.get();
    buffers_.samplers.push_back(std::move(made));
    samplers_.emplace(key, name);
    return name;
  }

  Scene& scene_;
  SceneBuffers& buffers_;
  std::map<std::pair<std::uint32_t, bool>, GLuint> textures_;
  std::map<std::tuple<Filter, Filter, Mip, Wrap, Wrap>, GLuint> samplers_;
};

struct MaterialUse {
  const TextureSlot* slot;
  bool srgb;
  bool read;
};

std::array<MaterialUse, 5> usesOf(const Material& material, const Permutation& p) {
  return {{{&material.baseColor, true, p.baseTexture},
           {&material.metallicRoughness, false, p.metallicRoughnessTexture},
           {&material.normal, false, p.normalTexture},
           {&material.occlusion, false, p.occlusionTexture},
           {&material.emissive, true, p.emissiveTexture}}};
}

}  // namespace

std::vector<glsl::InstanceGpu> instanceRecords(const Scene& scene, const DrawScene& draw,
                                               const SceneState& state, const glm::dvec3& anchor) {
  std::vector<glsl::InstanceGpu> records;
  records.reserve(draw.instances.size() + draw.blended.size());
  auto add = [&](const Instance& instance, std::uint32_t patchBase, std::uint32_t batch) {
    const glm::dmat4& world = state.world[instance.node];
    const PatchSet& set = draw.patchCounts[instance.primitive];
    const std::uint32_t material = scene.primitives[instance.primitive].material;
    glsl::InstanceGpu gpu{};
    for (int row = 0; row < 3; ++row) {
      const glm::vec4 values(
          glm::dvec4(world[0][row], world[1][row], world[2][row], world[3][row] - anchor[row]));
      (row == 0 ? gpu.row0 : row == 1 ? gpu.row1 : gpu.row2) = values;
    }
    // An animation may take a node past what floats hold: it then shows nothing, as a point.
    const float sum =
        glm::dot(glm::abs(gpu.row0) + glm::abs(gpu.row1) + glm::abs(gpu.row2), glm::vec4(1e-3f));
    if (!std::isfinite(sum)) gpu.row0 = gpu.row1 = gpu.row2 = glm::vec4(0.0f);
    gpu.patchBase = patchBase;
    gpu.patchOffset = draw.patchOffset[instance.primitive];
    gpu.pairs = set.pairs;
    gpu.triples = set.triples;
    gpu.singles = set.singles;
    gpu.batch = batch;
    gpu.flags = mirrors(world) ? glsl::kInstanceMirrored : 0u;
    gpu.material = material;
    records.push_back(gpu);
  };
  for (std::size_t i = 0; i < draw.instances.size(); ++i)
    add(draw.instances[i], draw.patchBase[i], draw.batchOf[i]);
  for (const Instance& instance : draw.blended) add(instance, 0, 0);
  return records;
}

Result<SceneBuffers> upload(Scene& scene, const DrawScene& draw) {
  SceneBuffers buffers;
  GLint largest = 0;
  gl::api().GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  for (const SceneImage& image : scene.images)
    if (image.image.width > largest || image.image.height > largest)
      return fail("{}: image '{}' of {} x {} is past this context's limit of {}", scene.file, image.name,
                  image.image.width, image.image.height, largest);
  const Vertices& v = scene.vertices;
  buffers.positions = gl::Buffer(v.position, 0);
  buffers.normals = gl::Buffer(v.normal, 0);
  buffers.tangents = gl::Buffer(v.tangent, 0);
  buffers.uv0 = gl::Buffer(v.uv0, 0);
  buffers.uv1 = gl::Buffer(v.uv1, 0);
  buffers.colors = gl::Buffer(v.color, 0);
  buffers.indices = gl::Buffer(draw.indices, 0);
  buffers.patches = gl::Buffer(draw.patches, 0);
  buffers.patchInstance = gl::Buffer(draw.instanceOfPatch, 0);
  GLint alignment = 1;
  gl::api().GetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
  const auto step = static_cast<std::size_t>(alignment);
  buffers.materialStride = (sizeof(glsl::MaterialGpu) + step - 1) / step * step;
  buffers.materials = gl::Buffer(buffers.materialStride * scene.materials.size());
  for (std::size_t i = 0; i < scene.materials.size(); ++i)
    buffers.materials.writeValue(materialRecord(scene.materials[i]), i * buffers.materialStride);
  buffers.instances = gl::Buffer((draw.instances.size() + draw.blended.size()) * sizeof(glsl::InstanceGpu));
  for (const gl::Buffer* buffer :
       {&buffers.positions, &buffers.normals, &buffers.tangents, &buffers.uv0, &buffers.uv1, &buffers.colors,
        &buffers.indices, &buffers.patches, &buffers.patchInstance, &buffers.instances, &buffers.materials})
    buffers.geometryBytes += buffer->size();

  buffers.vertexArray = gl::VertexArray::make();
  buffers.vertexArray.indices(buffers.indices);
  buffers.vertexArray.attribute(0, buffers.positions, 3, sizeof(glm::vec3));
  buffers.vertexArray.attribute(1, buffers.normals, 3, sizeof(glm::vec3));
  bindInstances(buffers);
  if (!v.tangent.empty()) buffers.vertexArray.attribute(2, buffers.tangents, 4, sizeof(glm::vec4));
  if (!v.uv0.empty()) buffers.vertexArray.attribute(3, buffers.uv0, 2, sizeof(glm::vec2));
  if (!v.uv1.empty()) buffers.vertexArray.attribute(4, buffers.uv1, 2, sizeof(glm::vec2));
  if (!v.color.empty()) buffers.vertexArray.attribute(5, buffers.colors, 4, sizeof(glm::vec4));

  TextureUploader uploader(scene, buffers);
  buffers.materialBindings.resize(scene.materials.size());
  std::vector<bool> used(scene.materials.size(), false);
  for (const Instance& instance : scene.instances) used[scene.primitives[instance.primitive].material] = true;
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    if (!used[m]) continue;
    const auto uses = usesOf(scene.materials[m], permutationOf(scene.materials[m], false, {}));
    for (std::size_t slot = 0; slot < uses.size(); ++slot)
      if (uses[slot].read)
        buffers.materialBindings[m][slot] = uploader.use(*uses[slot].slot, uses[slot].srgb);
  }
  for (SceneImage& image : scene.images) std::vector<std::uint8_t>().swap(image.image.pixels);
  return buffers;
}

void SceneBuffers::bind() const {
  positions.bindStorage(BIND_POSITIONS);
  normals.bindStorage(BIND_NORMALS);
  tangents.bindStorage(BIND_TANGENTS);
  uv0.bindStorage(BIND_UV0);
  uv1.bindStorage(BIND_UV1);
  colors.bindStorage(BIND_COLORS);
  instances.bindStorage(BIND_INSTANCES);
  patches.bindStorage(BIND_PATCHES);
  patchInstance.bindStorage(BIND_PATCH_INSTANCE);
}

void SceneBuffers::stepInstances(unsigned divisor) const {
  gl::api().VertexArrayBindingDivisor(vertexArray.get(), kInstanceBinding, divisor);
}

void SceneBuffers::bindMaterial(std::uint32_t material, const Permutation& permutation) const {
  const std::array<bool, 5> read = {permutation.baseTexture, permutation.metallicRoughnessTexture,
                                    permutation.normalTexture, permutation.occlusionTexture,
                                    permutation.emissiveTexture};
  gl::api().BindBufferRange(GL_UNIFORM_BUFFER, BIND_MATERIAL, materials.get(),
                            static_cast<GLintptr>(material * materialStride), sizeof(glsl::MaterialGpu));
  for (GLuint slot = 0; slot < read.size(); ++slot) {
    if (!read[slot]) continue;
    const Binding& binding = materialBindings[material][slot];
    gl::api().BindTextureUnit(UNIT_MATERIAL + slot, binding.texture);
    gl::api().BindSampler(UNIT_MATERIAL + slot, binding.sampler);
  }
}

}  // namespace tessera
