#include "engine/yuv/unpacker.hpp"

#include <cstring>

#include "engine/gl/state_guard.hpp"
#include "glsl/shared/bindings.h"
#include "glsl/shared/yuv.h"

namespace tessera {

Result<YuvUnpacker> YuvUnpacker::create(const gl::Context& context) {
  const auto guard = gl::guardHost(context);
  YuvUnpacker unpacker;
  unpacker.context_ = &context;
  for (const Chroma chroma : {Chroma::Yuv444, Chroma::Yuv420}) {
    auto program =
        gl::Program::build(context, {"pass/yuv_unpack.comp"}, {{"SIDE", std::to_string(chromaSide(chroma))}});
    if (!program) return tl::unexpected(program.error());
    (chroma == Chroma::Yuv444 ? unpacker.full_ : unpacker.quarter_) = std::move(*program);
  }
  return unpacker;
}

void YuvUnpacker::resize(const YuvView& planes) {
  const std::size_t bytes = sizeof(glsl::YuvHeader) + yuvBytes(planes.width, planes.height, planes.chroma);
  if (planes_.size() < bytes) planes_ = gl::Buffer(bytes, GL_MAP_WRITE_BIT);
  if (texture_ && texture_.width() == planes.width && texture_.height() == planes.height) return;
  texture_ = gl::Texture(GL_SRGB8_ALPHA8, planes.width, planes.height);
  encoded_ = texture_.view(GL_RGBA8);
  for (gl::Texture* texture : {&texture_, &encoded_}) {
    texture->filter(GL_LINEAR, GL_LINEAR);
    texture->wrap(GL_CLAMP_TO_EDGE);
  }
}

Result<void> YuvUnpacker::unpack(const YuvView& planes) {
  if (auto good = checkPlanes(planes); !good) return good;
  const auto guard = gl::guardHost(*context_);
  resize(planes);
  const std::size_t bytes = yuvBytes(planes.width, planes.height, planes.chroma);
  // What the last pass still reads is the driver's to keep.
  auto* to = static_cast<std::uint8_t*>(
      gl::api().MapNamedBufferRange(planes_.get(), sizeof(glsl::YuvHeader), static_cast<GLsizeiptr>(bytes),
                                    GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT));
  if (to == nullptr) return fail("{} bytes of planes cannot be mapped", bytes);
  const YuvView there = yuvViewOf(to, planes.width, planes.height, planes.chroma);
  for (int plane = 0; plane < 3; ++plane) {
    const auto i = static_cast<std::size_t>(plane);
    for (int y = 0; y < planes.planeHeight(plane); ++y) {
      const auto row = static_cast<std::size_t>(y);
      std::memcpy(to + (there.planes[i] - there.planes[0]) + row * there.strides[i],
                  planes.planes[i] + row * planes.strides[i],
                  static_cast<std::size_t>(planes.planeWidth(plane)));
    }
  }
  if (gl::api().UnmapNamedBuffer(planes_.get()) == GL_FALSE)
    return fail("{} bytes of planes were lost on their way to the GPU", bytes);

  (planes.chroma == Chroma::Yuv444 ? full_ : quarter_).use();
  planes_.bindStorage(BIND_YUV_PLANES);
  gl::api().BindImageTexture(0, encoded_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
  gl::dispatchOver(planes.width, planes.height);
  gl::api().MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                          GL_FRAMEBUFFER_BARRIER_BIT);
  return {};
}

}  // namespace tessera
