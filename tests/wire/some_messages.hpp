// One message of each kind, with values that are not the defaults.
#pragma once

#include <vector>

#include "codec/wire/message.hpp"

namespace tessera::test {

inline wire::Camera someCamera() {
  wire::Camera camera;
  camera.eye = {1.5, -2.25, 1e6};
  camera.orientation = {0.5, -0.5, 0.5, 0.5};
  camera.slopes = {-1.1, 0.9, -0.7, 0.6};
  camera.zNear = 0.01;
  camera.width = 1832;
  camera.height = 1920;
  return camera;
}
inline wire::FrameHeader someFrame(std::uint32_t number) {
  wire::FrameHeader frame;
  frame.frame = number;
  frame.iFrame = true;
  frame.background = 0.25f;
  frame.pose = 8;
  frame.time = 12.5;
  frame.camera = someCamera();
  wire::SentLight light;
  light.type = wire::FrameLight::Directional;
  light.radiance = {1, 2, 3};
  frame.lights.push_back(light);
  light.type = wire::FrameLight::Spot;
  light.position = {4, 5, 6};
  light.radiance = {7, 8, 9};
  light.range = 10.0f;
  light.innerCone = 0.1f;
  light.outerCone = 0.2f;
  frame.lights.push_back(light);
  return frame;
}
inline wire::StreamSetup someSetup() {
  wire::StreamSetup setup;
  setup.method = wire::Method::Tess;
  setup.chroma = wire::Chroma::C444;
  setup.fullRange = true;
  setup.width = 2048;
  setup.height = 2100;
  setup.fpsNumerator = 30000;
  setup.fpsDenominator = 1001;
  setup.paths = 1;
  setup.start = someCamera();
  setup.video = "v=0\r\nm=video 5004 RTP/AVP 96\r\n";
  return setup;
}
inline wire::Pose somePose(std::uint32_t number) { return {number, 3.25, someCamera()}; }
inline wire::MaskImage someMask() {
  return {3, 3, 2, wire::Wrap::Clamp, wire::Wrap::Mirror, 0.25f, {0, 9, 255, 3, 4, 5}};
}
inline wire::Path somePath() {
  return {"tour", {{-1.0, {1, 2, 3}, {4, 5, 6}, 60.0}, {2.5, {7, 8, 9}, {7, 8, -9}, 45.0}}};
}

inline std::vector<wire::Message> someMessages() {
  return {wire::Hello{{1, 4}, wire::Role::Server, "token"},
          wire::Refusal{wire::RefusalReason::Busy, {1, 2}, "two viewers are here already"},
          someSetup(),
          somePath(),
          someFrame(5),
          wire::Geometry{5, {1, 2, 3, 4, 5, 6, 7}},
          someMask(),
          wire::Acknowledge{5, 4, 99.5},
          somePose(8),
          wire::AskIFrame{4}};
}

}  // namespace tessera::test
