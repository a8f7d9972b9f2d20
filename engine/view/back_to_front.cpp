#include "engine/view/back_to_front.hpp"

#include <algorithm>

#include "engine/view/camera.hpp"

namespace tessera::view {

void BackToFront::take(const ShadedFrame& frame) {
  triangles_.clear();
  objects_ = frame.objects;
  const bool tess = frame.method == wire::Method::Tess;
  for (std::uint32_t i = 0; i < frame.triangles.size(); ++i) {
    const glsl::StreamedTriangle& t = frame.triangles[i];
    if (t.owner == glsl::kNoOwner) continue;
    const std::uint32_t element = glsl::ownerElement(t.owner);
    const std::uint32_t style = tess ? frame.tess[element].style : frame.patches[element].style;
    if ((style & glsl::kStyleTransparent) == 0) continue;
    glm::vec3 sum(0.0f);
    for (const std::uint32_t corner : {t.v0, t.v1, t.v2}) {
      const glsl::StreamedVertex& v = frame.vertices[corner];
      sum += glm::vec3(v.x, v.y, v.z);
    }
    triangles_.push_back({i, frame.vertices[t.v0].object, sum / 3.0f});
  }
}

const std::vector<std::uint32_t>& BackToFront::sorted(const wire::Camera& camera) {
  const glm::dvec3 forward = -axesOf(camera)[2];
  order_.clear();
  for (const Triangle& triangle : triangles_) {
    const glm::dvec3 at = objects_[triangle.object].world * glm::dvec4(triangle.centroid, 1.0);
    order_.emplace_back(-glm::dot(at - camera.eye, forward), triangle.number);
  }
  std::sort(order_.begin(), order_.end());
  corners_.clear();
  for (const auto& [depth, triangle] : order_)
    for (std::uint32_t corner = 0; corner < 3; ++corner) corners_.push_back(3 * triangle + corner);
  return corners_;
}

}  // namespace tessera::view
