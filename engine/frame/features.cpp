#include "engine/frame/features.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace tessera {

namespace {

void note(SceneFeatures& features, const char* name, const std::string& reason) {
  const bool known = std::any_of(features.effects.begin(), features.effects.end(),
                                 [&](const Effect& e) { return e.name == name; });
  if (!known) features.effects.push_back({name, reason});
}

std::string quoted(const char* kind, const std::string& name, std::size_t index) {
  return name.empty() ? fmt::format("{} {}", kind, index) : fmt::format("{} '{}'", kind, name);
}

void noteMaterial(SceneFeatures& features, const Material& material, std::size_t index) {
  const std::string reason = quoted("material", material.name, index);
  switch (material.alphaMode) {
    case AlphaMode::Opaque:
      break;
    case AlphaMode::Mask:
      features.mask = true;
      note(features, "alpha-mask", reason);
      break;
    case AlphaMode::Blend:
      features.blend = true;
      note(features, "alpha-blend", reason);
      break;
  }
  if (material.alphaMode != AlphaMode::Blend) features.opaque = true;
  if (material.doubleSided) note(features, "double-sided", reason);
  if (material.unlit) {
    note(features, "unlit", reason);
    return;
  }
  if (material.normal.used()) note(features, "normal-map", reason);
  if (material.occlusion.used()) note(features, "occlusion-map", reason);
  if (material.emissiveFactor != glm::vec3(0.0f)) note(features, "emissive", reason);
}

}  // namespace

SceneFeatures findFeatures(const Scene& scene, const Stage* stage) {
  SceneFeatures features;
  std::vector<bool> used(scene.materials.size(), false);
  for (const Instance& instance : scene.instances) used[scene.primitives[instance.primitive].material] = true;
  bool anyLit = false;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    noteMaterial(features, scene.materials[i], i);
    anyLit = anyLit || !scene.materials[i].unlit;
  }
  // Lights shine on lit materials only; without any, neither light nor shadow code exists.
  if (anyLit) {
    auto add = [&](bool casts, const std::string& reason) {
      features.lights = true;
      note(features, "punctual-lights", reason);
      if (!casts) return;
      features.shadows = true;
      note(features, "shadows", reason + " casts");
    };
    if (stage == nullptr || stage->sceneLights) {
      for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
        const std::uint32_t index = scene.nodes[i].light;
        if (index == kNone) continue;
        const Light& light = scene.lights[index];
        add(light.castsShadow || (stage != nullptr && stage->sceneLightsCastShadows),
            quoted("light", light.name, index) + " on " + quoted("node", scene.nodes[i].name, i));
      }
    }
    if (stage != nullptr)
      for (std::size_t i = 0; i < stage->lights.size(); ++i)
        add(stage->lights[i].light.castsShadow, "stage " + quoted("light", stage->lights[i].light.name, i));
    if (stage != nullptr && stage->ambient && stage->ambient->hemisphere()) {
      features.hemisphere = true;
      note(features, "hemisphere-ambient", stage->file);
    }
  }
  if (scene.animated()) {
    features.animated = true;
    std::string reason = "animation";
    for (std::size_t i = 0; i < scene.animations.size(); ++i)
      if (!scene.animations[i].channels.empty()) {
        const std::uint32_t node = scene.animations[i].channels.front().node;
        reason = quoted("animation", scene.animations[i].name, i) + " moves " +
                 quoted("node", scene.nodes[node].name, node);
        break;
      }
    note(features, "animation", reason);
  }
  return features;
}

std::vector<std::string> Permutation::defines() const {
  const std::array<std::pair<bool, const char*>, 16> table = {{{baseTexture, "BASE_TEX"},
                                                               {metallicRoughnessTexture, "MR_TEX"},
                                                               {normalTexture, "NORMAL_TEX"},
                                                               {occlusionTexture, "OCCLUSION_TEX"},
                                                               {emissiveTexture, "EMISSIVE_TEX"},
                                                               {vertexColor, "VERTEX_COLOR"},
                                                               {usesUv0, "USES_UV0"},
                                                               {usesUv1, "USES_UV1"},
                                                               {uvTransform, "UV_TRANSFORM"},
                                                               {mask, "MASK"},
                                                               {blend, "BLEND"},
                                                               {doubleSided, "DOUBLE_SIDED"},
                                                               {unlit, "UNLIT"},
                                                               {lights, "LIGHTS"},
                                                               {shadows, "SHADOWS"},
                                                               {hemisphere, "HEMISPHERE"}}};
  std::vector<std::string> names;
  for (const auto& [set, name] : table)
    if (set) names.emplace_back(name);
  return names;
}

std::string Permutation::name() const {
  std::string text;
  for (const std::string& define : defines()) text += (text.empty() ? "" : " ") + define;
  return text.empty() ? "plain" : text;
}

Permutation permutationOf(const Material& material, bool vertexColor, const SceneFeatures& features) {
  Permutation p;
  p.vertexColor = vertexColor;
  p.mask = material.alphaMode == AlphaMode::Mask;
  p.blend = material.alphaMode == AlphaMode::Blend;
  p.unlit = material.unlit;
  p.baseTexture = material.baseColor.used();
  if (!material.unlit) {
    p.doubleSided = material.doubleSided;
    p.metallicRoughnessTexture = material.metallicRoughness.used();
    p.normalTexture = material.normal.used();
    p.occlusionTexture = material.occlusion.used();
    p.emissiveTexture = material.emissive.used() && material.emissiveFactor != glm::vec3(0.0f);
    p.lights = features.lights;
    p.shadows = features.shadows;
    p.hemisphere = features.hemisphere;
  }
  const std::array<std::pair<bool, const TextureSlot*>, 5> slots = {
      {{p.baseTexture, &material.baseColor},
       {p.metallicRoughnessTexture, &material.metallicRoughness},
       {p.normalTexture, &material.normal},
       {p.occlusionTexture, &material.occlusion},
       {p.emissiveTexture, &material.emissive}}};
  for (const auto& [read, slot] : slots) {
    if (!read) continue;
    (slot->uvSet == 0 ? p.usesUv0 : p.usesUv1) = true;
    p.uvTransform = p.uvTransform || slot->hasTransform;
  }
  return p;
}

Permutation depthPermutationOf(const Material& material, bool vertexColor) {
  Permutation p;
  p.mask = material.alphaMode == AlphaMode::Mask;
  if (!p.mask) return p;
  p.vertexColor = vertexColor;
  p.baseTexture = material.baseColor.used();
  p.usesUv1 = p.baseTexture && material.baseColor.uvSet == 1;
  return p;
}

}  // namespace tessera
