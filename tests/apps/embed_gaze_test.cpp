#include <gtest/gtest.h>

#include "apps/embed/gaze.hpp"

namespace embed {
namespace {

// A framebuffer of 600 rows; the picture is 400 x 200, its lower left corner at (100, 50): from the top, rows
// 350 to 550.
constexpr Rectangle kPicture{100, 50, 400, 200};
constexpr int kRows = 600;

void expectGaze(const glm::dvec2& cursor, const glm::dvec2& place) {
  const glm::dvec2 gaze = gazeUnder(cursor, kPicture, kRows);
  EXPECT_DOUBLE_EQ(gaze.x, place.x) << cursor.x << ", " << cursor.y;
  EXPECT_DOUBLE_EQ(gaze.y, place.y) << cursor.x << ", " << cursor.y;
}

TEST(EmbedGaze, IsAShareOfThePictureFromItsTopLeft) {
  expectGaze({100, 350}, {0.0, 0.0});
  expectGaze({500, 550}, {1.0, 1.0});
  expectGaze({300, 450}, {0.5, 0.5});
  expectGaze({200, 360}, {0.25, 0.05});
}

TEST(EmbedGaze, BesideThePictureIsAtItsEdge) {
  expectGaze({0, 0}, {0.0, 0.0});
  expectGaze({800, 450}, {1.0, 0.5});
  expectGaze({300, 1e9}, {0.5, 1.0});
}

}  // namespace
}  // namespace embed
