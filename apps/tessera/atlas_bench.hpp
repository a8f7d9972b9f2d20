// tessera atlas-bench: allocators of the atlas memory over the same requests.
#pragma once

#include <string>
#include <vector>

#include "apps/tessera/options.hpp"
#include "atlas/rect/request_stream.hpp"

namespace tessera::app {

struct AtlasBenchOptions {
  std::vector<std::string> scenes;
  std::vector<std::string> load;  // streams recorded before
  std::string record;             // file, or folder for several scenes
  std::string output;
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

}  // namespace tessera::app
