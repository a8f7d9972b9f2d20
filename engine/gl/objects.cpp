#include "engine/gl/objects.hpp"

#include <algorithm>
#include <cassert>

namespace tessera::gl {

void deleteBuffer(GLuint name) { api().DeleteBuffers(1, &name); }
void deleteTexture(GLuint name) { api().DeleteTextures(1, &name); }
void deleteFramebuffer(GLuint name) { api().DeleteFramebuffers(1, &name); }
void deleteVertexArray(GLuint name) { api().DeleteVertexArrays(1, &name); }
void deleteSampler(GLuint name) { api().DeleteSamplers(1, &name); }
void deleteQuery(GLuint name) { api().DeleteQueries(1, &name); }

namespace {

constexpr std::size_t kSmallestBuffer = 16;

GLuint makeBuffer(const void* bytes, std::size_t size, GLbitfield flags) {
  GLuint name = 0;
  api().CreateBuffers(1, &name);
  if (size >= kSmallestBuffer && bytes != nullptr) {
    api().NamedBufferStorage(name, static_cast<GLsizeiptr>(size), bytes, flags);
    return name;
  }
  const std::size_t kept = std::max(size, kSmallestBuffer);
  api().NamedBufferStorage(name, static_cast<GLsizeiptr>(kept), nullptr, flags | GL_DYNAMIC_STORAGE_BIT);
  api().ClearNamedBufferData(name, GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, nullptr);
  if (bytes != nullptr && size > 0) api().NamedBufferSubData(name, 0, static_cast<GLsizeiptr>(size), bytes);
  return name;
}

std::size_t bytesPerTexel(GLenum format) {
  switch (format) {
    case GL_R8:
      return 1;
    case GL_RG8:
      return 2;
    case GL_RGBA16F:
    case GL_RG32F:
      return 8;
    case GL_RGBA32F:
      return 16;
    default:
      return 4;
  }
}

}  // namespace

Buffer::Buffer(std::size_t bytes, GLbitfield flags)
    : name_(makeBuffer(nullptr, bytes, flags)), size_(std::max(bytes, kSmallestBuffer)) {
  // Storage without initial bytes is undefined; every counter of the engine starts at zero.
  api().ClearNamedBufferData(name_.get(), GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, nullptr);
}

Buffer::Buffer(const void* bytes, std::size_t size, GLbitfield flags)
    : name_(makeBuffer(bytes, size, flags)), size_(std::max(size, kSmallestBuffer)) {}

void Buffer::bindStorage(GLuint binding) const {
  api().BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, name_.get());
}
void Buffer::bindUniform(GLuint binding) const {
  api().BindBufferBase(GL_UNIFORM_BUFFER, binding, name_.get());
}

void Buffer::write(std::size_t offset, const void* bytes, std::size_t count) {
  assert(offset + count <= size_);
  if (count > 0)
    api().NamedBufferSubData(name_.get(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(count),
                             bytes);
}

void Buffer::fill(std::uint32_t value, std::size_t offset, std::size_t count) {
  assert(offset + count <= size_);
  if (count > 0)
    api().ClearNamedBufferSubData(name_.get(), GL_R32UI, static_cast<GLintptr>(offset),
                                  static_cast<GLsizeiptr>(count), GL_RED_INTEGER, GL_UNSIGNED_INT, &value);
}

void Buffer::read(std::size_t offset, void* bytes, std::size_t count) const {
  assert(offset + count <= size_);
  api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  api().GetNamedBufferSubData(name_.get(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(count),
                              bytes);
}

Texture::Texture(GLenum format, int width, int height, int levels, int layers)
    : target_(layers > 0 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D),
      format_(format),
      width_(width),
      height_(height),
      levels_(levels),
      layers_(layers) {
  GLuint name = 0;
  api().CreateTextures(target_, 1, &name);
  name_ = Name<&deleteTexture>(name);
  if (layers > 0)
    api().TextureStorage3D(name, levels, format, width, height, layers);
  else
    api().TextureStorage2D(name, levels, format, width, height);
}

Texture Texture::view(GLenum format) const { return viewOf(target_, format, 0, layers_); }

Texture Texture::layer(int index) const {
  assert(index >= 0 && index < layers_);
  return viewOf(GL_TEXTURE_2D, format_, index, 0);
}

Texture Texture::viewOf(GLenum target, GLenum format, int firstLayer, int layers) const {
  Texture other;
  GLuint name = 0;
  api().GenTextures(1, &name);
  api().TextureView(name, target, name_.get(), format, 0, static_cast<GLuint>(levels_),
                    static_cast<GLuint>(firstLayer), static_cast<GLuint>(std::max(layers, 1)));
  other.name_ = Name<&deleteTexture>(name);
  other.target_ = target;
  other.format_ = format;
  other.width_ = width_;
  other.height_ = height_;
  other.levels_ = levels_;
  other.layers_ = layers;
  return other;
}

std::size_t Texture::bytes() const {
  std::size_t texels = 0;
  for (int level = 0; level < levels_; ++level)
    texels += static_cast<std::size_t>(std::max(width_ >> level, 1)) *
              static_cast<std::size_t>(std::max(height_ >> level, 1));
  return texels * static_cast<std::size_t>(std::max(layers_, 1)) * bytesPerTexel(format_);
}

void Texture::bind(GLuint unit) const {
  api().BindTextureUnit(unit, name_.get());
  // A sampler that was left on the unit would override the texture's own parameters.
  api().BindSampler(unit, 0);
}
void Texture::set(GLenum parameter, GLint value) { api().TextureParameteri(name_.get(), parameter, value); }

void Texture::upload(int level, GLenum format, GLenum type, const void* pixels) {
  assert(layers_ == 0);
  api().TextureSubImage2D(name_.get(), level, 0, 0, std::max(width_ >> level, 1),
                          std::max(height_ >> level, 1), format, type, pixels);
}

Sampler Sampler::make() {
  GLuint name = 0;
  api().CreateSamplers(1, &name);
  return Sampler(name);
}
void Sampler::set(GLenum parameter, GLint value) { api().SamplerParameteri(name_.get(), parameter, value); }
void Sampler::set(GLenum parameter, GLfloat value) { api().SamplerParameterf(name_.get(), parameter, value); }

Framebuffer::Framebuffer(std::span<const Texture* const> colors, const Texture* depth, int depthLayer) {
  GLuint name = 0;
  api().CreateFramebuffers(1, &name);
  name_ = Name<&deleteFramebuffer>(name);
  std::vector<GLenum> buffers;
  for (const Texture* color : colors) {
    const GLenum attachment = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(buffers.size());
    api().NamedFramebufferTexture(name, attachment, color->get(), 0);
    buffers.push_back(attachment);
  }
  if (buffers.empty()) {
    api().NamedFramebufferDrawBuffer(name, GL_NONE);
    api().NamedFramebufferReadBuffer(name, GL_NONE);
  } else {
    api().NamedFramebufferDrawBuffers(name, static_cast<GLsizei>(buffers.size()), buffers.data());
  }
  if (depth != nullptr) {
    if (depthLayer >= 0)
      api().NamedFramebufferTextureLayer(name, GL_DEPTH_ATTACHMENT, depth->get(), 0, depthLayer);
    else
      api().NamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth->get(), 0);
  }
  assert(api().CheckNamedFramebufferStatus(name, GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE);
}

VertexArray VertexArray::make() {
  GLuint name = 0;
  api().CreateVertexArrays(1, &name);
  return VertexArray(name);
}

void VertexArray::attribute(GLuint location, const Buffer& buffer, GLint components, GLsizei stride,
                            GLuint offset) {
  api().EnableVertexArrayAttrib(name_.get(), location);
  api().VertexArrayAttribFormat(name_.get(), location, components, GL_FLOAT, GL_FALSE, offset);
  api().VertexArrayAttribBinding(name_.get(), location, location);
  api().VertexArrayVertexBuffer(name_.get(), location, buffer.get(), 0, stride);
}

void VertexArray::indices(const Buffer& buffer) { api().VertexArrayElementBuffer(name_.get(), buffer.get()); }

Query::Query(GLenum target) : target_(target) {
  // Not glCreateQueries: Mesa 22.3 refuses pipeline-statistics targets there on a 4.5 context.
  GLuint name = 0;
  api().GenQueries(1, &name);
  name_ = Name<&deleteQuery>(name);
}
void Query::begin() const { api().BeginQuery(target_, name_.get()); }
void Query::end() const { api().EndQuery(target_); }
std::uint64_t Query::result() const {
  GLuint64 value = 0;
  api().GetQueryObjectui64v(name_.get(), GL_QUERY_RESULT, &value);
  return value;
}

std::vector<std::uint8_t> readTexture(const Texture& texture, GLenum format, GLenum type,
                                      std::size_t bytesPerPixel, int level) {
  const auto width = static_cast<std::size_t>(std::max(texture.width() >> level, 1));
  const auto height = static_cast<std::size_t>(std::max(texture.height() >> level, 1));
  std::vector<std::uint8_t> pixels(width * height * static_cast<std::size_t>(std::max(texture.layers(), 1)) *
                                   bytesPerPixel);
  api().MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
  api().GetTextureImage(texture.get(), level, format, type, static_cast<GLsizei>(pixels.size()),
                        pixels.data());
  return pixels;
}

}  // namespace tessera::gl
