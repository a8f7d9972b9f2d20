// What a scene calls for. Only this decides which passes and shader permutations exist. No GL.
#pragma once

#include <string>
#include <vector>

#include "engine/scene/scene.hpp"
#include "engine/scene/stage.hpp"

namespace tessera {

/// An effect that the scene calls for, and what calls for it: {"shadows", "light 'sun' casts"}.
struct Effect {
  std::string name;
  std::string reason;
};

/// Everything the frame's plan depends on.
struct SceneFeatures {
  bool opaque = false;  // any OPAQUE or MASK geometry: what the atlas shades
  bool mask = false;
  bool blend = false;
  bool lights = false;
  bool shadows = false;
  bool hemisphere = false;
  bool animated = false;        // instance transforms change over time
  std::vector<Effect> effects;  // in a fixed order, each once
};

/// `stage` may be null. Only materials that instances use count.
SceneFeatures findFeatures(const Scene& scene, const Stage* stage);

/// Which code a material needs; impossible pairs are dropped (an unlit material has no normal map, no
/// lights).
struct Permutation {
  bool baseTexture = false;
  bool metallicRoughnessTexture = false;
  bool normalTexture = false;
  bool occlusionTexture = false;
  bool emissiveTexture = false;
  bool vertexColor = false;
  bool usesUv0 = false;
  bool usesUv1 = false;
  bool uvTransform = false;
  bool mask = false;
  bool blend = false;
  bool doubleSided = false;
  bool unlit = false;
  bool lights = false;
  bool shadows = false;
  bool hemisphere = false;
  auto operator<=>(const Permutation&) const = default;

  /// "NORMAL_TEX LIGHTS ...": the defines that are set, space-separated, in a fixed order.
  [[nodiscard]] std::string name() const;
  [[nodiscard]] std::vector<std::string> defines() const;
};

Permutation permutationOf(const Material& material, bool vertexColor, const SceneFeatures& features);
/// The few switches of Permutation that a depth-only pass needs: the alpha test and what it reads.
Permutation depthPermutationOf(const Material& material, bool vertexColor);

}  // namespace tessera
