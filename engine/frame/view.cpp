#include "engine/frame/view.hpp"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_access.hpp>

namespace tessera {

namespace {

glm::dmat4 rotationOf(const View& view) {
  const glm::dvec3 right = glm::normalize(glm::cross(view.forward, view.up));
  const glm::dvec3 up = glm::cross(right, view.forward);
  return glm::transpose(glm::dmat4(glm::dvec4(right, 0.0), glm::dvec4(up, 0.0),
                                   glm::dvec4(-view.forward, 0.0), glm::dvec4(0.0, 0.0, 0.0, 1.0)));
}

double aspectOf(const View& view) {
  return static_cast<double>(view.width) / static_cast<double>(view.height);
}

}  // namespace

View lookAt(const glm::dvec3& eye, const glm::dvec3& target, double fovYDegrees, int width, int height,
            double zNear) {
  View view;
  view.eye = eye;
  const glm::dvec3 towards = target - eye;
  const double distance = glm::length(towards);
  view.forward = distance > 0.0 ? towards / distance : glm::dvec3(0.0, 0.0, -1.0);
  const glm::dvec3 hint =
      std::abs(view.forward.y) > 0.9999 ? glm::dvec3(0.0, 0.0, -1.0) : glm::dvec3(0.0, 1.0, 0.0);
  view.up = glm::normalize(glm::cross(glm::cross(view.forward, hint), view.forward));
  view.fovY = glm::radians(fovYDegrees);
  view.zNear = zNear;
  view.width = width;
  view.height = height;
  return view;
}

View viewOf(const CameraKey& key, int width, int height, double zNear) {
  return lookAt(key.eye, key.target, key.fovY, width, height, zNear);
}

View viewOf(const Scene& scene, const SceneState& state, std::size_t index, int width, int height,
            double zNear) {
  const Camera& camera = scene.cameras[index];
  glm::dmat4 world(1.0);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (scene.nodes[i].camera == index) world = state.world[i];
  View view;
  view.eye = glm::dvec3(world[3]);
  const glm::dvec3 back(world[2]);
  const glm::dvec3 up(world[1]);
  if (glm::length(back) > 0.0) view.forward = -glm::normalize(back);
  const glm::dvec3 side = glm::cross(view.forward, up);
  view.up =
      glm::length(side) > 0.0 ? glm::normalize(glm::cross(side, view.forward)) : glm::dvec3(0.0, 1.0, 0.0);
  view.width = width;
  view.height = height;
  view.zNear = zNear;
  if (camera.perspective) {
    view.fovY = camera.fovY;
    view.zNear = camera.zNear > 0.0 ? camera.zNear : zNear;
  } else {
    constexpr double kNarrow =
        0.05;  // radians: nearly parallel rays, with the same height at the scene's distance
    view.fovY = kNarrow;
    view.eye -= view.forward * (camera.yMag / std::tan(kNarrow * 0.5));
  }
  return view;
}

std::array<View, 2> stereoViews(const View& centre, double eyeDistance) {
  const glm::dvec3 right = glm::normalize(glm::cross(centre.forward, centre.up));
  std::array<View, 2> eyes = {centre, centre};
  eyes[0].eye -= right * (0.5 * eyeDistance);
  eyes[1].eye += right * (0.5 * eyeDistance);
  return eyes;
}

View autoView(const Scene& scene, int width, int height) {
  constexpr double kFovY = 45.0;
  constexpr double kMargin = 1.05;
  const glm::dvec3 centre = scene.bounds.centre();
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.35, 0.3, 1.0));
  const View towards = lookAt(centre + direction, centre, kFovY, width, height, defaultNear(scene));
  const double tanY = std::tan(towards.fovY * 0.5);
  const double tanX = tanY * aspectOf(towards);
  const glm::dvec3 right = glm::cross(towards.forward, towards.up);
  // The nearest eye along the direction from which all corners of the bounds are inside the frustum.
  double distance = 1e-6;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p((corner & 1) != 0 ? scene.bounds.max.x : scene.bounds.min.x,
                       (corner & 2) != 0 ? scene.bounds.max.y : scene.bounds.min.y,
                       (corner & 4) != 0 ? scene.bounds.max.z : scene.bounds.min.z);
    const glm::dvec3 d = p - centre;
    const double depth = glm::dot(d, towards.forward);
    distance = std::max({distance, std::abs(glm::dot(d, right)) / tanX - depth,
                         std::abs(glm::dot(d, towards.up)) / tanY - depth});
  }
  return lookAt(centre + direction * (distance * kMargin), centre, kFovY, width, height, defaultNear(scene));
}

double defaultNear(const Scene& scene) { return std::clamp(scene.bounds.diagonal() * 1e-3, 1e-6, 0.05); }

glm::dmat4 viewProjection(const View& view, const glm::dvec3& anchor) {
  const double f = 1.0 / std::tan(view.fovY * 0.5);
  glm::dmat4 projection(0.0);
  projection[0][0] = f / aspectOf(view);
  projection[1][1] = f;
  projection[2][3] = -1.0;
  projection[3][2] = view.zNear;
  const glm::dmat4 rotation = rotationOf(view);
  glm::dmat4 translation(1.0);
  translation[3] = glm::dvec4(anchor - view.eye, 1.0);
  return projection * rotation * translation;
}

glsl::ViewGpu viewGpu(const View& view, const glm::dvec3& anchor, bool reversed) {
  glsl::ViewGpu gpu;
  glm::dmat4 toClip = viewProjection(view, anchor);
  if (!reversed) toClip = glm::row(toClip, 2, glm::row(toClip, 3) - glm::row(toClip, 2));
  gpu.viewProjection = glm::mat4(toClip);
  gpu.eye = glm::vec4(glm::vec3(view.eye - anchor), static_cast<float>(view.pixelsPerRadian()));
  return gpu;
}

glsl::DensityGpu densityGpu(const View& view, const PlaceOptions& options) {
  glsl::DensityGpu gpu{};
  gpu.axis = glm::vec4(glm::vec3(view.forward), 0.0f);
  if (options.foveation) {
    const Foveation& f = *options.foveation;
    gpu.gaze = glm::vec4(glm::vec3(gazeDirection(view, f.gaze)), 0.0f);
    gpu.acuity = glm::vec4(static_cast<float>(f.slope), static_cast<float>(f.smallest),
                           glsl::degreesPerCycle(static_cast<float>(view.pixelsPerRadian())), 0.0f);
  }
  if (options.lens) {
    // Radii of a flat picture are tangents. The picture's corner has the undistorted radius 1 + k1 + k2 in
    // the channel that fills the output.
    const Lens& lens = *options.lens;
    const double corner = std::tan(view.fovY * 0.5) * std::hypot(1.0, aspectOf(view));
    const double least = std::min({lens.channelScale.x, lens.channelScale.y, lens.channelScale.z});
    gpu.lens = glm::vec4(lens.k1, lens.k2, (1.0 + lens.k1 + lens.k2) / corner, lensFill(lens) / least);
  }
  return gpu;
}

glm::dvec3 gazeDirection(const View& view, const glm::dvec2& place) {
  return glm::normalize(pixelToRay(view) *
                        glm::dvec3(1.0, place.x * view.width, (1.0 - place.y) * view.height));
}

glm::dmat3 pixelToRay(const View& view) {
  const double tanY = std::tan(view.fovY * 0.5);
  const double tanX = tanY * aspectOf(view);
  const glm::dvec3 right = glm::normalize(glm::cross(view.forward, view.up));
  const glm::dvec3 up = glm::cross(right, view.forward);
  return {view.forward - right * tanX - up * tanY, right * (2.0 * tanX / view.width),
          up * (2.0 * tanY / view.height)};
}

Frustum frustumOf(const glm::dmat4& m) {
  const glm::dvec4 x = glm::row(m, 0);
  const glm::dvec4 y = glm::row(m, 1);
  const glm::dvec4 z = glm::row(m, 2);
  const glm::dvec4 w = glm::row(m, 3);
  Frustum frustum;
  for (const glm::dvec4& plane : {w + x, w - x, w + y, w - y, z, w - z}) {
    // The far plane of an infinite projection has no direction: it cuts nothing.
    if (glm::length(glm::dvec3(plane)) > 0.0)
      frustum.planes[static_cast<std::size_t>(frustum.count++)] = plane;
  }
  return frustum;
}

bool Frustum::touches(const Box& box) const {
  if (box.empty()) return false;
  for (int i = 0; i < count; ++i) {
    const glm::dvec4& plane = planes[static_cast<std::size_t>(i)];
    const glm::dvec3 farthest(plane.x >= 0.0 ? box.max.x : box.min.x, plane.y >= 0.0 ? box.max.y : box.min.y,
                              plane.z >= 0.0 ? box.max.z : box.min.z);
    if (glm::dot(glm::dvec3(plane), farthest) + plane.w < 0.0) return false;
  }
  return true;
}

}  // namespace tessera
