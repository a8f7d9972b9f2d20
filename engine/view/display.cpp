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
  if (options.lens)
    if (auto good = check(*options.lens); !good) return tl::unexpected(good.error());
  StreamedDisplay display;
  display.context_ = &context;
  display.options_ = options;
  const auto guard = gl::guardHost(context);
  display.programs_ = std::make_unique<gl::ProgramCache>(context);
  auto far = display.programs_->get({"pass/streamed_far.vert", "pass/streamed_far.frag"});
  if (!far) return tl::unexpected(far.error());
  display.far_ = *far;
  if (options.lens) {
    auto lens = LensPass::create(*display.programs_);
    if (!lens) return tl::unexpected(lens.error());
    display.lens_ = *lens;
  }
  auto atlas = YuvUnpacker::create(context);
  if (!atlas) return tl::unexpected(atlas.error());
  display.atlas_.emplace(std::move(*atlas));
  display.vertexArray_ = gl::VertexArray::make();
  display.indexed_ = gl::VertexArray::make();
  display.farSamples_ = gl::Query(GL_SAMPLES_PASSED);
  return display;
}

Result<void> StreamedDisplay::prepare(const ShadedFrame& frame) {
  gl::Defines defines;
  if (frame.method == wire::Method::Tess) defines["TESS"] = "";
  if (!frame.masks->empty()) defines["MASK"] = "";
  auto program = programs_->get({"pass/streamed.vert", "pass/streamed.frag"}, defines);
  if (!program) return tl::unexpected(program.error());
  order_.take(frame);
  const gl::Program* blended = nullptr;
  if (!order_.empty()) {
    defines["BLEND"] = "";
    auto own = programs_->get({"pass/streamed.vert", "pass/streamed.frag"}, defines);
    if (!own) return tl::unexpected(own.error());
    blended = *own;
  }
  program_ = *program;
  blended_ = blended;
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

bool StreamedDisplay::Picture::resize(int width, int height, const gl::Texture* depth) {
  if (color && color.width() == width && color.height() == height) return false;
  *this = {};
  color = gl::Texture(GL_SRGB8_ALPHA8, width, height);
  color.filter(GL_LINEAR, GL_LINEAR);
  color.wrap(GL_CLAMP_TO_EDGE);
  encoded = color.view(GL_RGBA8);
  const std::array<const gl::Texture*, 1> colors = {&encoded};
  copy = gl::Framebuffer(colors, depth);
  gl::api().ClearTexImage(color.get(), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  return true;
}

void StreamedDisplay::begin(const wire::Camera& camera) {
  const int width = static_cast<int>(camera.width);
  const int height = static_cast<int>(camera.height);
  if (!depth_ || depth_.width() != width || depth_.height() != height)
    depth_ = gl::Texture(GL_DEPTH_COMPONENT32F, width, height);
  if (picture_.resize(width, height, &depth_)) {
    const std::array<const gl::Texture*, 1> linear = {&picture_.color};
    linearFramebuffer_ = gl::Framebuffer(linear, &depth_);
  }
  gl::api().BindFramebuffer(GL_FRAMEBUFFER, picture_.copy.get());
  gl::apply({.depth = gl::DepthTest::Greater, .depthWrite = true});
  constexpr float kFarthest = 0.0f;
  gl::api().ClearNamedFramebufferfv(picture_.copy.get(), GL_DEPTH, 0, &kFarthest);
  gl::api().BindVertexArray(vertexArray_.get());
}

void StreamedDisplay::bind(const gl::Program& program, const wire::Camera& camera, Region part) {
  gl::api().Viewport(part.x, 0, part.width, static_cast<int>(camera.height));
  // In double up to here: what remains are the distances that the picture is made of.
  std::vector<glm::vec4> rows;
  rows.reserve(3 * transforms_.size());
  for (const wire::ObjectTransform& object : transforms_)
    for (int row = 0; row < 3; ++row)
      rows.emplace_back(object.world[0][row], object.world[1][row], object.world[2][row],
                        object.world[3][row] - camera.eye[row]);
  store(objects_, rows);
  program.use();
  const glm::mat4 toClip(viewProjection(camera));
  const glm::vec3 shaded(shadedEye_ - camera.eye);
  const glm::vec2 texel(1.0f / static_cast<float>(atlas_->texture().width()),
                        1.0f / static_cast<float>(atlas_->texture().height()));
  gl::api().ProgramUniformMatrix4fv(program.get(), LOCATION_VIEW, 1, GL_FALSE, glm::value_ptr(toClip));
  gl::api().ProgramUniform3fv(program.get(), LOCATION_STREAMED_SHADED, 1, &shaded.x);
  gl::api().ProgramUniform2fv(program.get(), LOCATION_SIZE, 1, &texel.x);
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
}

void StreamedDisplay::drawOpaque(const wire::Camera& camera, Region part) {
  if (program_ == nullptr || triangleCount_ == 0) return;
  bind(*program_, camera, part);
  gl::api().DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * triangleCount_));
}

void StreamedDisplay::drawBlended(const wire::Camera& camera, Region part) {
  const std::vector<std::uint32_t>& corners = order_.sorted(camera);
  if (corners.empty()) return;
  store(indices_, corners);
  gl::api().VertexArrayElementBuffer(indexed_.get(), indices_.get());
  bind(*blended_, camera, part);
  gl::api().DrawElements(GL_TRIANGLES, static_cast<GLsizei>(corners.size()), GL_UNSIGNED_INT, nullptr);
}

void StreamedDisplay::drawBackground() {
  gl::api().Viewport(0, 0, picture_.color.width(), picture_.color.height());
  gl::apply({.depth = gl::DepthTest::GreaterEqual});
  const glm::vec3& b = options_.background;
  const glm::vec4 background(glsl::encodeSrgb(b.r), glsl::encodeSrgb(b.g), glsl::encodeSrgb(b.b), 0.0f);
  far_->use();
  gl::api().ProgramUniform4fv(far_->get(), LOCATION_BACKGROUND, 1, &background.x);
  farSamples_.begin();
  gl::api().DrawArrays(GL_TRIANGLES, 0, 3);
  farSamples_.end();
  counted_ = true;
}

void StreamedDisplay::drawParts(const wire::Camera& whole, std::span<const Part> parts) {
  begin(whole);
  for (const Part& part : parts) drawOpaque(part.camera, part.region);
  drawBackground();
  if (!order_.empty()) {
    // As the engine: over the background too, in linear light.
    gl::api().BindFramebuffer(GL_FRAMEBUFFER, linearFramebuffer_.get());
    gl::apply({.depth = gl::DepthTest::GreaterEqual, .blend = true, .encodeSrgb = true});
    gl::api().BindVertexArray(indexed_.get());
    for (const Part& part : parts) drawBlended(part.camera, part.region);
  }
  if (lens_) seeThroughLens(parts);
  gl::api().MemoryBarrier(GL_FRAMEBUFFER_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                          GL_TEXTURE_UPDATE_BARRIER_BIT);
}

void StreamedDisplay::seeThroughLens(std::span<const Part> parts) {
  lensed_.resize(picture_.color.width(), picture_.color.height());
  if (parts.size() == 1) return lens_->draw(picture_.color, lensed_.encoded, *options_.lens);
  const int height = picture_.color.height();
  const auto copy = [height](const Picture& from, int fromX, const Picture& to, int toX, int width) {
    gl::api().CopyImageSubData(from.color.get(), GL_TEXTURE_2D, 0, fromX, 0, 0, to.color.get(), GL_TEXTURE_2D,
                               0, toX, 0, 0, width, height, 1);
  };
  for (const Part& part : parts) {
    eye_.resize(part.region.width, height);
    lensedEye_.resize(part.region.width, height);
    copy(picture_, part.region.x, eye_, 0, part.region.width);
    lens_->draw(eye_.color, lensedEye_.encoded, *options_.lens);
    gl::api().MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    copy(lensedEye_, 0, lensed_, part.region.x, part.region.width);
  }
}

void StreamedDisplay::draw(const wire::Camera& camera) {
  const auto guard = gl::guardHost(*context_);
  const std::array parts = {Part{camera, {0, static_cast<int>(camera.width)}}};
  drawParts(camera, parts);
}

void StreamedDisplay::drawStereo(const wire::Camera& camera, double eyeDistance) {
  const auto guard = gl::guardHost(*context_);
  const int half = static_cast<int>(camera.width) / 2;
  if (half == 0) return draw(camera);
  const wire::Camera narrow = resized(camera, static_cast<std::uint32_t>(half), camera.height);
  const std::array parts = {Part{eyeOf(narrow, eyeDistance, -1), {0, half}},
                            Part{eyeOf(narrow, eyeDistance, 1), {half, half}}};
  drawParts(camera, parts);
}

Image StreamedDisplay::read() const {
  const gl::Texture& encoded = shown().encoded;
  return flipped(encoded.width(), encoded.height(), gl::readTexture(encoded, GL_RGBA, GL_UNSIGNED_BYTE, 4));
}

void StreamedDisplay::blit(unsigned framebuffer, int width, int height) const {
  if (!shown().copy) return;
  const auto guard = gl::guardHost(*context_);
  gl::apply({});
  const int w = std::min(width, shown().color.width());
  const int h = std::min(height, shown().color.height());
  gl::api().BlitNamedFramebuffer(shown().copy.get(), framebuffer, 0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT,
                                 GL_NEAREST);
}

std::optional<std::uint64_t> StreamedDisplay::uncovered() const {
  if (!counted_) return std::nullopt;
  return farSamples_.result();
}

}  // namespace tessera::view
