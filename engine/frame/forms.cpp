#include "engine/frame/forms.hpp"

namespace tessera {

gl::Defines definesOf(const NumericForms& forms) {
  gl::Defines defines;
  if (!forms.anglesByCross) defines["ANGLES_BY_ACOS"] = "1";
  if (!forms.areasByKahan) defines["AREAS_BY_HERON"] = "1";
  if (!forms.perspectiveSamples) defines["SURFACE_SAMPLES"] = "1";
  return defines;
}

DepthForm depthFormOf(const NumericForms& forms) {
  if (forms.reversedDepth) return {};
  return {GL_DEPTH_COMPONENT24, 1.0f, gl::DepthTest::Less, gl::DepthTest::LessEqual};
}

}  // namespace tessera
