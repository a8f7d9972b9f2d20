// Materials, samplers and texture slots.
#include <array>
#include <cmath>

#include "engine/scene/gltf_build.hpp"

namespace tessera {
namespace {

using Extensions = tinygltf::ExtensionMap;

/// What the five kinds of glTF texture references have in common.
struct SlotSource {
  int texture;
  int texCoord;
  const Extensions& extensions;
};

Result<Wrap> toWrap(const std::string& what, const char* axis, int value) {
  switch (value) {
    case TINYGLTF_TEXTURE_WRAP_REPEAT:
      return Wrap::Repeat;
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
      return Wrap::Clamp;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
      return Wrap::Mirror;
    default:
      return fail("{}: {} {} is not a wrap mode", what, axis, value);
  }
}

Result<Sampler> toSampler(const std::string& what, const tinygltf::Sampler& in) {
  Sampler out;
  out.mag = in.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST ? Filter::Nearest : Filter::Linear;
  switch (in.minFilter) {
    case TINYGLTF_TEXTURE_FILTER_NEAREST:
      out.min = Filter::Nearest;
      out.mip = Mip::None;
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR:
      out.mip = Mip::None;
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
      out.min = Filter::Nearest;
      out.mip = Mip::Nearest;
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
      out.mip = Mip::Nearest;
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR:
      out.min = Filter::Nearest;
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR:
    case -1:  // not given
      break;
    default:
      return fail("{}: minFilter {} is not a filter", what, in.minFilter);
  }
  const auto s = toWrap(what, "wrapS", in.wrapS);
  if (!s) return tl::unexpected(s.error());
  const auto t = toWrap(what, "wrapT", in.wrapT);
  if (!t) return tl::unexpected(t.error());
  out.wrapS = *s;
  out.wrapT = *t;
  return out;
}

const tinygltf::Value* find(const Extensions& extensions, const char* name) {
  const auto found = extensions.find(name);
  return found == extensions.end() ? nullptr : &found->second;
}

double numberOr(const tinygltf::Value& object, const char* key, double other) {
  return object.Has(key) ? object.Get(key).GetNumberAsDouble() : other;
}

glm::dvec2 pairOr(const tinygltf::Value& object, const char* key, const glm::dvec2& other) {
  if (!object.Has(key)) return other;
  const tinygltf::Value& pair = object.Get(key);
  return {pair.Get(0).GetNumberAsDouble(), pair.Get(1).GetNumberAsDouble()};
}

/// KHR_texture_transform: scale, then rotation, then offset. The rotation is counter-clockwise as seen with v
/// down.
void applyTransform(const tinygltf::Value& transform, TextureSlot& slot) {
  const glm::dvec2 offset = pairOr(transform, "offset", glm::dvec2(0.0));
  const glm::dvec2 scale = pairOr(transform, "scale", glm::dvec2(1.0));
  const double angle = numberOr(transform, "rotation", 0.0);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  slot.uvTransform[0] = glm::vec3(glm::dvec3(c * scale.x, s * scale.y, offset.x));
  slot.uvTransform[1] = glm::vec3(glm::dvec3(-s * scale.x, c * scale.y, offset.y));
  slot.hasTransform = slot.uvTransform[0] != glm::vec3(1, 0, 0) || slot.uvTransform[1] != glm::vec3(0, 1, 0);
}

Result<TextureSlot> toSlot(const GltfInput& input, const std::string& material, const SlotSource& source) {
  TextureSlot slot;
  if (source.texture < 0) return slot;
  const auto& texture = input.model.textures[static_cast<std::size_t>(source.texture)];
  if (texture.source < 0) {
    input.warnings.add("texture without a source is left out", fmt::format("texture {}", source.texture));
    return slot;
  }
  slot.image = static_cast<std::uint32_t>(texture.source);
  if (texture.sampler >= 0) {
    const auto sampler = toSampler(fmt::format("{}: sampler {}", input.file, texture.sampler),
                                   input.model.samplers[static_cast<std::size_t>(texture.sampler)]);
    if (!sampler) return tl::unexpected(sampler.error());
    slot.sampler = *sampler;
  }
  int texCoord = source.texCoord;
  if (const tinygltf::Value* transform = find(source.extensions, "KHR_texture_transform")) {
    applyTransform(*transform, slot);
    texCoord = static_cast<int>(numberOr(*transform, "texCoord", texCoord));
  }
  if (texCoord > 1) {
    input.warnings.add(fmt::format("TEXCOORD_{} is not supported, TEXCOORD_0 is used", texCoord), material);
    texCoord = 0;
  }
  slot.uvSet = static_cast<std::uint8_t>(texCoord);
  return slot;
}

glm::vec3 toVec3(const std::vector<double>& v) { return glm::vec3(glm::dvec3(v[0], v[1], v[2])); }

void applyFactors(const tinygltf::Material& in, Material& out) {
  const auto& pbr = in.pbrMetallicRoughness;
  out.name = printable(in.name);
  out.baseColorFactor = glm::vec4(toVec3(pbr.baseColorFactor), static_cast<float>(pbr.baseColorFactor[3]));
  out.metallicFactor = static_cast<float>(pbr.metallicFactor);
  out.roughnessFactor = static_cast<float>(pbr.roughnessFactor);
  out.emissiveFactor = toVec3(in.emissiveFactor);
  if (const tinygltf::Value* strength = find(in.extensions, "KHR_materials_emissive_strength"))
    out.emissiveFactor *= static_cast<float>(numberOr(*strength, "emissiveStrength", 1.0));
  out.normalScale = static_cast<float>(in.normalTexture.scale);
  out.occlusionStrength = static_cast<float>(in.occlusionTexture.strength);
  out.alphaCutoff = static_cast<float>(in.alphaCutoff);
  if (in.alphaMode == "MASK") out.alphaMode = AlphaMode::Mask;
  if (in.alphaMode == "BLEND") out.alphaMode = AlphaMode::Blend;
  out.doubleSided = in.doubleSided;
  out.unlit = find(in.extensions, "KHR_materials_unlit") != nullptr;
}

Result<Material> toMaterial(const GltfInput& input, std::size_t index) {
  const tinygltf::Material& in = input.model.materials[index];
  const std::string element = fmt::format("material {}", index);
  Material out;
  applyFactors(in, out);
  const auto& pbr = in.pbrMetallicRoughness;
  const auto slot = [](const auto& info) { return SlotSource{info.index, info.texCoord, info.extensions}; };
  struct Use {
    TextureSlot Material::*slot;
    SlotSource source;
    bool lit;  // only used when there is light
  };
  const std::array uses{Use{&Material::baseColor, slot(pbr.baseColorTexture), false},
                        Use{&Material::metallicRoughness, slot(pbr.metallicRoughnessTexture), true},
                        Use{&Material::normal, slot(in.normalTexture), true},
                        Use{&Material::occlusion, slot(in.occlusionTexture), true},
                        Use{&Material::emissive, slot(in.emissiveTexture), true}};
  for (const Use& use : uses) {
    // KHR_materials_unlit: the lit properties are there for those who do not know the extension.
    if (out.unlit && use.lit) continue;
    auto made = toSlot(input, element, use.source);
    if (!made) return tl::unexpected(made.error());
    out.*use.slot = *made;
  }
  if (out.unlit) out.emissiveFactor = glm::vec3(0.0f);
  if (!std::isfinite(out.emissiveFactor.x + out.emissiveFactor.y + out.emissiveFactor.z))
    return fail("{}: {}: emissiveFactor times emissiveStrength is infinite", input.file, element);
  return out;
}

}  // namespace

Result<void> buildMaterials(const GltfInput& input, Scene& scene) {
  for (std::size_t i = 0; i < input.model.materials.size(); ++i) {
    auto material = toMaterial(input, i);
    if (!material) return tl::unexpected(material.error());
    scene.materials.push_back(std::move(*material));
  }
  return {};
}

}  // namespace tessera
