// A viewer's camera: wire::Camera as matrices, and what moves it.
#pragma once

#include <glm/glm.hpp>

#include "codec/wire/geometry.hpp"

namespace tessera::view {

/// A symmetric perspective camera that looks from `eye` at `target`; +y is up, or -z when it looks straight
/// up or down. `fovY` in degrees, (0, 180); sides of the picture in pixels, at least 1.
wire::Camera lookAt(const glm::dvec3& eye, const glm::dvec3& target, double fovY, std::uint32_t width,
                    std::uint32_t height, double zNear);

/// Columns: right, up and back, unit vectors in the world.
glm::dmat3 axesOf(const wire::Camera& camera);

/// To clip space from world positions relative to the eye; depth 1 at the near plane and 0 at infinity.
glm::dmat4 viewProjection(const wire::Camera& camera);

/// The same camera for a picture of another size: the height's angle stays, the width's follows.
wire::Camera resized(const wire::Camera& camera, std::uint32_t width, std::uint32_t height);

/// What a server may be asked for in its place: sides, pixels and slopes within wire's bounds, cut at the
/// edges where the picture is too wide, and with fewer pixels where it has too many. Slopes are of square
/// pixels.
wire::Camera askable(const wire::Camera& camera);

/// Two parallel eyes, each half of `eyeDistance` from the camera along its right. `side`: -1 left, 1 right.
wire::Camera eyeOf(const wire::Camera& camera, double eyeDistance, int side);

/// Flies: turned by a mouse, moved along its own axes. Never rolls.
class FlyCamera {
 public:
  /// Takes place, direction and edges; a roll is lost.
  void set(const wire::Camera& camera);
  /// Radians to the right and up; up and down stop just short of the vertical.
  void turn(double right, double up);
  /// Distances along right, up and the view direction.
  void move(const glm::dvec3& along);
  [[nodiscard]] wire::Camera camera() const;

 private:
  wire::Camera base_;
  double yaw_ = 0.0;    // radians, to the left of -z
  double pitch_ = 0.0;  // radians, up
};

}  // namespace tessera::view
