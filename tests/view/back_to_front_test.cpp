#include "engine/view/back_to_front.hpp"

#include <gtest/gtest.h>

#include "engine/view/camera.hpp"

namespace tessera {
namespace {

using Corners = std::vector<std::uint32_t>;

/// Triangles at z = 0, -1, -2 ... of which the odd ones are blended; the last is of an object of its own.
view::ShadedFrame rowOfTriangles(std::uint32_t count) {
  view::ShadedFrame frame;
  frame.objects.resize(2);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t object = i + 1 == count ? 1 : 0;
    const float z = -static_cast<float>(i);
    for (const glm::vec2 at : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(0, 1)})
      frame.vertices.push_back({at.x, at.y, z, object});
    frame.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2, glsl::packOwner(i, 0, false, false)});
    frame.patches.push_back({0, 0, i % 2 == 1 ? glsl::kStyleTransparent | 128u << 8u : 0u, 0});
  }
  return frame;
}

TEST(BackToFront, FollowsTheCameraAndTheObjects) {
  view::ShadedFrame frame = rowOfTriangles(6);  // 1, 3 and 5 are blended
  view::BackToFront order;
  EXPECT_TRUE(order.empty());
  order.take(frame);
  const wire::Camera front = view::lookAt({0, 0, 5}, {0, 0, 0}, 60.0, 64, 48, 0.1);
  const wire::Camera behind = view::lookAt({0, 0, -20}, {0, 0, 0}, 60.0, 64, 48, 0.1);
  EXPECT_EQ(order.sorted(front), (Corners{15, 16, 17, 9, 10, 11, 3, 4, 5}));
  EXPECT_EQ(order.sorted(behind), (Corners{3, 4, 5, 9, 10, 11, 15, 16, 17}));
  // The last one's object comes to the front.
  frame.objects[1].world[3] = {0, 0, 5.5};
  order.take(frame);
  EXPECT_EQ(order.sorted(front), (Corners{9, 10, 11, 3, 4, 5, 15, 16, 17}));
}

TEST(BackToFront, LeavesOutWhatIsFree) {
  view::ShadedFrame frame = rowOfTriangles(4);
  frame.triangles[1] = {0, 0, 0, glsl::kNoOwner};
  view::BackToFront order;
  order.take(frame);
  EXPECT_EQ(order.sorted(view::lookAt({0, 0, 5}, {0, 0, 0}, 60.0, 64, 48, 0.1)), (Corners{9, 10, 11}));
  frame.patches[3].style = 0;
  order.take(frame);
  EXPECT_TRUE(order.empty());
}

}  // namespace
}  // namespace tessera
