// A display behind a lens: what may be a lens, and the pass that draws a picture through one. Whoever draws
// pictures takes it: it knows no scene.
#pragma once

#include <glm/glm.hpp>

#include "engine/core/result.hpp"
#include "engine/gl/objects.hpp"
#include "engine/gl/program.hpp"

namespace tessera {

/// A radial lens that the picture is seen through; display draws the picture distorted the other way round.
/// Coordinates count from the picture's centre, 1 at its corners, so that no coordinate passes 1. The output
/// shows at radius d what the picture has at channelScale * d (1 + k1 d^2 + k2 d^4) / fill (Mueller 2021, eq.
/// 4.4), fill = (1 + k1 + k2) * the largest channelScale: a barrel lens fills the output, its corners showing
/// the picture's, and what lies outside the picture (k1, k2 below 0) is black with alpha 0.
struct Lens {
  double k1 = 0.22;  // [-10, 10]; d (1 + k1 d^2 + k2 d^4) must rise over all of 0..1
  double k2 = 0.24;  // [-10, 10]
  glm::dvec3 channelScale{0.996, 1.0, 1.014};  // red, green, blue: radius in the picture, [0.5, 2] each
};

/// Fails for a lens that folds, or with the number that is outside its range.
Result<void> check(const Lens& lens);
/// The undistorted radius that display puts at the output's corners.
double lensFill(const Lens& lens);

class LensPass {
 public:
  /// Fails where the program does not compile. The programs must outlive this.
  static Result<LensPass> create(gl::ProgramCache& programs);
  /// Writes to `encoded`, RGBA8 that holds display-encoded values, what `picture` of the same size shows
  /// through the lens, for which check() must hold. The picture is SRGB8_ALPHA8 with linear filters.
  void draw(const gl::Texture& picture, const gl::Texture& encoded, const Lens& lens) const;

 private:
  const gl::Program* program_ = nullptr;
};

}  // namespace tessera
