// Forms of arithmetic that keep hard cases stable, each beside the one that textbooks print.
#pragma once

#include "engine/gl/draw_state.hpp"
#include "engine/gl/program.hpp"

namespace tessera {

/// All on unless a study asks what one of them costs, and what would happen without it.
struct NumericForms {
  bool anglesByCross = true;       // atan2 of cross and dot product; false: the acos of Mueller 2021, eq. 3.1
  bool areasByKahan = true;        // of triangles by their edges' lengths; false: Heron's formula
  bool perspectiveSamples = true;  // samples of triangles even in the picture; false: even on the surface
  bool cameraRelative = true;      // positions relative to a place near the eye; false: to the world's origin
  bool reversedDepth = true;       // 32-bit floats, 0 far; false: 24 bits, 1 far

  auto operator<=>(const NumericForms&) const = default;
};

/// What shaders are told of them.
gl::Defines definesOf(const NumericForms& forms);

/// How views of the camera compare depth. Shadow maps have their own way.
struct DepthForm {
  GLenum format = GL_DEPTH_COMPONENT32F;
  float farthest = 0.0f;
  gl::DepthTest nearer = gl::DepthTest::Greater;
  gl::DepthTest nearerOrEqual = gl::DepthTest::GreaterEqual;
};
DepthForm depthFormOf(const NumericForms& forms);

}  // namespace tessera
