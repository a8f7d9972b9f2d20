#include "engine/view/camera.hpp"

#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

namespace tessera::view {

namespace {

constexpr double kSteepest = 1.55;  // radians, short of a quarter turn: there right would be undefined

glm::dvec4 turnOf(const glm::dmat3& axes) {
  const glm::dquat q = glm::normalize(glm::quat_cast(axes));
  return {q.x, q.y, q.z, q.w};
}

}  // namespace

wire::Camera lookAt(const glm::dvec3& eye, const glm::dvec3& target, double fovY, std::uint32_t width,
                    std::uint32_t height, double zNear) {
  const glm::dvec3 towards = target - eye;
  const double distance = glm::length(towards);
  const glm::dvec3 forward = distance > 0.0 ? towards / distance : glm::dvec3(0.0, 0.0, -1.0);
  const glm::dvec3 hint =
      std::abs(forward.y) > 0.9999 ? glm::dvec3(0.0, 0.0, -1.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, hint));
  wire::Camera camera;
  camera.eye = eye;
  camera.orientation = turnOf(glm::dmat3(right, glm::cross(right, forward), -forward));
  const double up = std::tan(glm::radians(fovY) / 2.0);
  const double across = up * width / height;
  camera.slopes = {-across, across, -up, up};
  camera.zNear = zNear;
  camera.width = width;
  camera.height = height;
  return camera;
}

glm::dmat3 axesOf(const wire::Camera& camera) {
  const glm::dvec4& o = camera.orientation;
  return glm::mat3_cast(glm::normalize(glm::dquat(o.w, o.x, o.y, o.z)));
}

glm::dmat4 viewProjection(const wire::Camera& camera) {
  const double left = camera.slopes.x;
  const double right = camera.slopes.y;
  const double bottom = camera.slopes.z;
  const double top = camera.slopes.w;
  glm::dmat4 projection(0.0);
  projection[0][0] = 2.0 / (right - left);
  projection[1][1] = 2.0 / (top - bottom);
  projection[2][0] = (right + left) / (right - left);
  projection[2][1] = (top + bottom) / (top - bottom);
  projection[2][3] = -1.0;
  projection[3][2] = camera.zNear;
  return projection * glm::dmat4(glm::transpose(axesOf(camera)));
}

wire::Camera resized(const wire::Camera& camera, std::uint32_t width, std::uint32_t height) {
  wire::Camera other = camera;
  const double share = (double(width) / height) / (double(camera.width) / camera.height);
  other.slopes.x *= share;
  other.slopes.y *= share;
  other.width = width;
  other.height = height;
  return other;
}

wire::Camera askable(const wire::Camera& camera) {
  const double pixel = 2.0 * camera.slopes[3] / camera.height;  // at distance 1
  const auto reached = [&](std::uint32_t side) {
    return std::clamp(0.5 * pixel * side, 1.001 * wire::kLeastSlope, 0.999 * wire::kMostSlope);
  };
  const double across = reached(camera.width);
  const double up = reached(camera.height);
  const double width = 2.0 * across / pixel;
  const double height = 2.0 * up / pixel;
  const double fewer = std::min({1.0, wire::kMostViewSide / std::max(width, height),
                                 std::sqrt(0.99 * wire::kMostViewPixels / (width * height))});
  wire::Camera asked = camera;
  const auto side = [&](double pixels) {
    return std::clamp(static_cast<std::uint32_t>(std::ceil(fewer * pixels - 1e-6)), 1u, wire::kMostViewSide);
  };
  if (fewer == 1.0 && across == camera.slopes[1] && up == camera.slopes[3]) return asked;
  asked.width = side(width);
  asked.height = side(height);
  // Whole pixels again: as large as they were, or as they became.
  const double half = 0.5 * pixel / fewer;
  asked.slopes = {-half * asked.width, half * asked.width, -half * asked.height, half * asked.height};
  return asked;
}

wire::Camera eyeOf(const wire::Camera& camera, double eyeDistance, int side) {
  wire::Camera eye = camera;
  eye.eye += axesOf(camera)[0] * (0.5 * eyeDistance * side);
  return eye;
}

void FlyCamera::set(const wire::Camera& camera) {
  base_ = camera;
  const glm::dvec3 forward = -axesOf(camera)[2];
  yaw_ = std::atan2(-forward.x, -forward.z);
  pitch_ = std::clamp(std::asin(std::clamp(forward.y, -1.0, 1.0)), -kSteepest, kSteepest);
}

void FlyCamera::turn(double right, double up) {
  yaw_ -= right;
  pitch_ = std::clamp(pitch_ + up, -kSteepest, kSteepest);
}

void FlyCamera::move(const glm::dvec3& along) {
  const glm::dmat3 axes = axesOf(camera());
  base_.eye += axes[0] * along.x + axes[1] * along.y - axes[2] * along.z;
}

wire::Camera FlyCamera::camera() const {
  wire::Camera camera = base_;
  const glm::dquat turn =
      glm::angleAxis(yaw_, glm::dvec3(0.0, 1.0, 0.0)) * glm::angleAxis(pitch_, glm::dvec3(1.0, 0.0, 0.0));
  camera.orientation = {turn.x, turn.y, turn.z, turn.w};
  return camera;
}

}  // namespace tessera::view
