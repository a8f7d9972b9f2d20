// A stream's frames without an engine: one triangle in an atlas of one colour.
#pragma once

#include "codec/wire/visible_delta.hpp"
#include "engine/view/frame_pairs.hpp"

namespace tessera::test {

class OnePatch {
 public:
  OnePatch() {
    source_.method = wire::Method::Rect;
    source_.vertices = {{{0, 0, -2}, 0, {}}, {{1, 0, -2}, 0, {}}, {{0, 1, -2}, 0, {}}};
    wire::SourceElement element;
    element.vertex = {0, 1, 2, 0, 0};
    element.triangles = 1;
    source_.elements = {element};
    delta_ = std::make_unique<wire::VisibleDelta>(source_);
  }
  static wire::StreamSetup setup() {
    wire::StreamSetup setup;
    setup.width = setup.height = 64;
    setup.fullRange = true;
    return setup;
  }
  static wire::FrameHeader header(std::uint32_t frame) {
    wire::FrameHeader header;
    header.frame = frame;
    return header;
  }
  /// The triangle in a block at (x, 0); frames in order.
  wire::Geometry geometry(std::uint32_t frame, std::uint32_t x) {
    wire::VisibleElement element;
    element.id = 0;
    element.words = {x, 2u | 2u << 4u};
    wire::ObjectTransform object;
    wire::PixelBound bound{};
    return {frame, delta_->next({{&element, 1}, {&object, 1}, {}, bound, {}})};
  }
  static view::Picture picture(std::uint32_t frame, std::uint8_t grey) {
    view::Picture picture;
    picture.frame = frame;
    picture.planes = YuvImage(64, 64, Chroma::Yuv444);
    std::fill(picture.planes.bytes.begin(), picture.planes.bytes.end(), grey);
    return picture;
  }

 private:
  wire::GeometrySource source_;
  std::unique_ptr<wire::VisibleDelta> delta_;
};

}  // namespace tessera::test
