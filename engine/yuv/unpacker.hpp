// From planes of video to a texture.
#pragma once

#include "engine/core/result.hpp"
#include "engine/gl/program.hpp"
#include "engine/image/yuv.hpp"

namespace tessera {

/// Move only; its context must be current. Where that is a host's, its state is left as it was.
class YuvUnpacker {
 public:
  /// Fails where a program does not compile.
  static Result<YuvUnpacker> create(const gl::Context& context);

  /// Copies the planes to the GPU and queues what turns them into texture(): every value is what toRgb gives.
  /// Planes of another size than the last make another texture. Fails as checkPlanes does; texture() then
  /// stays as it is.
  Result<void> unpack(const YuvView& planes);

  /// Of the last planes: SRGB8_ALPHA8, so that sampling gives linear colours; alpha is 1. Without a name
  /// before the first unpack().
  [[nodiscard]] const gl::Texture& texture() const { return texture_; }
  /// The same texels as RGBA8: colours as they are encoded.
  [[nodiscard]] const gl::Texture& encoded() const { return encoded_; }

 private:
  YuvUnpacker() = default;
  void resize(const YuvView& planes);
  const gl::Context* context_ = nullptr;
  gl::Program full_;     // 4:4:4
  gl::Program quarter_;  // 4:2:0
  gl::Buffer planes_;
  gl::Texture texture_;
  gl::Texture encoded_;
};

}  // namespace tessera
