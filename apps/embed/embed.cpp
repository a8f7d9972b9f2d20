// A host with its own context: draws a background, lets the engine draw a scene into a part of its
// framebuffer, and draws a frame and a bar over that.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "engine/image/image.hpp"
#include "engine/tessera.hpp"
#include "gaze.hpp"
#include "host.hpp"
#include "painter.hpp"

namespace {

using embed::Host;
using embed::Painter;
using embed::Rectangle;
using tessera::Result;

struct Options {
  std::string scene;
  std::string output;
  int width = 960;
  int height = 600;
  int frames = 0;
  bool window = false;
  bool foveate = false;
};

constexpr embed::Color kBottom = {0.10f, 0.12f, 0.16f, 1.0f};
constexpr embed::Color kTop = {0.32f, 0.36f, 0.42f, 1.0f};
constexpr embed::Color kFrame = {1.0f, 0.8f, 0.0f, 1.0f};
constexpr embed::Color kBar = {0.0f, 0.0f, 0.0f, 0.5f};

/// The scene's first camera, or a view of the whole.
tessera::View cameraOf(const tessera::Engine& engine, int width, int height) {
  const tessera::Scene& scene = engine.scene();
  if (scene.cameras.empty()) return tessera::autoView(scene, width, height);
  return tessera::viewOf(scene, engine.state(), 0, width, height, tessera::defaultNear(scene));
}

/// What the host's framebuffer holds now, rows from the top.
tessera::Image readPicture(const Host& host) {
  std::vector<std::uint8_t> bottomUp(std::size_t{4} * static_cast<std::size_t>(host.width()) *
                                     static_cast<std::size_t>(host.height()));
  host.gl().PixelStorei(GL_PACK_ALIGNMENT, 1);
  host.gl().ReadPixels(0, 0, host.width(), host.height(), GL_RGBA, GL_UNSIGNED_BYTE, bottomUp.data());
  return tessera::flipped(host.width(), host.height(), bottomUp);
}

Result<void> run(Host& host, const Options& options) {
  auto painter = Painter::create(host);
  if (!painter) return tl::unexpected(painter.error());
  const Rectangle all{0, 0, host.width(), host.height()};
  const int margin = std::min(all.width, all.height) / 16;
  const Rectangle picture{margin, margin, all.width - 2 * margin, all.height - 2 * margin};
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return options.window ? std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()
                          : 0.0;
  };

  // Embedding begins: the host's context is current.
  auto context = tessera::gl::Context::adoptCurrent(host.loader());
  if (!context) return tl::unexpected(context.error());
  auto scene = tessera::loadGltf(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  auto engine = tessera::Engine::create(**context, std::move(*scene), {}, {});
  if (!engine) return tl::unexpected(engine.error());

  bool foveate = options.foveate;
  for (int frame = 1;; ++frame) {
    if (host.togglePresses() % 2 == 1) foveate = !foveate;
    painter->fill(all, kBottom, kTop);

    (*engine)->update(seconds());
    const std::array<tessera::View, 1> views = {cameraOf(**engine, picture.width, picture.height)};
    tessera::PlaceOptions placing;
    if (foveate) {
      placing.foveation.emplace();
      if (const auto cursor = host.cursor())
        placing.foveation->gaze = embed::gazeUnder(*cursor, picture, all.height);
    }
    (*engine)->findVisible(views);
    if (auto placed = (*engine)->place(views, placing); !placed) return placed;
    (*engine)->shade(views[0]);
    (*engine)->display(views[0]);
    (*engine)->blit(host.framebuffer(), picture.x, picture.y, picture.width, picture.height);

    // The host's program, vertex array, framebuffer and blending are still in place.
    painter->fill({picture.x, picture.y, picture.width, picture.height / 8}, kBar);
    painter->frame(picture, 4, kFrame);
    // Embedding ends.
    const bool last = frame == options.frames;
    const auto shown = options.output.empty() ? tessera::Image{} : readPicture(host);
    if (host.present() && !last) continue;
    return options.output.empty() ? Result<void>{} : tessera::writePng(options.output, shown);
  }
}

Result<void> open(const Options& options) {
  if (options.output.empty() && !options.window)
    return tessera::fail("nothing to do: give -o FILE, or --window");
  auto host = options.window ? embed::makeWindow(options.width, options.height)
                             : embed::makeSurfaceless(options.width, options.height);
  if (!host) return tl::unexpected(host.error());
  return run(**host, options);
}

int runProgram(int argc, char** argv) {
  Options options;
  CLI::App app("A host program that embeds tessera in a GL context of its own.");
  app.add_option("scene", options.scene, "glTF 2.0 file, .gltf or .glb")->required();
  app.add_option("-o,--output", options.output, "PNG of the last picture");
  app.add_flag("--window", options.window, "show a window until it is closed, instead of one picture");
  app.add_option("--frames", options.frames, "with --window: end after this many pictures; 0 = never")
      ->check(CLI::Range(0, 1000000));
  app.add_flag("--foveate", options.foveate,
               "shade less where the eye resolves less: gaze at the cursor, without a window at the middle; "
               "the F key turns it on and off");
  app.add_option("--width", options.width, "pixels")->check(CLI::Range(64, 8192))->capture_default_str();
  app.add_option("--height", options.height, "pixels")->check(CLI::Range(64, 8192))->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const auto result = open(options);
  if (result) return 0;
  fmt::print(stderr, "embed: {}\n", result.error().message);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return runProgram(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "embed: %s\n", error.what());
    return 1;
  }
}
