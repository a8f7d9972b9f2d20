// Where compare looks: sampled views of a moving camera, and places with slanted triangles.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "apps/tessera/compare/crops.hpp"
#include "apps/tessera/compare/pictures.hpp"
#include "apps/tessera/compare/pvs.hpp"

namespace tessera::app {
namespace {

View someView() { return lookAt({1.0, 2.0, 3.0}, {4.0, 1.5, 2.0}, 60.0, 160, 90, 0.05); }

bool inPicture(const View& view, const glm::dvec3& direction) {
  const glm::dvec4 clip = viewProjection(view, view.eye) * glm::dvec4(direction, 1.0);
  return clip.w > 0.0 && std::abs(clip.x) <= clip.w * (1.0 + 1e-9) &&
         std::abs(clip.y) <= clip.w * (1.0 + 1e-9);
}

TEST(PvsViews, SeeWhatTheTurningCameraSees) {
  const View view = someView();
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  for (const double degrees : {0.0, 40.0, 80.0, 120.0, 180.0}) {
    const auto views = pvsViews(view, {0.0, degrees});
    const double range = degrees * std::numbers::pi / 180.0;
    // The middle of the camera's picture, turned to any side, up and down; and near its upper and lower edge.
    for (double yaw = -0.5 * range; yaw <= 0.5 * range + 1e-9; yaw += std::max(range / 16.0, 0.01))
      for (const double pitch : {-0.5 * range - 0.4 * view.fovY, -0.5 * range, -0.25 * range, 0.0,
                                 0.5 * range, 0.5 * range + 0.4 * view.fovY}) {
        const glm::dvec3 level = std::cos(yaw) * view.forward + std::sin(yaw) * right;
        const glm::dvec3 direction = std::cos(pitch) * level + std::sin(pitch) * view.up;
        EXPECT_TRUE(
            std::any_of(views.begin(), views.end(), [&](const View& v) { return inPicture(v, direction); }))
            << degrees << ": " << yaw << ", " << pitch;
      }
  }
}

TEST(PvsViews, AreFromABallAroundTheEye) {
  const View view = someView();
  EXPECT_EQ(pvsViews(view, {0.0, 0.0}).size(), 1u);
  const auto views = pvsViews(view, {0.25, 0.0});
  ASSERT_EQ(views.size(), 5u);
  glm::dvec3 sum(0.0);
  for (std::size_t i = 1; i < views.size(); ++i) {
    EXPECT_NEAR(glm::distance(views[i].eye, view.eye), 0.25, 1e-12);
    sum += views[i].eye - view.eye;
  }
  EXPECT_NEAR(glm::length(sum), 0.0, 1e-12) << "to all sides alike";
  for (const View& v : pvsViews(view, {0.25, 120.0})) {
    EXPECT_NEAR(glm::length(v.forward), 1.0, 1e-12);
    EXPECT_NEAR(glm::dot(v.forward, v.up), 0.0, 1e-12);
    EXPECT_EQ(v.width, view.width);
  }
}

/// 180 x 144 pixels of two triangles, not slanted.
SlantPicture plainPicture() {
  SlantPicture picture{180, 144, std::vector<std::uint32_t>(180 * 144, 4),
                       std::vector<float>(180 * 144, 0.0f)};
  return picture;
}

/// Stripes of `triangles` slanted triangles over 30 x 20 pixels.
void addStripes(SlantPicture& picture, int x, int y, std::uint32_t triangles, float excess) {
  for (int row = y; row < y + 20; ++row)
    for (int column = x; column < x + 30; ++column) {
      const auto at = static_cast<std::size_t>(row * picture.width + column);
      picture.ids[at] = 100 + static_cast<std::uint32_t>(column - x) % triangles;
      picture.excess[at] = excess;
    }
}

TEST(SlantedPlaces, AreWhereManyTrianglesAreMostSlanted) {
  SlantPicture picture = plainPicture();
  EXPECT_TRUE(slantedPlaces(picture, 3).empty());
  addStripes(picture, 10, 10, 10, 1.0f);
  addStripes(picture, 100, 100, 10, 3.0f);
  addStripes(picture, 100, 10, 1, 9.0f);  // one triangle, however slanted
  const auto places = slantedPlaces(picture, 3);
  ASSERT_EQ(places.size(), 2u) << "none next to another";
  EXPECT_EQ(places[0].width, 20);
  EXPECT_EQ(places[0].height, 16);
  EXPECT_GE(places[0].x, 100);
  EXPECT_LE(places[0].x + places[0].width, 130);
  EXPECT_GE(places[0].y, 100);
  EXPECT_LE(places[0].y + places[0].height, 120);
  EXPECT_DOUBLE_EQ(places[0].slantedShare, 1.0);
  EXPECT_LT(places[1].x, 40);
  EXPECT_LT(places[1].y, 30);
  EXPECT_EQ(slantedPlaces(picture, 1).size(), 1u);
}

TEST(SlantedPlaces, AreCutOutOfPictures) {
  Image image{3, 2, {}};
  for (std::uint8_t i = 0; i < 24; ++i) image.pixels.push_back(i);
  ReportCrop crop;
  crop.x = 1;
  crop.y = 1;
  crop.width = 2;
  crop.height = 1;
  EXPECT_EQ(cropped(image, crop).pixels, (std::vector<std::uint8_t>{16, 17, 18, 19, 20, 21, 22, 23}));
}

TEST(AtlasByKind, ShowsTheFullestPartInTheKindsColours) {
  constexpr int kWidth = 1024;
  constexpr int kHeight = 512;
  std::vector<std::uint8_t> kinds(kWidth * kHeight, 0);
  const auto fill = [&](int left, int top, int right, int bottom, std::uint8_t kind) {
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) kinds[static_cast<std::size_t>(y * kWidth + x)] = kind;
  };
  fill(0, 0, 512, 128, 1);
  fill(640, 256, 832, 352, 1);
  fill(832, 256, 1024, 352, 2);
  // More texels of one kind are less than two kinds; where half would be empty, a smaller part.
  const ReportCrop part = fullestPart(kWidth, kHeight, kinds, 768, 384);
  EXPECT_EQ(part.width, 384);
  EXPECT_EQ(part.height, 192);
  EXPECT_EQ(part.x, 640);
  EXPECT_LE(part.y, 256);
  EXPECT_GE(part.y + part.height, 352);
  Image atlas{kWidth, kHeight, std::vector<std::uint8_t>(4 * kinds.size(), 200)};
  const std::vector<GatherKind> names = {{"a", {0, 250, 0}, 0}, {"b", {0, 0, 250}, 0}};
  EXPECT_FALSE(colorByKind(atlas, {}, names));
  EXPECT_EQ(atlas.at(0, 0)[0], 200);
  ASSERT_TRUE(colorByKind(atlas, kinds, names));
  EXPECT_GT(atlas.at(0, 0)[1], 2 * atlas.at(0, 0)[0]);
  EXPECT_GT(atlas.at(1000, 300)[2], 2 * atlas.at(1000, 300)[0]);
  EXPECT_LT(atlas.at(700, 10)[1], 40) << "nothing there";
}

}  // namespace
}  // namespace tessera::app
