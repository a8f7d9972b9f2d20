// The host that was built against the installed package: its picture, and what it says when it cannot draw
// one.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <sys/wait.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "engine/image/image.hpp"

namespace tessera {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr int kMargin = 15;  // the host's: a sixteenth of the shorter side
constexpr int kFrame = 4;

std::filesystem::path folder() { return std::filesystem::path(TESSERA_CONSUMER_DIR) / "pictures"; }

struct Outcome {
  int status = -1;
  std::string errors;
};

Outcome runHost(const std::string& arguments, const std::string& environment = "") {
  std::filesystem::create_directories(folder());
  const std::string errors = (folder() / "stderr.txt").string();
  const std::string command =
      fmt::format("env {} '{}/embed/embed' {} 2> '{}'", environment, TESSERA_CONSUMER_DIR, arguments, errors);
  const int status = std::system(command.c_str());
  std::ostringstream text;
  text << std::ifstream(errors).rdbuf();
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text.str()};
}

/// A unlit red quad that fills the view of the file's camera.
std::filesystem::path writeRedQuad() {
  std::filesystem::create_directories(folder());
  const std::array<float, 12> corners = {-9, -9, -2, 9, -9, -2, 9, 9, -2, -9, 9, -2};
  const std::array<std::uint16_t, 6> indices = {0, 1, 2, 0, 2, 3};
  std::ofstream data(folder() / "quad.bin", std::ios::binary);
  data.write(reinterpret_cast<const char*>(corners.data()), sizeof(corners));
  data.write(reinterpret_cast<const char*>(indices.data()), sizeof(indices));
  const auto path = folder() / "quad.gltf";
  std::ofstream(path) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
 "extensionsUsed": ["KHR_materials_unlit"],
 "nodes": [{"mesh": 0}, {"camera": 0}],
 "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}],
 "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.02, 0.01, 1]},
                "extensions": {"KHR_materials_unlit": {}}}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
 "buffers": [{"uri": "quad.bin", "byteLength": 60}],
 "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": [-9, -9, -2], "max": [9, 9, -2]},
               {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]}
)";
  return path;
}

std::array<int, 3> at(const Image& image, int x, int y) {
  const std::uint8_t* p = image.at(x, y);
  return {p[0], p[1], p[2]};
}

TEST(Consumer, DrawsTheSceneBetweenItsOwnDrawings) {
  const auto output = folder() / "quad.png";
  std::filesystem::remove(output);
  const Outcome run = runHost(fmt::format("'{}' -o '{}' --width {} --height {}", writeRedQuad().string(),
                                          output.string(), kWidth, kHeight));
  ASSERT_EQ(run.status, 0) << run.errors;
  const auto image = readImage(output);
  ASSERT_TRUE(image) << image.error().message;
  ASSERT_EQ(image->width, kWidth);
  ASSERT_EQ(image->height, kHeight);

  // The background, before the engine: a gradient of the host's, in the margin all around.
  EXPECT_NEAR(at(*image, 2, kHeight - 1)[2], 0.16 * 255, 2);
  EXPECT_NEAR(at(*image, kWidth - 3, 0)[2], 0.42 * 255, 2);
  EXPECT_EQ(at(*image, 0, kHeight / 2), at(*image, kWidth - 1, kHeight / 2));
  // The scene: one colour, red, from frame to frame.
  const auto centre = at(*image, kWidth / 2, kHeight / 2);
  EXPECT_GT(centre[0], 150);
  EXPECT_LT(centre[1], centre[0] / 2);
  EXPECT_LT(centre[2], centre[0] / 2);
  int wrong = 0;
  const int bar = kHeight - kMargin - (kHeight - 2 * kMargin) / 8;
  for (int y = kMargin + kFrame; y < bar; ++y)
    for (int x = kMargin + kFrame; x < kWidth - kMargin - kFrame; ++x)
      for (std::size_t c = 0; c < 3; ++c) wrong += std::abs(at(*image, x, y)[c] - centre[c]) > 2 ? 1 : 0;
  EXPECT_EQ(wrong, 0);
  // After the engine: the frame as it is, the bar blended over the scene.
  const std::array<int, 3> yellow = {255, 204, 0};
  EXPECT_EQ(at(*image, kMargin, kHeight / 2), yellow);
  EXPECT_EQ(at(*image, kWidth - kMargin - 1, kHeight / 2), yellow);
  EXPECT_EQ(at(*image, kWidth / 2, kMargin), yellow);
  const auto darkened = at(*image, kWidth / 2, bar + 4);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(darkened[c], centre[c] * 0.5, 1.5);
}

TEST(Consumer, DrawsTheInstalledAtrium) {
  const auto output = folder() / "atrium.png";
  std::filesystem::remove(output);
  const std::string scene =
      std::string(TESSERA_CONSUMER_DIR) + "/prefix/" + TESSERA_CONSUMER_DATA + "/tessera/assets/atrium.glb";
  const Outcome run =
      runHost(fmt::format("'{}' -o '{}' --width {} --height {}", scene, output.string(), kWidth, kHeight));
  ASSERT_EQ(run.status, 0) << run.errors;
  const auto image = readImage(output);
  ASSERT_TRUE(image) << image.error().message;
  // A scene of many colours is there, not a clear colour.
  std::array<bool, 4096> seen{};
  for (int y = kMargin + kFrame; y < kHeight / 2; ++y)
    for (int x = kMargin + kFrame; x < kWidth - kMargin - kFrame; ++x) {
      const auto p = at(*image, x, y);
      seen[static_cast<std::size_t>((p[0] >> 4) * 256 + (p[1] >> 4) * 16 + (p[2] >> 4))] = true;
    }
  EXPECT_GT(std::count(seen.begin(), seen.end(), true), 20);
}

TEST(Consumer, SaysWhatIsWrong) {
  const auto output = folder() / "none.png";
  std::filesystem::remove(output);
  const Outcome missing = runHost(fmt::format("'/no/such.glb' -o '{}'", output.string()));
  EXPECT_EQ(missing.status, 2);
  EXPECT_NE(missing.errors.find("/no/such.glb"), std::string::npos) << missing.errors;
  EXPECT_FALSE(std::filesystem::exists(output));

  // With no display to open it on, a window is an error like others.
  const Outcome window = runHost(fmt::format("'{}' --window --frames 1", writeRedQuad().string()),
                                 "-u DISPLAY -u WAYLAND_DISPLAY");
  EXPECT_EQ(window.status, 2);
  EXPECT_NE(window.errors.find("window"), std::string::npos) << window.errors;
}

}  // namespace
}  // namespace tessera
