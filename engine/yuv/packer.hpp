// From a texture to planes of video: a compute pass, and copies that arrive without a stall.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/core/result.hpp"
#include "engine/gl/program.hpp"
#include "engine/gl/readback.hpp"
#include "engine/image/yuv.hpp"

namespace tessera {

/// Move only; its context must be current. Where that is a host's, its state is left as it was.
class YuvPacker {
 public:
  /// For textures of one size, sides in [1, kMaxImageSide]. `slots`, [2, 16], is how many frames the GPU may
  /// be behind, plus one. Fails where a program does not compile and where a side is out of range.
  static Result<YuvPacker> create(const gl::Context& context, int width, int height, Chroma chroma,
                                  std::size_t slots = 3);

  /// Queues what turns the texture, RGBA8 with display-encoded colours, into planes, and their copy to
  /// memory, under the frame's number. Alpha is left out. Every value is what toYuv gives. Never waits; while
  /// every slot is under way the frame is left out. Fails for a texture of another size or format.
  Result<void> pack(const gl::Texture& encoded, std::uint32_t frame);

  struct Packed {
    std::uint32_t frame = 0;
    YuvView planes;  // valid until the next pack()
  };
  /// The newest frame that has arrived; nothing before the first has. Never waits.
  [[nodiscard]] std::optional<Packed> latest();

  struct Read {
    std::uint32_t frame = 0;
    YuvImage planes;
  };
  /// The frame that was packed last, once it is there: waits for the GPU. Nothing before the first pack().
  [[nodiscard]] std::optional<Read> read() const;

 private:
  YuvPacker() = default;
  const gl::Context* context_ = nullptr;
  gl::Program program_;
  gl::Buffer planes_;
  gl::Readback readback_;
  int width_ = 0;
  int height_ = 0;
  Chroma chroma_ = Chroma::Yuv420;
  bool packed_ = false;
};

}  // namespace tessera
