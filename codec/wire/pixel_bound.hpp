// How finely positions must be sent so that nothing moves visibly.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "codec/wire/geometry.hpp"

namespace tessera::wire {

/// Positions are whole multiples of 2^level in their object's space.
inline constexpr int kFinestLevel = -60;
inline constexpr int kCoarsestLevel = 40;
/// Multiples are smaller than this, so that they are floats to the bit.
inline constexpr std::int32_t kMostSteps = 1 << 23;

/// What a displacement of the surface may do to a picture. A point at distance D from the eye, off the view
/// axis by an angle t, moves by at most f e / (D cos^2 t) pixels when it moves by e, f the picture's pixels
/// per unit of slope: its projection is f X / Z, whose gradient has length f / Z * sqrt(1 + (X / Z)^2), and Z
/// = D cos t. Rounding to a grid of step s moves a corner by at most s sqrt(3) / 2, and any point of a
/// triangle by no more than its corners.
struct PixelBound {
  double pixels = 0.1;        // what a point may move by, > 0
  double focal = 640.0;       // f
  double widestSlope2 = 2.0;  // tan^2 t in the picture's farthest corner
  double nearest = 0.05;      // no point nearer than this is seen: the near plane
  double reach = 0.0;         // how far from the given eye the picture may be taken

  /// The largest level whose grid keeps the bound for points at `distance` from the given eye and beyond, in
  /// a space that transforms stretch by at most `scale`.
  [[nodiscard]] int level(double distance, double scale) const;
};

/// For pictures of this camera, and of others of its size at `reach` from it, however they are turned.
PixelBound boundOf(const Camera& camera, double pixels, double reach);

/// Raised to the level at which the largest coordinate has fewer than kMostSteps, where it must be.
int levelFor(const glm::vec3& position, int level);
/// The nearest point of the grid.
glm::ivec3 stepsOf(const glm::vec3& position, int level);
glm::vec3 positionOf(const glm::ivec3& steps, int level);

/// Distance from the origin to the triangle a, b, c, never overestimated by more than rounding (Ericson 2005,
/// sec. 5.1.5); a triangle without area is a line or a point.
double distanceToTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);
/// The largest factor by which a transform lengthens, or more: exact where its columns are orthogonal (a
/// rotation after scales), else up to sqrt(3) times that (the root of Gershgorin's bound on the eigenvalues
/// of the linear part's square).
double stretchOf(const glm::dmat4x3& world);

}  // namespace tessera::wire
