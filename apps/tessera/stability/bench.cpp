#include "apps/tessera/stability/bench.hpp"

#include <algorithm>
#include <cstdlib>

#include <fmt/core.h>

#include "engine/measure/metrics.hpp"

namespace tessera::stability {

namespace {

TessAtlasOptions tessOptions(bool overOnly) {
  TessAtlasOptions options;
  options.memory.width = options.memory.height = 512;
  if (overOnly) options.memory.slanted = TessMemoryOptions::kAllSlanted;
  options.format = AtlasFormat::Rgba16f;
  return options;
}

TexelAtlasOptions texelOptions() {
  TexelAtlasOptions options;
  options.width = options.height = 512;
  options.format = AtlasFormat::Rgba16f;
  return options;
}

/// Says on the error output which method and view a figure is from.
bool traces() { return std::getenv("TESSERA_STABILITY_TRACE") != nullptr; }

bool forbidden(const std::uint8_t* pixel, Pixels pixels) {
  if (pixel[3] == 0 || pixels == Pixels::Any) return false;
  if (pixels == Pixels::White) return std::min({pixel[0], pixel[1], pixel[2]}) < 250;
  return pixel[0] == 0 && pixel[1] == 0 && pixel[2] == 0;
}

}  // namespace

const char* nameOf(Method method) {
  constexpr std::array<const char*, 5> kNames = {"forward", "rect", "tess", "oversample", "texel"};
  return kNames[static_cast<std::size_t>(method)];
}

Result<std::unique_ptr<Engine>> makeEngine(Bench& bench, Scene scene, std::optional<Stage> stage,
                                           EngineOptions options) {
  options.atlas.memory.width = options.atlas.memory.height = 512;
  options.atlas.format = AtlasFormat::Rgba16f;
  options.tess = tessOptions(false);
  options.texel = texelOptions();
  options.shadowSize = std::min(options.shadowSize, 128);
  auto engine = Engine::create(bench.context, std::move(scene), std::move(stage), options);
  if (engine) (*engine)->update(0.0);
  return engine;
}

Result<Image> draw(Engine& engine, Method method, const View& view) {
  if (method == Method::Forward) {
    engine.forward(view);
    return engine.readColor();
  }
  gl::api().ClearTexImage(engine.gatherer()->atlas().texture.get(), 0, GL_RGBA, GL_FLOAT, nullptr);
  engine.findVisible({&view, 1});
  if (auto placed = engine.place({&view, 1}); !placed) return tl::unexpected(placed.error());
  engine.shade(view);
  engine.display(view);
  return engine.readColor();
}

Result<void> use(Engine& engine, Method method, const RectMemoryOptions& memory) {
  if (method == Method::Forward) return {};
  if (method == Method::Texel) return engine.remakeAtlas(texelOptions());
  if (method != Method::Rect) return engine.remakeAtlas(tessOptions(method == Method::Over));
  RectMemoryOptions small = memory;
  small.width = small.height = 512;
  return engine.remakeAtlas(small);
}

Result<double> leastPsnr(Bench& bench, const Shot& a, const Shot& b, const EngineOptions& options,
                         std::span<const Method> methods) {
  auto first = makeEngine(bench, a.scene, a.stage, options);
  if (!first) return tl::unexpected(first.error());
  auto second = makeEngine(bench, b.scene, b.stage, options);
  if (!second) return tl::unexpected(second.error());
  double least = 99.0;
  for (const Method method : methods) {
    for (Engine* engine : {first->get(), second->get()})
      if (auto used = use(*engine, method, options.atlas.memory); !used) return tl::unexpected(used.error());
    for (std::size_t i = 0; i < a.views.size(); ++i) {
      const auto x = draw(**first, method, a.views[i]);
      const auto y = draw(**second, method, b.views[i]);
      if (!x || !y) return tl::unexpected((x ? y : x).error());
      if (countCovered(*x) < x->pixels.size() / 40) return 0.0;
      const auto ratio = psnr(*x, *y);
      if (!ratio) return ratio;
      if (traces()) fmt::print(stderr, "  {} view {}: {} dB\n", nameOf(method), i, *ratio);
      least = std::min(least, *ratio);
    }
  }
  return least;
}

Result<double> badPixels(Bench& bench, Scene scene, std::optional<Stage> stage, std::span<const View> views,
                         Pixels pixels, const EngineOptions& options, double leastCovered) {
  auto made = makeEngine(bench, std::move(scene), std::move(stage), options);
  if (!made) return tl::unexpected(made.error());
  Engine& engine = **made;
  std::vector<Image> forward;
  std::uint64_t bad = 0;
  for (const Method method : kMethods) {
    if (auto used = use(engine, method, options.atlas.memory); !used) return tl::unexpected(used.error());
    for (std::size_t i = 0; i < views.size(); ++i) {
      const auto image = draw(engine, method, views[i]);
      if (!image) return tl::unexpected(image.error());
      if (method == Method::Forward) {
        const double covered =
            4.0 * static_cast<double>(countCovered(*image)) / static_cast<double>(image->pixels.size());
        if (covered < leastCovered) return fail("only {:.0f} % of view {} is covered", covered * 100.0, i);
        forward.push_back(*image);
      } else {
        bad += engine.nonFiniteTexels();
      }
      std::uint64_t wrong = 0;
      for (std::size_t p = 0; p < image->pixels.size(); p += 4) {
        const bool covered = image->pixels[p + 3] != 0;
        const bool is = covered != (forward[i].pixels[p + 3] != 0) || forbidden(&image->pixels[p], pixels);
        wrong += is ? 1 : 0;
        if (is && wrong < 4 && traces())
          fmt::print(stderr, "  pixel {},{} is {} {} {} {}, forward has alpha {}\n", p / 4 % kWidth,
                     p / 4 / kWidth, image->pixels[p], image->pixels[p + 1], image->pixels[p + 2],
                     image->pixels[p + 3], forward[i].pixels[p + 3]);
      }
      if (wrong != 0 && traces()) fmt::print(stderr, "  {} view {}: {} pixels\n", nameOf(method), i, wrong);
      bad += wrong;
    }
  }
  return static_cast<double>(bad);
}

View look(const glm::dvec3& eye, const glm::dvec3& target, double fovYDegrees, double zNear) {
  return lookAt(eye, target, fovYDegrees, kWidth, kHeight, zNear);
}

std::size_t countCovered(const Image& image) {
  std::size_t covered = 0;
  for (std::size_t i = 3; i < image.pixels.size(); i += 4) covered += image.pixels[i] > 0 ? 1 : 0;
  return covered;
}

std::size_t countDifferent(const Image& a, const Image& b) {
  if (a.pixels.size() != b.pixels.size()) return std::max(a.pixels.size(), b.pixels.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) different += a.pixels[i] != b.pixels[i] ? 1 : 0;
  return different;
}

int largestDifference(const Image& a, const Image& b) {
  if (a.pixels.size() != b.pixels.size()) return 255;
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max(largest, std::abs(int{a.pixels[i]} - int{b.pixels[i]}));
  return largest;
}

}  // namespace tessera::stability
