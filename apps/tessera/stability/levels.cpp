// Level selection at its borders, and memory that is wanting.
#include "glsl/shared/levels.h"

#include <algorithm>
#include <random>

#include "apps/tessera/stability/case.hpp"
#include "apps/tessera/stability/exact.hpp"
#include "engine/scene/build.hpp"
#include "glsl/shared/acuity.h"

namespace tessera::stability {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kDenormal = 1e-42f;

std::vector<glsl::LevelRange> ranges() {
  std::vector<glsl::LevelRange> all;
  for (glsl::uint smallest = 0; smallest <= 10; ++smallest)
    for (glsl::uint largest = smallest; largest <= 10; ++largest)
      for (const glsl::uint aspect : {1U, 2U, 5U, 10U}) all.push_back({smallest, largest, aspect});
  return all;
}

bool within(glsl::uint level, const glsl::LevelRange& range) {
  const glsl::uint w = glsl::levelWidth(level);
  const glsl::uint h = glsl::levelHeight(level);
  return h >= range.smallest && h <= w && w <= range.largest && w - h <= range.aspect;
}

const std::vector<float>& hardFloats() {
  static const std::vector<float> all = {
      0.0f,    -0.0f,    1.0f,      -1.0f,      0.5f, -0.5f, kDenormal, -kDenormal, 1e-30f, 1e30f, -1e30f,
      3.4e38f, -3.4e38f, kInfinity, -kInfinity, kNan, 9.5f,  9.499999f, 10.5f,      20.0f,  32.0f, -32.0f};
  return all;
}

/// Over rounding borders and every range: how far the chosen block's log2 area lies from the ideal that the
/// range allows, beyond half a step.
double worstRounding() {
  double worst = 0.0;
  for (const glsl::LevelRange& range : ranges())
    for (int half = 0; half <= 44; ++half)
      for (const float nudge : {-1e-6f, 0.0f, 1e-6f}) {
        const float area = 0.5f * static_cast<float>(half) - 1.0f + nudge;
        for (const float aspect : {-20.0f, -3.0f, -1.0f, -0.5f, 0.0f, 0.5f, 1.0f, 2.0f, 20.0f}) {
          const glsl::uint level = glsl::selectLevel({area, aspect}, 0.0f, 0.0f, range, 0, -1.0f);
          if (!within(level, range)) return std::numeric_limits<double>::infinity();
          const float ideal = std::clamp(area, 2.0f * static_cast<float>(range.smallest),
                                         2.0f * static_cast<float>(range.largest));
          const auto chosen = static_cast<float>(glsl::levelWidth(level) + glsl::levelHeight(level));
          worst = std::max(worst, static_cast<double>(std::abs(chosen - ideal)));
        }
      }
  return worst;
}

double invalidLevels() {
  double invalid = 0.0;
  for (const glsl::LevelRange& range : ranges())
    for (const float area : hardFloats())
      for (const float aspect : hardFloats())
        for (const float bias : hardFloats())
          for (const glsl::uint previous : {0U, 0x55U, 0xffffffffU}) {
            const glsl::uint level = glsl::selectLevel({area, aspect}, bias, 0.0f, range, previous, 0.1f);
            invalid += within(level, range) ? 0.0 : 1.0;
            const glsl::uint texels = glsl::idealTexels({area, aspect}, bias, range);
            invalid +=
                texels >= glsl::smallestTexels(range) && texels <= 1U << (2 * range.largest) ? 0.0 : 1.0;
          }
  return invalid;
}

/// Corners of patches out of hardFloats, all permutations of three axes drawn at random.
double invalidMeasures() {
  std::mt19937 random(11);
  std::uniform_int_distribution<std::size_t> pick(0, hardFloats().size() - 1);
  const auto corner = [&] {
    return glm::vec3(hardFloats()[pick(random)], hardFloats()[pick(random)], hardFloats()[pick(random)]);
  };
  double invalid = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const glsl::PatchMeasure m = glsl::measurePatch(corner(), corner(), corner(), corner(), corner(),
                                                    1U + static_cast<glsl::uint>(i % 3), 1000.0f);
    const bool valid = m.logArea >= -100.0f && m.logArea <= 100.0f && std::abs(m.logAspect) <= 20.0f;
    invalid += valid ? 0.0 : 1.0;
  }
  return invalid;
}

/// A level that a camera's sway would flip: with hysteresis a measure on the border keeps what it had.
double flips(float hysteresis) {
  const glsl::LevelRange range{0, 10, 10};
  double changes = 0.0;
  for (int border = 1; border < 20; ++border) {
    glsl::uint level =
        glsl::selectLevel({static_cast<float>(border) - 0.5f, 0.0f}, 0.0f, 0.0f, range, 0, -1.0f);
    for (int frame = 0; frame < 100; ++frame) {
      const float sway = (frame % 2 == 0 ? 1.0f : -1.0f) * 1e-3f;
      const glsl::uint next = glsl::selectLevel({static_cast<float>(border) - 0.5f + sway, 0.0f}, 0.0f, 0.0f,
                                                range, level, frame == 0 ? -1.0f : hysteresis);
      changes += frame > 0 && next != level ? 1.0 : 0.0;
      level = next;
    }
  }
  return changes;
}

/// b = log2((I - d) / (S - d)) against long double, for sums that pass 2^32, and where nothing is left.
double worstPressure() {
  const glsl::LevelRange range{0, 10, 10};
  double worst = 0.0;
  for (double ideal = 1e3; ideal < 1e15; ideal *= 3.7)
    for (double target = 1e3; target < 2e8; target *= 5.1)
      for (const glsl::uint least : {0U, 1U, 900U}) {
        const auto whole = static_cast<std::uint64_t>(ideal);
        const float bias =
            glsl::pressureBias(static_cast<glsl::uint>(whole), static_cast<glsl::uint>(whole >> 32U), least,
                               range, static_cast<float>(target), -2.0f);
        const Exact room = static_cast<Exact>(static_cast<float>(target)) - least;
        const Exact truth =
            room < 1 ? 32 : std::clamp<Exact>(std::log2(static_cast<Exact>(whole) / room), -2, 32);
        worst = std::max(worst, static_cast<double>(std::abs(bias - truth)));
      }
  return worst;
}

double badBorders() {
  double bad = 0.0;
  for (const glsl::uint smallest : {0U, 3U, 10U}) {
    const glsl::LevelRange range{smallest, 10, 10};
    for (const float target : {0.0f, 1.0f, 4096.0f, -1.0f, kNan, kInfinity})
      for (const glsl::uint least : {0U, 1U, 4096U, 0xffffffffU})
        for (const glsl::uint low : {0U, 1U, 0xffffffffU}) {
          const float bias = glsl::pressureBias(low, 0, least, range, target, 0.0f);
          // I <= d: nothing can shrink, so no bias. S <= d: everything to its smallest.
          const float room = target - static_cast<float>(least) * static_cast<float>(1U << (2 * smallest));
          const bool none = low < 1;
          const bool most = !none && !(room >= 1.0f && std::isfinite(room));
          const bool valid = bias >= 0.0f && bias <= 32.0f;
          bad += !valid || (none && bias != 0.0f) || (most && bias != 32.0f) ? 1.0 : 0.0;
        }
  }
  return bad;
}

Scene wall() {
  Scene scene = build::emptyScene();
  const auto material = build::addMaterial(scene, build::unlit());
  build::place(scene, build::addGrid(scene, {-4, -3, -4}, {8, 0, 0}, {0, 6, 0}, 20, 15, material));
  build::finish(scene);
  return scene;
}

Result<double> badAtlas(Bench& bench, const std::function<void(RectMemoryOptions&)>& change) {
  EngineOptions options;
  change(options.atlas.memory);
  return badPixels(bench, wall(), {},
                   std::vector<View>{look({0, 0, 0}, {0, 0, -1}), look({0, 0, -3}, {1, 0, -4})},
                   Pixels::White, options);
}

}  // namespace

void addLevelCases(Cases& cases) {
  cases.push_back(
      {"levels/rounding",
       "ideal areas on and beside the borders between levels, in every range of blocks: "
       "the block is the nearest of its parity (half a step, or 1 where the range leaves one shape)",
       "log2 of area", 0.500002, Sense::AtMost, [](Bench&) -> Result<double> { return worstRounding(); }});
  cases.push_back({"levels/any-float",
                   "areas, aspects and biases that are NaN, infinite, denormal or huge: the level "
                   "is one of the range",
                   "invalid levels", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return invalidLevels(); }});
  cases.push_back(
      {"levels/any-corner", "corners that are NaN, infinite, denormal or huge: the measure is finite",
       "invalid measures", 0.0, Sense::AtMost, [](Bench&) -> Result<double> { return invalidMeasures(); }});
  cases.push_back({"levels/hysteresis", "ideal areas that sway by 1e-3 over a border: the level stays",
                   "changes", 0.0, Sense::AtMost, [](Bench&) -> Result<double> { return flips(0.1f); }});
  cases.push_back({"levels/no-hysteresis-fails", "the same without hysteresis changes level in each frame",
                   "changes", 1000.0, Sense::AtLeast, [](Bench&) -> Result<double> { return flips(-1.0f); }});
  cases.push_back({"levels/pressure",
                   "the pressure bias of sums past 2^32, of targets near the smallest blocks", "log2 of area",
                   1e-5, Sense::AtMost, [](Bench&) -> Result<double> { return worstPressure(); }});
  cases.push_back({"levels/pressure-borders",
                   "S <= d and I <= d, where eq. 3.3 takes the log of a negative number or "
                   "divides by none",
                   "invalid biases", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return badBorders(); }});
  cases.push_back({"levels/printed-bias-fails",
                   "log2((I - d) / (S - d)) as printed is not finite at these borders", "non-finite biases",
                   1.0, Sense::AtLeast, [](Bench&) -> Result<double> {
                     double bad = 0.0;
                     for (const float target : {100.0f, 4096.0f, 5000.0f})
                       for (const float ideal : {4096.0f, 5000.0f, 3000.0f})
                         bad += std::isfinite(std::log2((ideal - 4096.0f) / (target - 4096.0f))) ? 0.0 : 1.0;
                     return bad;
                   }});
  cases.push_back({"levels/nothing-visible", "a camera that looks away: no patch is visible", "bad pixels",
                   0.0, Sense::AtMost, [](Bench& bench) {
                     return badPixels(
                         bench, wall(), {},
                         std::vector<View>{look({0, 0, 0}, {0, 0, 1}), look({0, 0, 0}, {0, 0, -1})},
                         Pixels::White);
                   }});
  cases.push_back(
      {"levels/all-one-texel", "a bias of 16: every block is one texel", "bad pixels", 0.0, Sense::AtMost,
       [](Bench& bench) { return badAtlas(bench, [](RectMemoryOptions& m) { m.bias = 16.0f; }); }});
  cases.push_back(
      {"levels/all-largest", "a bias of -16: every patch wants the largest block, which 1 in 300 can have",
       "bad pixels", 0.0, Sense::AtMost,
       [](Bench& bench) { return badAtlas(bench, [](RectMemoryOptions& m) { m.bias = -16.0f; }); }});
  cases.push_back({"levels/one-size", "smallest and largest block are the same: nothing can shrink",
                   "bad pixels", 0.0, Sense::AtMost, [](Bench& bench) {
                     return badAtlas(bench, [](RectMemoryOptions& m) { m.smallestLog2 = m.largestLog2 = 5; });
                   }});
}

}  // namespace tessera::stability
