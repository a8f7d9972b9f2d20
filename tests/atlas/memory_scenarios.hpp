// Streams of frames for the tests of the atlas memory, the same for the CPU twin and the GPU.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ostream>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "atlas/rect/memory_twin.hpp"

namespace tessera::test {

struct Scenario {
  std::string name;
  std::uint32_t width = 64;  // texels
  std::uint32_t height = 64;
  std::uint32_t superblockLog2 = 3;
  std::uint32_t patches = 200;
  double demand = 0.5;        // mean texels wanted by the visible set, as a share of the atlas
  double appear = 0.1;        // share of the invisible that appear in a frame
  double disappear = 0.1;     // share of the visible that vanish
  double change = 0.1;        // share of the visible that change level
  double emptyFrames = 0.02;  // share of the frames that see nothing at all
};

inline void PrintTo(const Scenario& scenario, std::ostream* out) { *out << scenario.name; }

inline std::vector<Scenario> scenarios() {
  return {
      {.name = "calm"},
      {.name = "one superblock", .width = 32, .height = 32, .superblockLog2 = 5, .patches = 60},
      {.name = "one small superblock", .width = 2, .height = 2, .superblockLog2 = 1, .patches = 5},
      {.name = "wide", .width = 256, .height = 32, .superblockLog2 = 4, .patches = 700, .demand = 0.7},
      {.name = "overload", .patches = 6000, .demand = 10.0},
      {.name = "overload of large", .patches = 300, .demand = 10.0},
      {.name = "all flip", .demand = 0.3, .appear = 0.5, .disappear = 0.5, .change = 1.0},
      {.name = "tiny superblocks", .width = 32, .height = 32, .superblockLog2 = 1, .patches = 300},
      {.name = "crowd", .width = 512, .height = 512, .superblockLog2 = 6, .patches = 20000, .demand = 0.4},
      {.name = "large superblocks",
       .width = 256,
       .height = 192,
       .superblockLog2 = 6,
       .patches = 400,
       .demand = 0.3},
  };
}

/// Frames to run: `soak` when TESSERA_SOAK is set (./run.sh soak), else `normal`; fewer of a scenario of many
/// patches.
inline int framesOf(const Scenario& scenario, int normal, int soak) {
  const bool forLong = std::getenv("TESSERA_SOAK") != nullptr;
  return (forLong ? soak : normal) / (scenario.patches > 5000 ? 10 : 1);
}

/// A strategy under test: see AtlasStrategy and RectMemoryOptions::merge.
struct Mode {
  std::string name;
  bool columns = true;
  bool stacks = true;
  bool merge = false;
};

inline void PrintTo(const Mode& mode, std::ostream* out) { *out << mode.name; }

inline std::vector<Mode> modes() {
  return {{.name = "S0"},
          {.name = "S0 merging", .merge = true},
          {.name = "S1", .columns = false},
          {.name = "S2", .columns = false, .stacks = false}};
}

using FrameCase = std::tuple<Scenario, Mode>;

inline std::string caseName(const ::testing::TestParamInfo<FrameCase>& test) {
  std::string name = std::get<Scenario>(test.param).name + " " + std::get<Mode>(test.param).name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

class FrameStream {
 public:
  FrameStream(const Scenario& scenario, std::uint32_t seed)
      : scenario_(scenario), random_(seed), wants_(scenario.patches), visible_(scenario.patches, false) {
    const double area = static_cast<double>(scenario.width) * scenario.height;
    const double stay = scenario.appear / (scenario.appear + scenario.disappear);
    mean_ = std::max(1.0, scenario.demand * area / (scenario.patches * stay));
    for (std::uint32_t i = 0; i < scenario.patches; ++i) {
      wants_[i].patch = i;
      draw(wants_[i]);
    }
  }

  /// The next frame's visible patches, in random order.
  std::vector<MemoryTwin::Want> next() {
    std::vector<MemoryTwin::Want> frame;
    for (std::uint32_t i = 0; i < scenario_.patches; ++i) {
      if (chance(visible_[i] ? scenario_.disappear : scenario_.appear)) visible_[i] = !visible_[i];
      if (chance(scenario_.change)) draw(wants_[i]);
      if (visible_[i]) frame.push_back(wants_[i]);
    }
    if (chance(scenario_.emptyFrames)) frame.clear();
    std::shuffle(frame.begin(), frame.end(), random_);
    return frame;
  }

 private:
  bool chance(double share) { return std::uniform_real_distribution<double>(0.0, 1.0)(random_) < share; }

  // Areas spread over two powers of two about the mean, aspects over all that the area allows; some single
  // texels.
  void draw(MemoryTwin::Want& want) {
    const int most = 2 * static_cast<int>(scenario_.superblockLog2);
    const double spread = std::uniform_real_distribution<double>(-2.5, 1.5)(random_);
    const int area = std::clamp(static_cast<int>(std::lround(std::log2(mean_) + spread)), 0, most);
    const int widest = std::min(area, most - area);
    const int aspect = widest - 2 * std::uniform_int_distribution<int>(0, widest / 2)(random_);
    want.w = static_cast<std::uint32_t>(area + aspect) / 2;
    want.h = static_cast<std::uint32_t>(area - aspect) / 2;
  }

  Scenario scenario_;
  std::mt19937 random_;
  std::vector<MemoryTwin::Want> wants_;
  std::vector<bool> visible_;
  double mean_ = 1.0;
};

}  // namespace tessera::test
