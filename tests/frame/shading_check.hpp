// Holds every way of drawing a small scene against the reference tracer.
#pragma once

#include "atlas/rect/rect_atlas.hpp"
#include "tests/frame/reference.hpp"
#include "tests/frame/small_scenes.hpp"

namespace tessera::test {

inline constexpr int kWidth = 160;
inline constexpr int kHeight = 120;

struct Expected {
  // The least share of covered pixels where the reference must allow nothing but one colour, so that it says
  // something.
  double certain = 0.4;
  double certainInAtlas = 0.15;
  int reach = 0;          // half pixels around a centre, on top of the usual
  int shadowSize = 1024;  // texels a side
  AtlasFormat format = AtlasFormat::Srgb8;
  bool silhouettes = true;  // false: pixels beside nothing may have any colour
};

/// Draws the scene by forward, forward after a depth pre-pass, and both displays of the atlas, and expects
/// each to be within what `reference`, traced for the same view, allows.
void expectPictures(const Reference& reference, const Scene& scene, const Lighting& lighting,
                    const View& view, const Expected& expected = {});
/// Traces the reference, and expects the pictures to be as it is.
void expectReference(const Scene& scene, const Lighting& lighting, const View& view,
                     const Expected& expected = {});

LightSample directional(const glm::dvec3& along, const glm::vec3& lux);
LightSample point(const glm::dvec3& position, const glm::vec3& candela);
/// A rough dielectric.
Material dull(const glm::vec3& color);
/// A square wall in the plane z = 0, its front towards +z, 2 x 2 quads.
std::uint32_t addWall(Scene& scene, std::uint32_t material, const glm::vec3& corner = {-1, -1, 0},
                      float side = 2.0f);
/// Looks at the origin from (0.3, 0.2, z).
View wallView(double z = 3.0);
/// A use of the image without filtering, clamped.
TextureSlot nearest(std::uint32_t image);

/// A normal map of two tilts, in checkers, without filtering.
TextureSlot bumps(Scene& scene);

}  // namespace tessera::test
