// Fixed-function state of a pass, set in full: nothing is assumed of what a host left behind.
#pragma once

#include <cstdint>

#include <glad/gl.h>

namespace tessera::gl {

enum class DepthTest : std::uint8_t { Off, Greater, GreaterEqual, Equal, Less };

struct DrawState {
  DepthTest depth = DepthTest::Off;
  bool depthWrite = false;
  bool cullBack = false;
  bool mirrored = false;      // front faces are clockwise
  bool blend = false;         // source over, alpha accumulates coverage
  bool encodeSrgb = false;    // writes to an sRGB target are encoded
  float offsetFactor = 0.0f;  // polygon offset; both 0 = off
  float offsetUnits = 0.0f;
};

/// Sets every piece of state that a draw of the engine depends on: the above, and to their defaults scissor,
/// stencil, masks, polygon mode, clip control (depth 0 to 1), depth range, primitive restart, sample and
/// logic operations.
void apply(const DrawState& state);
/// Only what may differ between draws of one pass.
void applyCulling(bool cullBack, bool mirrored);

}  // namespace tessera::gl
