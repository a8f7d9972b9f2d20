// Image warping: against forward's pictures of the same scenes, and against projections worked out on the
// CPU.
#include "engine/frame/image_warp.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/frame/engine.hpp"
#include "engine/measure/metrics.hpp"
#include "tests/frame/pictures.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 180;
constexpr std::array<Warp, 3> kWarps = {Warp::Time, Warp::Mesh, Warp::Iterative};
constexpr std::array<Warp, 2> kWithDepth = {Warp::Mesh, Warp::Iterative};

/// A target that pictures are warped into and read from.
struct Target {
  Target(int width, int height)
      : color(GL_RGBA8, width, height), depth(GL_DEPTH_COMPONENT32F, width, height) {
    const std::array<const gl::Texture*, 1> colors = {&color};
    framebuffer = gl::Framebuffer(colors, &depth);
  }
  [[nodiscard]] Image read() const {
    return flipped(color.width(), color.height(), gl::readTexture(color, GL_RGBA, GL_UNSIGNED_BYTE, 4));
  }
  gl::Texture color, depth;
  gl::Framebuffer framebuffer;
};

class ImageWarpTest : public test::GlTest {
 protected:
  void SetUp() override {
    test::GlTest::SetUp();
    programs_.emplace(test::context());
    auto made = ImageWarp::create(*programs_, kWarps);
    ASSERT_TRUE(made) << made.error().message;
    warp_ = std::move(*made);
  }
  Image warped(Warp warp, const WarpSource& source, const View& to, const WarpOptions& options = {}) {
    Target target(to.width, to.height);
    const auto drawn = warp_.draw(warp, source, to, target.framebuffer, glm::vec4(0.0f), options);
    EXPECT_TRUE(drawn) << drawn.error().message;
    return target.read();
  }
  std::string refusal(Warp warp, const WarpSource& source, const View& to, const WarpOptions& options = {}) {
    Target target(16, 16);
    const auto drawn = warp_.draw(warp, source, to, target.framebuffer, glm::vec4(0.0f), options);
    return drawn ? "" : drawn.error().message;
  }

 private:
  std::optional<gl::ProgramCache> programs_;
  ImageWarp warp_;
};

std::unique_ptr<Engine> make(Scene scene) {
  EngineOptions options;
  options.request = {.rect = false, .forward = true};
  options.splitEdges = 0.0;
  auto engine = Engine::create(test::context(), std::move(scene), {}, options);
  if (!engine) {
    ADD_FAILURE() << engine.error().message;
    return nullptr;
  }
  (*engine)->update(0.0);
  return std::move(*engine);
}

View ahead(const glm::dvec3& eye = {0, 0, 0}, const glm::dvec3& towards = {0, 0, -1}) {
  return lookAt(eye, eye + towards, 60.0, kWidth, kHeight, 0.05);
}

/// A wall at 4 m, coloured linearly, and before it at 1 m a red board.
Scene boardBeforeWall(bool board) {
  Scene scene = test::emptyScene();
  const auto plain = test::addMaterial(scene, test::unlit());
  Material red = test::unlit();
  red.baseColorFactor = {1, 0, 0, 1};
  const auto front = test::addMaterial(scene, red);
  test::place(scene, test::addGrid(scene, {-8, -6, -4}, {16, 0, 0}, {0, 12, 0}, 8, 8, plain, true));
  if (board)
    test::place(scene, test::addGrid(scene, {-0.2f, -0.2f, -1}, {0.4f, 0, 0}, {0, 0.4f, 0}, 1, 1, front));
  test::finish(scene);
  return scene;
}

int largestInside(const Image& a, const Image& b, int border) {
  int largest = 0;
  for (int y = border; y < a.height - border; ++y)
    for (int x = border; x < a.width - border; ++x)
      for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
  return largest;
}

TEST_F(ImageWarpTest, TheSameViewIsTheIdentity) {
  auto engine = make(test::cornerScene());
  ASSERT_TRUE(engine);
  const View view = lookAt({4.5, 2.2, 1.5}, {1.5, 0.9, -2.0}, 60.0, kWidth, kHeight, 0.05);
  engine->forward(view);
  const Image before = engine->readColor();
  for (const Warp warp : kWarps) {
    Image after = warped(warp, engine->warpSource(view), view);
    // Alpha is that of pictures, not of coverage: where nothing is the background was cleared.
    EXPECT_LE(test::largestDifference(before, after), 1) << static_cast<int>(warp);
  }
}

/// Bytes of a picture between its pixels; (0.5, 0.5) is the middle of the first, rows from the top.
glm::dvec3 between(const Image& image, glm::dvec2 at) {
  at = glm::clamp(at - 0.5, glm::dvec2(0.0), glm::dvec2(image.width - 1, image.height - 1));
  const int x = std::min(static_cast<int>(at.x), image.width - 2);
  const int y = std::min(static_cast<int>(at.y), image.height - 2);
  const glm::dvec2 part = at - glm::dvec2(x, y);
  const auto bytes = [&](int dx, int dy) {
    const std::uint8_t* p = image.at(x + dx, y + dy);
    return glm::dvec3(p[0], p[1], p[2]);
  };
  return glm::mix(glm::mix(bytes(0, 0), bytes(1, 0), part.x), glm::mix(bytes(0, 1), bytes(1, 1), part.x),
                  part.y);
}

TEST_F(ImageWarpTest, TurningIsWhatAngleAndTangentSay) {
  auto engine = make(test::cornerScene());
  ASSERT_TRUE(engine);
  const double turn = 0.12;
  const View from = ahead({2, 1.5, 1.5}, {0, 0, -1});
  const View to = ahead({2, 1.5, 1.5}, {std::sin(turn), 0, -std::cos(turn)});
  engine->forward(from);
  const Image before = engine->readColor();
  const WarpSource source = engine->warpSource(from);
  std::array<Image, 3> results;
  for (std::size_t i = 0; i < 3; ++i) results[i] = warped(kWarps[i], source, to);
  const double focal = 0.5 * kHeight / std::tan(0.5 * from.fovY);
  double worst = 0.0;
  for (int y = 2; y < kHeight - 2; ++y)
    for (int x = 2; x < kWidth - 2; ++x) {
      // The column's angle off the axis, turned; the row's height above the horizon at that angle.
      const double angle = std::atan((x + 0.5 - 0.5 * kWidth) / focal) + turn;
      const double column = focal * std::tan(angle) + 0.5 * kWidth;
      const double rise = (y + 0.5 - 0.5 * kHeight) / std::hypot(focal, x + 0.5 - 0.5 * kWidth);
      const double row = rise * std::hypot(focal, column - 0.5 * kWidth) + 0.5 * kHeight;
      if (column < 2 || column > kWidth - 2 || row < 2 || row > kHeight - 2) continue;
      const glm::dvec3 expected = between(before, {column, row});
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(results[0].at(x, y)[c] - expected[c]));
    }
  EXPECT_LE(worst, 2.0);
  // With depth the same: distances do not matter where the eye stays.
  EXPECT_LE(largestInside(results[0], results[2], 2), 2);
  EXPECT_GT(psnr(results[0], results[1]).value(), 40.0);
}

TEST_F(ImageWarpTest, APlaneShiftsByItsDisparity) {
  auto engine = make(boardBeforeWall(false));
  ASSERT_TRUE(engine);
  for (const glm::dvec3& moved :
       {glm::dvec3(0.3, 0, 0), glm::dvec3(-0.3, 0.4, 0), glm::dvec3(0.05, 0, -0.5)}) {
    const View from = ahead();
    const View to = ahead(moved);
    engine->forward(to);
    const Image truth = engine->readColor();
    engine->forward(from);
    const Image before = engine->readColor();
    const WarpSource source = engine->warpSource(from);
    for (const Warp warp : kWithDepth)
      EXPECT_LE(largestInside(truth, warped(warp, source, to), 24), 2)
          << static_cast<int>(warp) << " " << moved.x;
    EXPECT_LE(test::largestDifference(before, warped(Warp::Time, source, to)), 1)
        << "time warping knows no place";
    EXPECT_GT(largestInside(truth, before, 24), 4) << "both views are alike";
  }
}

TEST_F(ImageWarpTest, WhatIsNearerHidesAndWhatComesIntoViewIsDrawnOutOfTheBackground) {
  auto engine = make(boardBeforeWall(true));
  ASSERT_TRUE(engine);
  const View from = ahead();
  const View to = ahead({0.15, 0, 0});
  engine->forward(to);
  const Image truth = engine->readColor();
  engine->forward(from);
  const Image warp = warped(Warp::Iterative, engine->warpSource(from), to);
  const auto red = [](const std::uint8_t* p) { return p[0] > 200 && p[1] < 30 && p[2] < 30; };
  int expected = 0;
  int found = 0;
  int wrong = 0;
  int mixed = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const std::uint8_t* t = truth.at(x, y);
      const std::uint8_t* w = warp.at(x, y);
      expected += red(t) ? 1 : 0;
      found += red(w) ? 1 : 0;
      wrong += red(t) != red(w) ? 1 : 0;
      // The wall's blue is half everywhere: less of it is a mix with the board.
      mixed += !red(w) && w[2] < 150 ? 1 : 0;
      ASSERT_EQ(w[3], 255) << "hole at " << x << ", " << y;
    }
  EXPECT_GT(expected, 3000);
  EXPECT_NEAR(found, expected, 0.05 * expected);
  EXPECT_LT(wrong, 300) << "more than the board's outline";
  EXPECT_LT(mixed, 400);
  // Mesh warping draws the board out over as many pixels as the disparities differ by, in each row of it.
  const Image mesh = warped(Warp::Mesh, engine->warpSource(from), to);
  EXPECT_GT(mssim(truth, warp).value().mean, mssim(truth, mesh).value().mean);
}

TEST_F(ImageWarpTest, EyesFarFromTheOriginWarpAlike) {
  auto engine = make(boardBeforeWall(true));
  ASSERT_TRUE(engine);
  const View from = ahead();
  const View to = ahead({0.125, 0.0625, -0.03125});
  engine->forward(from);
  WarpSource source = engine->warpSource(from);
  for (const Warp warp : kWithDepth) {
    source.view = from;
    const Image here = warped(warp, source, to);
    const glm::dvec3 far(1048576.0, -2097152.0, 4194304.0);
    source.view.eye += far;
    View there = to;
    there.eye += far;
    EXPECT_EQ(warped(warp, source, there).pixels, here.pixels) << static_cast<int>(warp);
  }
}

TEST_F(ImageWarpTest, AWiderPictureOfAnotherSizeIsWarpedToANarrowOne) {
  auto engine = make(boardBeforeWall(false));
  ASSERT_TRUE(engine);
  View wide = ahead();
  wide.width = 480;
  wide.height = 240;
  wide.fovY = 2.0 * std::atan(std::tan(0.5 * wide.fovY) * 240.0 / kHeight);
  const View to = ahead({0.2, 0, 0}, {0.1, 0.05, -1});
  engine->forward(to);
  const Image truth = engine->readColor();
  engine->forward(wide);
  for (const Warp warp : kWithDepth)
    EXPECT_LE(test::largestDifference(truth, warped(warp, engine->warpSource(wide), to)), 2)
        << static_cast<int>(warp) << ": no border may be left";
}

TEST_F(ImageWarpTest, WhatCannotBeWarpedIsRefused) {
  auto engine = make(boardBeforeWall(false));
  ASSERT_TRUE(engine);
  const View view = ahead();
  engine->forward(view);
  const WarpSource source = engine->warpSource(view);
  EXPECT_NE(refusal(Warp::Mesh, {nullptr, nullptr, view}, view).find("mesh warping: no picture"),
            std::string::npos);
  EXPECT_NE(refusal(Warp::Iterative, {source.encoded, nullptr, view}, view).find("with depth"),
            std::string::npos);
  EXPECT_EQ(refusal(Warp::Time, {source.encoded, nullptr, view}, view), "");
  View other = view;
  other.width = 64;
  EXPECT_NE(refusal(Warp::Time, {source.encoded, source.depth, other}, view).find("64 x 180"),
            std::string::npos);
  other.width = 0;
  EXPECT_NE(refusal(Warp::Time, source, other).find("0 x 180"), std::string::npos);
  EXPECT_NE(refusal(Warp::Iterative, source, view, {.starts = 65}).find("65 starts"), std::string::npos);
  EXPECT_NE(refusal(Warp::Iterative, source, view, {.iterations = 0}).find("0 iterations"),
            std::string::npos);
  EXPECT_NE(refusal(Warp::Iterative, source, view, {.converged = 0.0f}).find("0 pixels"), std::string::npos);
  gl::ProgramCache programs(test::context());
  auto timeOnly = ImageWarp::create(programs, std::span(kWarps).first(1));
  ASSERT_TRUE(timeOnly);
  Target target(16, 16);
  EXPECT_FALSE(timeOnly->draw(Warp::Mesh, source, view, target.framebuffer, glm::vec4(0.0f)));
}

}  // namespace
}  // namespace tessera
