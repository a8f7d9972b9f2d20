// GL objects: direct state access, owned by move-only values. A context must be current to make or drop one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glad/gl.h>

#include "engine/gl/context.hpp"

namespace tessera::gl {

/// A GL name that is deleted once. `Delete` is called with the name.
template <void (*Delete)(GLuint)>
class Name {
 public:
  Name() = default;
  explicit Name(GLuint value) : value_(value) {}
  Name(Name&& other) noexcept : value_(std::exchange(other.value_, 0)) {}
  Name& operator=(Name&& other) noexcept {
    if (this != &other) {
      reset();
      value_ = std::exchange(other.value_, 0);
    }
    return *this;
  }
  Name(const Name&) = delete;
  Name& operator=(const Name&) = delete;
  ~Name() { reset(); }
  [[nodiscard]] GLuint get() const { return value_; }
  [[nodiscard]] explicit operator bool() const { return value_ != 0; }

 private:
  void reset() {
    if (value_ != 0) Delete(value_);
    value_ = 0;
  }
  GLuint value_ = 0;
};

void deleteBuffer(GLuint name);
void deleteTexture(GLuint name);
void deleteFramebuffer(GLuint name);
void deleteVertexArray(GLuint name);
void deleteSampler(GLuint name);
void deleteQuery(GLuint name);

/// Immutable-storage buffer.
class Buffer {
 public:
  Buffer() = default;
  /// `bytes` of zeroes; at least 16 bytes are kept, so that an empty array can be bound.
  explicit Buffer(std::size_t bytes, GLbitfield flags = GL_DYNAMIC_STORAGE_BIT);
  template <class T>
  explicit Buffer(std::span<const T> values, GLbitfield flags = GL_DYNAMIC_STORAGE_BIT)
      : Buffer(values.data(), values.size_bytes(), flags) {}
  template <class T>
  explicit Buffer(const std::vector<T>& values, GLbitfield flags = GL_DYNAMIC_STORAGE_BIT)
      : Buffer(std::span<const T>(values), flags) {}

  [[nodiscard]] GLuint get() const { return name_.get(); }
  [[nodiscard]] explicit operator bool() const { return static_cast<bool>(name_); }
  [[nodiscard]] std::size_t size() const { return size_; }
  void bindStorage(GLuint binding) const;
  void bindUniform(GLuint binding) const;
  void write(std::size_t offset, const void* bytes, std::size_t count);
  template <class T>
  void write(std::span<const T> values, std::size_t offset = 0) {
    write(offset, values.data(), values.size_bytes());
  }
  template <class T>
  void writeValue(const T& value, std::size_t offset = 0) {
    write(offset, &value, sizeof(T));
  }
  /// Fills [offset, offset + count) bytes with a 32-bit value; multiples of 4.
  void fill(std::uint32_t value, std::size_t offset, std::size_t count);
  void fill(std::uint32_t value) { fill(value, 0, size_ / 4 * 4); }
  /// Blocking readback.
  void read(std::size_t offset, void* bytes, std::size_t count) const;
  template <class T>
  [[nodiscard]] std::vector<T> readAll(std::size_t count, std::size_t offset = 0) const {
    std::vector<T> values(count);
    if (count > 0) read(offset, values.data(), count * sizeof(T));
    return values;
  }

 private:
  Buffer(const void* bytes, std::size_t size, GLbitfield flags);
  Name<&deleteBuffer> name_;
  std::size_t size_ = 0;
};

/// Immutable-storage texture: 2D, or 2D array when layers > 0.
class Texture {
 public:
  Texture() = default;
  Texture(GLenum format, int width, int height, int levels = 1, int layers = 0);
  /// Another reading of the same storage (say RGBA8 of an SRGB8_ALPHA8 texture): all levels and layers.
  [[nodiscard]] Texture view(GLenum format) const;
  /// One layer of an array, as a 2D texture over the same storage.
  [[nodiscard]] Texture layer(int index) const;

  [[nodiscard]] GLuint get() const { return name_.get(); }
  [[nodiscard]] explicit operator bool() const { return static_cast<bool>(name_); }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int levels() const { return levels_; }
  [[nodiscard]] int layers() const { return layers_; }
  [[nodiscard]] GLenum format() const { return format_; }
  [[nodiscard]] std::size_t bytes() const;
  /// Binds to a unit, sampled by the texture's own parameters.
  void bind(GLuint unit) const;
  void set(GLenum parameter, GLint value);
  void filter(GLint min, GLint mag) {
    set(GL_TEXTURE_MIN_FILTER, min);
    set(GL_TEXTURE_MAG_FILTER, mag);
  }
  void wrap(GLint mode) {
    set(GL_TEXTURE_WRAP_S, mode);
    set(GL_TEXTURE_WRAP_T, mode);
  }
  /// Tightly packed pixels of a whole level of a 2D texture.
  void upload(int level, GLenum format, GLenum type, const void* pixels);

 private:
  [[nodiscard]] Texture viewOf(GLenum target, GLenum format, int firstLayer, int layers) const;

  Name<&deleteTexture> name_;
  GLenum target_ = GL_TEXTURE_2D;
  GLenum format_ = 0;
  int width_ = 0;
  int height_ = 0;
  int levels_ = 0;
  int layers_ = 0;
};

class Sampler {
 public:
  Sampler() = default;
  static Sampler make();
  [[nodiscard]] GLuint get() const { return name_.get(); }
  void set(GLenum parameter, GLint value);
  void set(GLenum parameter, GLfloat value);

 private:
  explicit Sampler(GLuint name) : name_(name) {}
  Name<&deleteSampler> name_;
};

/// A framebuffer over textures. Colour attachments in order; depth optional.
class Framebuffer {
 public:
  Framebuffer() = default;
  explicit Framebuffer(std::span<const Texture* const> colors, const Texture* depth = nullptr,
                       int depthLayer = -1);
  [[nodiscard]] GLuint get() const { return name_.get(); }
  [[nodiscard]] explicit operator bool() const { return static_cast<bool>(name_); }

 private:
  Name<&deleteFramebuffer> name_;
};

class VertexArray {
 public:
  VertexArray() = default;
  static VertexArray make();
  [[nodiscard]] GLuint get() const { return name_.get(); }
  /// Float attribute `location` of `components` from a tightly packed buffer of its own.
  void attribute(GLuint location, const Buffer& buffer, GLint components, GLsizei stride, GLuint offset = 0);
  void indices(const Buffer& buffer);

 private:
  explicit VertexArray(GLuint name) : name_(name) {}
  Name<&deleteVertexArray> name_;
};

class Query {
 public:
  Query() = default;
  explicit Query(GLenum target);
  [[nodiscard]] explicit operator bool() const { return static_cast<bool>(name_); }
  void begin() const;
  void end() const;
  /// Waits for the result.
  [[nodiscard]] std::uint64_t result() const;

 private:
  Name<&deleteQuery> name_;
  GLenum target_ = 0;
};

/// Reads a level of a texture back as tightly packed pixels, blocking.
std::vector<std::uint8_t> readTexture(const Texture& texture, GLenum format, GLenum type,
                                      std::size_t bytesPerPixel, int level = 0);

}  // namespace tessera::gl
