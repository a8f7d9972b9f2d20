#include "host.hpp"

#include <array>
#include <utility>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#ifdef EMBED_HAS_GLFW
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#endif

namespace embed {

namespace {

using tessera::fail;

class SurfacelessHost final : public Host {
 public:
  static Result<std::unique_ptr<Host>> create(int width, int height) {
    auto host = std::unique_ptr<SurfacelessHost>(new SurfacelessHost);
    host->width_ = width;
    host->height_ = height;
    const auto getDisplay =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (getDisplay != nullptr)
      host->display_ = getDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (host->display_ == EGL_NO_DISPLAY || eglInitialize(host->display_, nullptr, nullptr) == EGL_FALSE ||
        eglBindAPI(EGL_OPENGL_API) == EGL_FALSE)
      return fail("EGL: no surfaceless display with OpenGL ({:#x})", eglGetError());
    const std::array<EGLint, 7> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                              4,
                                              EGL_CONTEXT_MINOR_VERSION,
                                              5,
                                              EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                              EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                              EGL_NONE};
    host->context_ = eglCreateContext(host->display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    if (host->context_ == EGL_NO_CONTEXT ||
        eglMakeCurrent(host->display_, EGL_NO_SURFACE, EGL_NO_SURFACE, host->context_) == EGL_FALSE ||
        gladLoadGLContext(&host->gl_, &eglGetProcAddress) == 0)
      return fail("EGL: no core context of OpenGL 4.5 ({:#x})", eglGetError());
    host->makeFramebuffer();
    return host;
  }
  ~SurfacelessHost() override {
    if (framebuffer_ != 0) {
      gl_.DeleteFramebuffers(1, &framebuffer_);
      gl_.DeleteTextures(1, &color_);
    }
    if (context_ == EGL_NO_CONTEXT) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }
  [[nodiscard]] tessera::gl::GetProc loader() const override { return &eglGetProcAddress; }
  bool present() override { return false; }

 private:
  SurfacelessHost() = default;
  void makeFramebuffer() {
    gl_.CreateTextures(GL_TEXTURE_2D, 1, &color_);
    gl_.TextureStorage2D(color_, 1, GL_RGBA8, width_, height_);
    gl_.CreateFramebuffers(1, &framebuffer_);
    gl_.NamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, color_, 0);
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  GLuint color_ = 0;
};

#ifdef EMBED_HAS_GLFW

class WindowHost final : public Host {
 public:
  static Result<std::unique_ptr<Host>> create(int width, int height) {
    auto host = std::unique_ptr<WindowHost>(new WindowHost);
    if (glfwInit() == GLFW_FALSE) return fail("no window: {}", lastError());
    host->initialized_ = true;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    host->window_ = glfwCreateWindow(width, height, "embed: a host of tessera", nullptr, nullptr);
    if (host->window_ == nullptr) return fail("no window with OpenGL 4.5: {}", lastError());
    glfwMakeContextCurrent(host->window_);
    if (gladLoadGLContext(&host->gl_, &glfwGetProcAddress) == 0)
      return fail("the window's GL functions cannot be loaded");
    glfwGetFramebufferSize(host->window_, &host->width_, &host->height_);
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(host->window_, host.get());
    glfwSetKeyCallback(host->window_, [](GLFWwindow* window, int key, int, int action, int) {
      if (key == GLFW_KEY_F && action == GLFW_PRESS)
        ++static_cast<WindowHost*>(glfwGetWindowUserPointer(window))->presses_;
    });
    return host;
  }
  ~WindowHost() override {
    if (initialized_) glfwTerminate();
  }
  [[nodiscard]] tessera::gl::GetProc loader() const override { return &glfwGetProcAddress; }
  bool present() override {
    glfwSwapBuffers(window_);
    glfwPollEvents();
    return glfwWindowShouldClose(window_) == GLFW_FALSE;
  }
  [[nodiscard]] std::optional<glm::dvec2> cursor() const override {
    glm::dvec2 at(0.0);
    glm::ivec2 size(0);
    glfwGetCursorPos(window_, &at.x, &at.y);
    glfwGetWindowSize(window_, &size.x, &size.y);
    // Screen coordinates, which a display of high density has fewer of than pixels.
    if (size.x <= 0 || size.y <= 0) return std::nullopt;
    return at * glm::dvec2(width_, height_) / glm::dvec2(size);
  }
  [[nodiscard]] int togglePresses() override { return std::exchange(presses_, 0); }

 private:
  WindowHost() = default;
  static const char* lastError() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text == nullptr ? "unknown reason" : text;
  }

  bool initialized_ = false;
  GLFWwindow* window_ = nullptr;
  int presses_ = 0;
};

#endif

}  // namespace

Result<std::unique_ptr<Host>> makeSurfaceless(int width, int height) {
  return SurfacelessHost::create(width, height);
}

#ifdef EMBED_HAS_GLFW
Result<std::unique_ptr<Host>> makeWindow(int width, int height) { return WindowHost::create(width, height); }
#else
Result<std::unique_ptr<Host>> makeWindow(int, int) { return fail("built without GLFW: there is no window"); }
#endif

}  // namespace embed
