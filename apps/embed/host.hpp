// What a host has before it embeds anything: a GL context of its own and a framebuffer that it draws to.
#pragma once

#include <memory>
#include <optional>

#include <glad/gl.h>
#include <glm/glm.hpp>

#include "engine/core/result.hpp"
#include "engine/gl/context.hpp"

namespace embed {

using tessera::Result;

class Host {
 public:
  virtual ~Host() = default;
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  /// The GL functions, by name, of the context that is current.
  [[nodiscard]] virtual tessera::gl::GetProc loader() const = 0;
  /// Ends a picture. False when there is no next one.
  virtual bool present() = 0;
  /// The cursor in pixels of the framebuffer from its top left; none where there is no window.
  [[nodiscard]] virtual std::optional<glm::dvec2> cursor() const { return std::nullopt; }
  /// How often the F key went down since the last call; 0 where there is no window.
  [[nodiscard]] virtual int togglePresses() { return 0; }

  [[nodiscard]] const GladGLContext& gl() const { return gl_; }
  [[nodiscard]] GLuint framebuffer() const { return framebuffer_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

 protected:
  Host() = default;
  GladGLContext gl_{};
  GLuint framebuffer_ = 0;
  int width_ = 0;
  int height_ = 0;
};

/// A context without a window (EGL, surfaceless) and a framebuffer object; one picture. Sides in [64, 8192].
Result<std::unique_ptr<Host>> makeSurfaceless(int width, int height);
/// A window (GLFW), pictures until it is closed. Fails where there is no display, or GLFW was not there at
/// build.
Result<std::unique_ptr<Host>> makeWindow(int width, int height);

}  // namespace embed
