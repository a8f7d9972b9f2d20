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

/// Makes the atlas that the method fills, if it does.
Result<void> useAtlas(Engine& engine, const Method& method);
/// The view, or the two eyes of a stereo method around it.
std::vector<View> eyesOf(const Method& method, const View& view, double eyeDistance);
/// Finds what is visible and places it, for methods that use an atlas.
Result<void> placeFrame(Engine& engine, const Method& method, const TimedView& timed,
                        const std::vector<View>& eyes);

Result<Drawn> drawFrame(Engine& engine, const Method& method, const TimedView& timed,
                        const DrawingOptions& options);

}  // namespace tessera::app
