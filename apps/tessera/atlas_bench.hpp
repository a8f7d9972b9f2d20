// tessera atlas-bench: allocators of the atlas memory over the same requests.
#pragma once

#include <string>
#include <vector>

#include "apps/tessera/options.hpp"
#include "apps/tessera/progress.hpp"
#include "apps/tessera/report/bench_report.hpp"
#include "atlas/rect/request_stream.hpp"

namespace tessera::app {

struct AtlasBenchOptions {
  std::vector<std::string> scenes;
  std::vector<std::string> load;  // streams recorded before
  std::string record;             // file, or folder for several scenes
  std::string output;
  std::vector<std::string> strategies = {"S0", "S0-unmerged", "S1", "S2", "S3"};
  bool sweep = false;
  std::string command;
  ContextChoice context;
  SizeChoice size{"1920x1080"};
  CameraChoice camera;
  StageChoice stage;
  AtlasChoice atlas;
};

/// Draws nothing but ids for most frames of the path, and keeps what each frame asked of the atlas. A few
/// frames are drawn whole, and timed.
Result<RequestStream> recordRequests(gl::Context& context, const std::string& scene,
                                     const AtlasBenchOptions& options, glm::ivec2 size);

struct BenchStrategy {
  std::string name;
  AtlasStrategy strategy = AtlasStrategy::S0;
  bool merge = true;
};

/// The stream's frames through `memory`, a fresh one for the stream's patches; `name` is the run's. Timed is
/// RectMemory::allocate alone: opening the frame, level selection and request, provision, assign; neither
/// upload nor readback. Fails when a frame cannot be read or memory is not whole in the end.
Result<BenchRun> runOnGpu(gl::Context& context, RectMemory memory, const RequestStream& stream,
                          const std::string& name, Progress& progress);
/// The same on the CPU: timed is QuadtreeAtlas::frame, which does what allocate does but for what its header
/// names.
Result<BenchRun> runQuadtree(const RequestStream& stream, const glsl::AtlasConfig& config,
                             Progress& progress);

}  // namespace tessera::app
