#include "engine/view/display.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include <glm/gtc/type_ptr.hpp>

#include "codec/wire/mask.hpp"
#include "engine/gl/draw_state.hpp"
#include "engine/gl/state_guard.hpp"
#include "engine/view/camera.hpp"
#include "glsl/shared/streamed_bindings.h"
#include "glsl/shared/streamed_mask.h"
#include "glsl/shared/tone.h"

namespace tessera::view {

namespace {

/// Writes an array into a buffer that only grows: frames differ in size by a little all the time.
template <class T>
void store(gl::Buffer& buffer, std::span<const T> values) {
  if (buffer.size() < values.size_bytes() || !buffer)
    buffer = gl::Buffer(std::bit_ceil(std::max<std::size_t>(values.size_bytes(), 256)));
  if (!values.empty()) buffer.write(values);
}
template <class T>
void store(gl::Buffer& buffer, const std::vector<T>& values) {
  store(buffer, std::span<const T>(values));
}

/// A mask and its levels, each the mean of four texels of the last, appended to `alpha`.
glsl::StreamedMask appendMask(const wire::MaskImage& mask, std::vector<std::uint8_t>& alpha) {
  glsl::StreamedMask gpu{};
  gpu.start = static_cast<std::uint32_t>(alpha.size());
  gpu.width = mask.width;
  gpu.height = mask.height;
  gpu.levels = static_cast<std::uint32_t>(std::bit_width(std::max(mask.width, mask.height)));
  gpu.wrapAcross = static_cast<std::uint32_t>(mask.across);
  gpu.wrapUp = static_cast<std::uint32_t>(mask.up);
  gpu.cutoff = mask.cutoff;
  wire::AlphaPlane level{mask.width, mask.height, mask.alpha};
  for (std::uint32_t i = 0; i < gpu.levels; ++i) {
    alpha.insert(alpha.end(), level.alpha.begin(), level.alpha.end());
    level = wire::halved(level.width, level.height, level.alpha);
  }
  return gpu;
}

}  // namespace

Result<StreamedDisplay> StreamedDisplay::create(const gl::Context& context, const DisplayOptions& options) {
  StreamedDisplay display;
  display.context_ = &context;
  display.options_ = options;
  const auto guard = gl::guardHost(context);
  display.programs_ = std::make_unique<gl::ProgramCache>(context);
  auto far = display.programs_->get({"pass/streamed_far.vert", "pass/streamed_far.frag"});
  if (!far) return tl::unexpected(far.error());
  display.far_ = *far;
  auto atlas = YuvUnpacker::create(context);
  if (!atlas) return tl::unexpected(atlas.error());
  display.atlas_.emplace(std::move(*atlas));
  display.vertexArray_ = gl::VertexArray::make();
  display.farSamples_ = gl::Query(GL_SAMPLES_PASSED);
  return display;
}

Result<void> StreamedDisplay::prepare(const ShadedFrame& frame) {
  gl::Defines defines;
  if (frame.method == wire::Method::Tess) defines["TESS"] = "";
  if (!frame.masks->empty()) defines["MASK"] = "";
  auto program = programs_->get({"pass/streamed.vert", "pass/streamed.frag"}, defines);
  if (!program) return tl::unexpected(program.error());
  program_ = *program;
  return {};
}

void StreamedDisplay::uploadMasks(const ShadedFrame& frame) {
  if (uploadedMasks_ == frame.masks) return;
  uploadedMasks_ = frame.masks;
  std::vector<glsl::StreamedMask> masks;
  std::vector<std::uint8_t> alpha;
  for (const wire::MaskImage& mask : *frame.masks) {
    if (masks.size() <= mask.number) masks.resize(std::size_t{mask.number} + 1);
    masks[mask.number] = appendMask(mask, alpha);
  }
  alpha.resize((alpha.size() + 3) / 4 * 4);
  // Made anew: the shader asks for the array's length.
  masks_ = gl::Buffer(masks);
  alpha_ = gl::Buffer(alpha);
}

Result<void> StreamedDisplay::upload(const ShadedFrame& frame) {
  const auto guard = gl::guardHost(*context_);
  if (auto done = prepare(frame); !done) return done;
  if (auto done = atlas_->unpack(frame.atlas.view()); !done) return done;
  store(vertices_, frame.vertices);
  store(maskAt_, frame.maskAt);
  store(triangles_, frame.triangles);
  if (frame.method == wire::Method::Tess)
    store(elements_, frame.tess);
  else
    store(elements_, frame.patches);
  store(pieces_, frame.pieces);
  uploadMasks(frame);
  transforms_ = frame.objects;
  triangleCount_ = frame.triangles.size();
  shadedEye_ = frame.header.camera.eye;
  return {};
}

void StreamedDisplay::begin(const wire::Camera& camera) {
  const int width = static_cast<int>(camera.width);
  const int height = static_cast<int>(camera.height);
  if (!color_ || color_.width() != width || color_.height() != height) {
    color_ = gl::Texture(GL_SRGB8_ALPHA8, width, height);
    encoded_ = color_.view(GL_RGBA8);
    depth_ = gl::Texture(GL_DEPTH_COMPONENT32F, width, height);
    const std::array<const gl::Texture*, 1> colors = {&encoded_};
    framebuffer_ = gl::Framebuffer(colors, &depth_);
  }
  gl::api().BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  gl::apply({.depth = gl::DepthTest::Greater, .depthWrite = true});
  constexpr float kFarthest = 0.0f;
  gl::api().ClearNamedFramebufferfv(framebuffer_.get(), GL_DEPTH, 0, &kFarthest);
  gl::api().BindVertexArray(vertexArray_.get());
}

void StreamedDisplay::drawPart(const wire::Camera& camera, Region part) {
  gl::api().Viewport(part.x, 0, part.width, static_cast<int>(camera.height));
  if (program_ == nullptr || triangleCount_ == 0) return;
  // In double up to here: what remains are the distances that the picture is made of.
  std::vector<glm::vec4> rows;
  rows.reserve(3 * transforms_.size());
  for (const wire::ObjectTransform& object : transforms_)
    for (int row = 0; row < 3; ++row)
      rows.emplace_back(object.world[0][row], object.world[1][row], object.world[2][row],
                        object.world[3][row] - camera.eye[row]);
  store(objects_, rows);
  program_->use();
  const glm::mat4 toClip(viewProjection(camera));
  const glm::vec3 shaded(shadedEye_ - camera.eye);
  const glm::vec2 texel(1.0f / static_cast<float>(atlas_->texture().width()),
                        1.0f / static_cast<float>(atlas_->texture().height()));
  gl::api().ProgramUniformMatrix4fv(program_->get(), LOCATION_VIEW, 1, GL_FALSE, glm::value_ptr(toClip));
  gl::api().ProgramUniform3fv(program_->get(), LOCATION_STREAMED_SHADED, 1, &shaded.x);
  gl::api().ProgramUniform2fv(program_->get(), LOCATION_SIZE, 1, &texel.x);
  vertices_.bindStorage(BIND_STREAMED_VERTICES);
  triangles_.bindStorage(BIND_STREAMED_TRIANGLES);
  elements_.bindStorage(BIND_STREAMED_ELEMENTS);
  pieces_.bindStorage(BIND_STREAMED_PIECES);
  objects_.bindStorage(BIND_STREAMED_OBJECTS);
  maskAt_.bindStorage(BIND_STREAMED_MASK_AT);
  masks_.bindStorage(BIND_STREAMED_MASKS);
  alpha_.bindStorage(BIND_STREAMED_ALPHA);
  // Encoded texels to an encoded picture, as the engine displays an atlas of 8 bits.
  atlas_->encoded().bind(UNIT_ATLAS);
  gl::api().DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * triangleCount_));
}

void StreamedDisplay::end() {
  gl::api().Viewport(0, 0, color_.width(), color_.height());
  gl::apply({.depth = gl::DepthTest::GreaterEqual});
  const glm::vec3& b = options_.background;
  const glm::vec4 background(glsl::encodeSrgb(b.r), glsl::encodeSrgb(b.g), glsl::encodeSrgb(b.b), 0.0f);
  far_->use();
  gl::api().ProgramUniform4fv(far_->get(), LOCATION_BACKGROUND, 1, &background.x);
  farSamples_.begin();
  gl::api().DrawArrays(GL_TRIANGLES, 0, 3);
  farSamples_.end();
  counted_ = true;
  gl::api().MemoryBarrier(GL_FRAMEBUFFER_BARRIER_BIT);
}

void StreamedDisplay::draw(const wire::Camera& camera) {
  const auto guard = gl::guardHost(*context_);
  begin(camera);
  drawPart(camera, {0, static_cast<int>(camera.width)});
  end();
}

void StreamedDisplay::drawStereo(const wire::Camera& camera, double eyeDistance) {
  const auto guard = gl::guardHost(*context_);
  const int half = static_cast<int>(camera.width) / 2;
  if (half == 0) return draw(camera);
  begin(camera);
  const wire::Camera narrow = resized(camera, static_cast<std::uint32_t>(half), camera.height);
  drawPart(eyeOf(narrow, eyeDistance, -1), {0, half});
  drawPart(eyeOf(narrow, eyeDistance, 1), {half, half});
  end();
}

Image StreamedDisplay::read() const {
  return flipped(color_.width(), color_.height(), gl::readTexture(encoded_, GL_RGBA, GL_UNSIGNED_BYTE, 4));
}

void StreamedDisplay::blit(unsigned framebuffer, int width, int height) const {
  if (!framebuffer_) return;
  const auto guard = gl::guardHost(*context_);
  gl::apply({});
  const int w = std::min(width, color_.width());
  const int h = std::min(height, color_.height());
  gl::api().BlitNamedFramebuffer(framebuffer_.get(), framebuffer, 0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT,
                                 GL_NEAREST);
}

std::optional<std::uint64_t> StreamedDisplay::uncovered() const {
  if (!counted_) return std::nullopt;
  return farSamples_.result();
}

}  // namespace tessera::view
