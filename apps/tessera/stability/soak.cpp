// Many frames of a slow camera.
#include <cstdio>
#include <map>
#include <memory>
#include <unistd.h>

#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/motion.hpp"

namespace tessera::stability {

namespace {

struct Soaked {
  double different = 0.0;  // the farthest two bytes of the picture of the start before and after
  double grown = 0.0;      // MiB of the process over the second half of the frames
  double gpuGrown = 0.0;   // bytes of GPU memory that the engine knows of
  double lost = 0.0;  // texels of the atlas in use at the start that are not what they were, after a reset
  double nonFinite = 0.0;
};

double residentMiB() {
  long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r"); file != nullptr) {
    if (std::fscanf(file, "%*d %ld", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

std::size_t gpuBytes(const Engine& engine) {
  std::size_t sum = 0;
  for (const auto& [name, bytes] : engine.memory()) sum += bytes;
  return sum;
}

void resetAtlas(Engine& engine) {
  if (RectAtlas* rect = engine.atlas(); rect != nullptr) rect->memory().reset();
  if (TessAtlas* tess = engine.tess(); tess != nullptr) tess->memory().reset();
}

Result<Soaked> soak(Bench& bench, Method method) {
  auto made = makeEngine(bench, hall(), hallLights());
  if (!made) return tl::unexpected(made.error());
  Engine& engine = **made;
  if (auto used = use(engine, method); !used) return tl::unexpected(used.error());
  const int frames = bench.full ? 10000 : 60;
  const auto frameAt = [&](int frame) {
    return draw(engine, method, onTheWay(static_cast<double>(frame) / frames));
  };
  const auto start = frameAt(0);
  if (!start) return tl::unexpected(start.error());
  const bool atlas = method != Method::Forward;
  const std::uint64_t samples = atlas ? engine.gatherer()->readStatistics().samples : 0;
  const std::size_t bytes = gpuBytes(engine);
  Soaked soaked;
  double resident = 0.0;
  for (int frame = 1; frame < frames; ++frame) {
    if (auto drawn = frameAt(frame); !drawn) return tl::unexpected(drawn.error());
    if (frame == frames / 2) resident = residentMiB();
    if (atlas && frame % (frames / 10) == 0)
      soaked.nonFinite += static_cast<double>(engine.nonFiniteTexels());
  }
  soaked.grown = residentMiB() - resident;
  // Hysteresis keeps levels of the way back: a reset takes those of the view alone, as in the first frame.
  resetAtlas(engine);
  const auto end = frameAt(frames);
  if (!end) return tl::unexpected(end.error());
  soaked.different = largestDifference(*start, *end);
  soaked.gpuGrown = static_cast<double>(gpuBytes(engine)) - static_cast<double>(bytes);
  if (atlas)
    soaked.lost = std::abs(static_cast<double>(engine.gatherer()->readStatistics().samples) -
                           static_cast<double>(samples));
  return soaked;
}

/// One soak a method, however many cases look at it.
using Done = std::shared_ptr<std::map<Method, Soaked>>;

Case soakCase(const Done& done, Method method, const char* what, const char* why, const char* unit,
              double bound, double Soaked::*figure) {
  return {std::string("soak/") + nameOf(method) + what,
          why,
          unit,
          bound,
          Sense::AtMost,
          [done, method, figure](Bench& bench) -> Result<double> {
            if (!done->contains(method)) {
              const auto soaked = soak(bench, method);
              if (!soaked) return tl::unexpected(soaked.error());
              done->emplace(method, *soaked);
            }
            return done->at(method).*figure;
          }};
}

}  // namespace

void addSoakCases(Cases& cases) {
  const auto done = std::make_shared<std::map<Method, Soaked>>();
  for (const Method method : kMethods)
    cases.push_back(
        soakCase(done, method, "-returns",
                 method == Method::Forward
                     ? "10,000 frames of a slow camera (60 without --long): back at the start the picture is "
                       "what it was, to the bit"
                     : "the same with an atlas: blocks lie elsewhere, which may change last bits",
                 "of 255", method == Method::Forward ? 0.0 : kLastBits, &Soaked::different));
  for (const Method method : {Method::Rect, Method::Tess, Method::Texel})
    cases.push_back(soakCase(done, method, "-samples",
                             "the same way: the samples placed at the start are as many after it", "samples",
                             0.0, &Soaked::lost));
  for (const Method method : {Method::Rect, Method::Tess, Method::Over, Method::Texel})
    cases.push_back(soakCase(done, method, "-finite",
                             "the same way: texels that are not finite, at ten places of it", "texels", 0.0,
                             &Soaked::nonFinite));
  cases.push_back(soakCase(done, Method::Rect, "-process",
                           "the same way: the process over the second half of it", "MiB", 4.0,
                           &Soaked::grown));
  cases.push_back(
      soakCase(done, Method::Tess, "-gpu", "the same way: GPU memory", "bytes", 0.0, &Soaked::gpuGrown));
}

}  // namespace tessera::stability
