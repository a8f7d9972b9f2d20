// The report of atlas-bench: allocators over the same requests, as atlas_bench.json and as one self-contained
// page.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// What one allocator did in one frame. Texels are those of the atlas without its record rows; live, end,
/// stack, inaccessible and free ones are all there are.
struct BenchFrame {
  double live = 0.0;          // texels of blocks of visible patches
  double end = 0.0;           // not yet cut, at the end of partly filled superblocks
  double stack = 0.0;         // in free blocks: on stacks, or below the roots of the quadtree
  double inaccessible = 0.0;  // freed, but lost until their superblock is empty
  double free = 0.0;          // in whole superblocks
  double made = 0.0;          // blocks
  double moved = 0.0;         // blocks whose patch had another one in the last frame
  double freed = 0.0;         // blocks
  double failures = 0.0;      // requests without memory
  double reduced = 0.0;       // requests that got a smaller block than asked for, for want of memory
  double movedTexels = 0.0;   // of live blocks whose patch had a block elsewhere in the last frame
  double stayed = 0.0;        // patches that were and are visible, with a block of one level, without a reset
  double kept = 0.0;          // of those, the ones at the same place
  bool reset = false;
  double bias = 0.0;    // in force, log2 of area
  double target = 0.0;  // S, texels
  double ms = 0.0;      // level selection and allocation
};

/// One allocator over all frames.
struct BenchRun {
  std::string name;
  std::vector<BenchFrame> frames;
};

/// What a run comes to. Shares are within 0 to 1, NaN where there is nothing to share.
struct BenchSummary {
  std::size_t frames = 0;
  std::size_t oomFrames = 0;  // with at least one request without memory
  double failures = 0.0;      // over all frames
  double reduced = 0.0;       // over all frames
  std::size_t resets = 0;
  double liveShare = kNotMeasured;   // mean over the frames, of the atlas
  double keptPlace = kNotMeasured;   // of patch-frames of patches that stay at their level, outside resets
  double movedShare = kNotMeasured;  // of live texels over all frames
  double movedShareOutsideResets = kNotMeasured;
  double bias = kNotMeasured;  // mean
  Statistics ms;               // without the first frame, in which drivers compile
};
BenchSummary summarize(const BenchRun& run);

/// S0 with other sizes.
struct BenchVariant {
  int superblock = 0;  // texels a side, like what follows
  int smallest = 0;
  int largest = 0;
  int aspect = 0;  // width to height at most
  bool standard = false;
  std::string skipped;   // why these sizes cannot be; empty where they ran
  BenchSummary summary;  // of what ran
};

struct BenchScene {
  std::string scene;
  int width = 0;  // of the pictures that were asked for, pixels
  int height = 0;
  double fps = 0.0;
  double patchInstances = 0.0;
  double visiblePatches = 0.0;  // mean
  int atlasWidth = 0;           // texels
  int atlasHeight = 0;
  std::vector<BenchRun> strategies;  // on the GPU
  BenchRun quadtree;
  Statistics frameMs;   // of the frames that were rendered whole while recording
  Statistics memoryMs;  // of the memory phases in those frames
  std::vector<BenchVariant> sweep;
};

struct BenchReport {
  ReportContext context;
  std::string settings;  // one line
  std::vector<BenchScene> scenes;
};

/// atlas_bench.json. Top level: "strategies" and "cpu_quadtree" over all scenes: counts are sums, all else
/// means of the scenes' values. "scenes" has the same a scene, and their series frame by frame.
std::string toJson(const BenchReport& report);
/// The page: no request leaves it, opens from a file.
std::string toHtml(const BenchReport& report);

}  // namespace tessera
