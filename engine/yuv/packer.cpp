#include "engine/yuv/packer.hpp"

#include <cstring>

#include "engine/gl/state_guard.hpp"
#include "glsl/shared/bindings.h"
#include "glsl/shared/yuv.h"

namespace tessera {

namespace {

constexpr int kTexelsWide = 8;  // of a thread in yuv_pack.comp
constexpr int kTexelsHigh = 2;

}  // namespace

Result<YuvPacker> YuvPacker::create(const gl::Context& context, int width, int height, Chroma chroma,
                                    std::size_t slots) {
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide)
    return fail("planes of {} x {}: sides must be in [1, {}]", width, height, kMaxImageSide);
  if (slots < 2 || slots > 16) return fail("planes: {} slots are outside [2, 16]", slots);
  const auto guard = gl::guardHost(context);
  auto program =
      gl::Program::build(context, {"pass/yuv_pack.comp"}, {{"SIDE", std::to_string(chromaSide(chroma))}});
  if (!program) return tl::unexpected(program.error());
  const std::size_t bytes = sizeof(glsl::YuvHeader) + yuvBytes(width, height, chroma);
  YuvPacker packer;
  packer.context_ = &context;
  packer.program_ = std::move(*program);
  packer.planes_ = gl::Buffer(bytes);
  packer.readback_ = gl::Readback(bytes, slots);
  packer.width_ = width;
  packer.height_ = height;
  packer.chroma_ = chroma;
  return packer;
}

Result<void> YuvPacker::pack(const gl::Texture& encoded, std::uint32_t frame) {
  if (encoded.width() != width_ || encoded.height() != height_)
    return fail("a texture of {} x {} for planes of {} x {}", encoded.width(), encoded.height(), width_,
                height_);
  if (encoded.format() != GL_RGBA8)
    return fail("a texture of format {:#x} for planes: wanted is RGBA8, display-encoded", encoded.format());
  const auto guard = gl::guardHost(*context_);
  // Shading may have stored into it from compute.
  gl::api().MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  program_.use();
  program_.set(LOCATION_FRAME, frame);
  encoded.bind(UNIT_PICTURE);
  planes_.bindStorage(BIND_YUV_PLANES);
  gl::dispatchOver((width_ + kTexelsWide - 1) / kTexelsWide, (height_ + kTexelsHigh - 1) / kTexelsHigh);
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  readback_.request(planes_);
  packed_ = true;
  return {};
}

std::optional<YuvPacker::Packed> YuvPacker::latest() {
  const auto* bytes = static_cast<const std::uint8_t*>(readback_.latest());
  if (bytes == nullptr) return std::nullopt;
  glsl::YuvHeader header{};
  std::memcpy(&header, bytes, sizeof(header));
  return Packed{header.frame, yuvViewOf(bytes + sizeof(header), width_, height_, chroma_)};
}

std::optional<YuvPacker::Read> YuvPacker::read() const {
  if (!packed_) return std::nullopt;
  const auto guard = gl::guardHost(*context_);
  glsl::YuvHeader header{};
  Read result{.frame = 0, .planes = YuvImage(width_, height_, chroma_)};
  planes_.read(0, &header, sizeof(header));
  planes_.read(sizeof(header), result.planes.bytes.data(), result.planes.bytes.size());
  result.frame = header.frame;
  return result;
}

}  // namespace tessera
