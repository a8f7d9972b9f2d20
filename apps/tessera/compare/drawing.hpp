// One frame by one method.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "apps/tessera/compare/method.hpp"

namespace tessera::app {

struct DrawingOptions {
  double eyeDistance = 0.063;  // of stereo methods, in the scene's metres
  bool read = false;           // pictures are read back
  std::optional<Lens> alsoBehind =
      std::nullopt;  // of pictures without a lens: read back a second time through this one
};

/// What a frame cost and showed.
struct Drawn {
  std::vector<PassTime> times;    // each pass once, of both eyes together
  std::uint64_t invocations = 0;  // of the fragment shader, as GL counts them
  std::uint64_t passed = 0;       // samples of those draws that passed the depth test
  std::vector<Image> pictures;    // one an eye, the left first
  std::vector<Image> behindLens;
};

Result<Drawn> drawFrame(Engine& engine, const Method& method, const TimedView& timed,
                        const DrawingOptions& options);

}  // namespace tessera::app
