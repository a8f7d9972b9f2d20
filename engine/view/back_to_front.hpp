// The blended triangles of a shaded frame in the order in which they are drawn. No GL.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "engine/view/shaded_frame.hpp"

namespace tessera::view {

class BackToFront {
 public:
  /// Finds a frame's blended triangles, in place of an earlier frame's.
  void take(const ShadedFrame& frame);
  [[nodiscard]] bool empty() const { return triangles_.empty(); }
  /// Three corners (3 t, 3 t + 1, 3 t + 2 of triangle t) for each blended triangle, by the depth of its
  /// centroid, farthest first. Triangles that cross each other, and large ones close together, may have no
  /// right order. Until the next call.
  const std::vector<std::uint32_t>& sorted(const wire::Camera& camera);

 private:
  struct Triangle {
    std::uint32_t number = 0;
    std::uint32_t object = 0;
    glm::vec3 centroid{0.0f};  // in its object's space
  };
  std::vector<Triangle> triangles_;
  std::vector<wire::ObjectTransform> objects_;
  std::vector<std::pair<double, std::uint32_t>> order_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace tessera::view
