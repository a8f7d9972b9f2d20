// Fixed-function state of a pass, set in full: nothing is assumed of what a host left behind.
#pragma once

#include <array>
#include <cstdint>

#include <glad/gl.h>

namespace tessera::gl {

enum class DepthTest : std::uint8_t { Off, Greater, GreaterEqual, Equal, Less, LessEqual };

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

/// Switches that no pass of the engine wants.
inline constexpr std::array<GLenum, 24> kAlwaysOff = {
    GL_SCISSOR_TEST,
    GL_STENCIL_TEST,
    GL_RASTERIZER_DISCARD,
    GL_DEPTH_CLAMP,
    GL_PRIMITIVE_RESTART,
    GL_PRIMITIVE_RESTART_FIXED_INDEX,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_ALPHA_TO_ONE,
    GL_SAMPLE_COVERAGE,
    GL_SAMPLE_MASK,
    GL_SAMPLE_SHADING,
    GL_COLOR_LOGIC_OP,
    GL_POLYGON_SMOOTH,
    GL_DITHER,
    GL_POLYGON_OFFSET_LINE,
    GL_POLYGON_OFFSET_POINT,
    GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE1,
    GL_CLIP_DISTANCE2,
    GL_CLIP_DISTANCE3,
    GL_CLIP_DISTANCE4,
    GL_CLIP_DISTANCE5,
    GL_CLIP_DISTANCE6,
    GL_CLIP_DISTANCE7,
};
/// Switches that follow from DrawState.
inline constexpr std::array<GLenum, 5> kPerPassEnables = {
    GL_DEPTH_TEST, GL_BLEND, GL_FRAMEBUFFER_SRGB, GL_POLYGON_OFFSET_FILL, GL_CULL_FACE,
};

/// How pixels lie in client memory.
inline constexpr std::array<GLenum, 16> kPixelStore = {
    GL_PACK_SWAP_BYTES,    GL_PACK_LSB_FIRST,     GL_PACK_ROW_LENGTH,     GL_PACK_SKIP_ROWS,
    GL_PACK_SKIP_PIXELS,   GL_PACK_SKIP_IMAGES,   GL_PACK_IMAGE_HEIGHT,   GL_PACK_ALIGNMENT,
    GL_UNPACK_SWAP_BYTES,  GL_UNPACK_LSB_FIRST,   GL_UNPACK_ROW_LENGTH,   GL_UNPACK_SKIP_ROWS,
    GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_ALIGNMENT,
};

/// Pixels are tightly packed, and they and query results go to and from client memory, not buffers. Every
/// upload, readback and buffer clear depends on it (a clear's value is unpacked as a pixel), so it holds for
/// as long as the engine runs: set once on a context of our own, and by StateGuard on a host's.
void applyClientTransfers();

/// Sets every piece of state that a draw of the engine depends on: the above, and to their defaults scissor,
/// stencil, masks, polygon mode, clip control (depth 0 to 1), depth range, primitive restart, sample and
/// logic operations.
void apply(const DrawState& state);
/// Only what may differ between draws of one pass.
void applyCulling(bool cullBack, bool mirrored);

}  // namespace tessera::gl
