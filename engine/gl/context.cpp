#include "engine/gl/context.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>

#include "engine/gl/draw_state.hpp"

namespace tessera::gl {

namespace {

thread_local const GladGLContext* current = nullptr;

struct StandIn {
  const char* extension;
  bool inShaders;  // needs an #extension line
};

// What GL 4.6 made core and the engine uses.
constexpr std::array kStandIns = {
    StandIn{"GL_ARB_shader_draw_parameters", true},
    StandIn{"GL_ARB_pipeline_statistics_query", false},
};

void GLAD_API_PTR onDebugMessage(GLenum source, GLenum type, GLuint, GLenum severity, GLsizei length,
                                 const GLchar* message, const void* user) {
  // Mesa 22.3 sends compiler warnings with the type of an error; compile errors are reported by Program.
  const bool error = type == GL_DEBUG_TYPE_ERROR && source != GL_DEBUG_SOURCE_SHADER_COMPILER;
  if (severity != GL_DEBUG_SEVERITY_HIGH && !error) return;
  // The callback's user pointer is const by signature only.
  auto* errors = static_cast<std::vector<std::string>*>(const_cast<void*>(user));
  errors->emplace_back(message, length < 0 ? std::strlen(message) : static_cast<std::size_t>(length));
}

class OsMesaContext final : public Context {
 public:
  static Result<std::unique_ptr<Context>> create(const ContextOptions& options) {
    auto context = std::unique_ptr<OsMesaContext>(new OsMesaContext);
    for (const int minor : {6, 5}) {
      const std::array<int, 13> attributes = {OSMESA_FORMAT,
                                              OSMESA_RGBA,
                                              OSMESA_DEPTH_BITS,
                                              0,
                                              OSMESA_PROFILE,
                                              OSMESA_CORE_PROFILE,
                                              OSMESA_CONTEXT_MAJOR_VERSION,
                                              4,
                                              OSMESA_CONTEXT_MINOR_VERSION,
                                              minor,
                                              0,
                                              0,
                                              0};
      context->handle_ = OSMesaCreateContextAttribs(attributes.data(), nullptr);
      if (context->handle_ != nullptr) break;
    }
    if (context->handle_ == nullptr) return fail("OSMesa: no core context of GL 4.5 or newer");
    if (!context->bind()) return fail("OSMesa: the context cannot be made current");
    if (auto loaded = context->load(Backend::OsMesa, "osmesa", &OSMesaGetProcAddress, options.debug); !loaded)
      return tl::unexpected(loaded.error());
    return context;
  }
  ~OsMesaContext() override {
    if (handle_ != nullptr) OSMesaDestroyContext(handle_);
  }

 protected:
  bool bind() override {
    return OSMesaMakeCurrent(handle_, buffer_.data(), GL_UNSIGNED_BYTE, kSide, kSide) == GL_TRUE;
  }

 private:
  static constexpr int kSide =
      16;  // the window buffer is never drawn to: all rendering goes to framebuffer objects
  OSMesaContext handle_ = nullptr;
  std::array<unsigned char, static_cast<std::size_t>(kSide) * kSide * 4> buffer_{};
};

class EglContext final : public Context {
 public:
  static Result<std::unique_ptr<Context>> create(const ContextOptions& options) {
    auto context = std::unique_ptr<EglContext>(new EglContext);
    const auto getPlatformDisplay =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (getPlatformDisplay == nullptr) return fail("EGL: eglGetPlatformDisplayEXT is missing");
    context->display_ = getPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (context->display_ == EGL_NO_DISPLAY ||
        eglInitialize(context->display_, nullptr, nullptr) == EGL_FALSE)
      return fail("EGL: no surfaceless display ({:#x})", eglGetError());
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) return fail("EGL: desktop OpenGL is not offered");
    for (const int minor : {6, 5}) {
      const std::array<EGLint, 9> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                                4,
                                                EGL_CONTEXT_MINOR_VERSION,
                                                minor,
                                                EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                                EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                                EGL_CONTEXT_OPENGL_DEBUG,
                                                options.debug ? EGL_TRUE : EGL_FALSE,
                                                EGL_NONE};
      context->handle_ =
          eglCreateContext(context->display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
      if (context->handle_ != EGL_NO_CONTEXT) break;
    }
    if (context->handle_ == EGL_NO_CONTEXT)
      return fail("EGL: no core context of GL 4.5 or newer ({:#x})", eglGetError());
    if (!context->bind()) return fail("EGL: the context cannot be made current ({:#x})", eglGetError());
    if (auto loaded = context->load(Backend::Egl, "egl", &eglGetProcAddress, options.debug); !loaded)
      return tl::unexpected(loaded.error());
    return context;
  }
  ~EglContext() override {
    // The display is shared by all contexts of the process (EGL hands out one), so it is not terminated here.
    if (handle_ == EGL_NO_CONTEXT) return;
    if (eglGetCurrentContext() == handle_)
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, handle_);
  }

 protected:
  bool bind() override {
    return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, handle_) == EGL_TRUE;
  }

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext handle_ = EGL_NO_CONTEXT;
};

class HostContext final : public Context {
 public:
  static Result<std::unique_ptr<Context>> create(GetProc getProc) {
    if (getProc == nullptr) return fail("host context: no function loader was passed");
    auto context = std::unique_ptr<HostContext>(new HostContext);
    if (auto loaded = context->load(Backend::Host, "host", getProc, false); !loaded)
      return tl::unexpected(loaded.error());
    return context;
  }

 protected:
  bool bind() override { return true; }  // the host keeps it current
};

std::string text(const GladGLContext& gl, GLenum name) {
  const auto* value = reinterpret_cast<const char*>(gl.GetString(name));
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace

const GladGLContext& api() {
  assert(current != nullptr && "no tessera::gl::Context is current on this thread");
  return *current;
}

Result<std::unique_ptr<Context>> Context::createOsMesa(const ContextOptions& options) {
  return OsMesaContext::create(options);
}
Result<std::unique_ptr<Context>> Context::createEgl(const ContextOptions& options) {
  return EglContext::create(options);
}
Result<std::unique_ptr<Context>> Context::adoptCurrent(GetProc getProc) {
  return HostContext::create(getProc);
}

Context::~Context() {
  if (current == &functions_) current = nullptr;
}

Result<void> Context::makeCurrent() {
  if (!bind()) return fail("{}: the context cannot be made current", info_.backendName);
  current = &functions_;
  return {};
}

std::vector<std::string> Context::takeErrors() {
  std::vector<std::string> errors;
  errors.swap(*errors_);
  return errors;
}

Result<void> Context::load(Backend backend, const char* name, GetProc getProc, bool debug) {
  if (gladLoadGLContext(&functions_, getProc) == 0) return fail("{}: no GL functions could be loaded", name);
  const GladGLContext& gl = functions_;
  info_.backend = backend;
  info_.backendName = name;
  info_.vendor = text(gl, GL_VENDOR);
  info_.renderer = text(gl, GL_RENDERER);
  info_.version = text(gl, GL_VERSION);
  info_.glslVersion = text(gl, GL_SHADING_LANGUAGE_VERSION);
  gl.GetIntegerv(GL_MAJOR_VERSION, &info_.major);
  gl.GetIntegerv(GL_MINOR_VERSION, &info_.minor);
  if (info_.major < 4 || (info_.major == 4 && info_.minor < 5))
    return fail(
        "{} ({}): OpenGL {}.{} is too old: 4.6 is needed, or 4.5 with the extensions that 4.6 made core",
        name, info_.renderer, info_.major, info_.minor);
  const bool is46 = info_.major > 4 || info_.minor >= 6;
  info_.shaderHeader = is46 ? "#version 460 core\n" : "#version 450 core\n";
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  std::vector<std::string> offered;
  offered.reserve(static_cast<std::size_t>(count));
  for (GLint i = 0; i < count; ++i)
    offered.emplace_back(reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))));
  const auto offers = [&](const char* extension) {
    return std::find(offered.begin(), offered.end(), extension) != offered.end();
  };
  info_.vertexLayers = offers("GL_ARB_shader_viewport_layer_array");
  if (!is46) {
    std::string missing;
    for (const StandIn& standIn : kStandIns) {
      if (!offers(standIn.extension)) {
        missing += missing.empty() ? standIn.extension : std::string(", ") + standIn.extension;
        continue;
      }
      info_.standIns.emplace_back(standIn.extension);
      if (standIn.inShaders)
        info_.shaderHeader +=
            std::string("#extension ") + standIn.extension +
            " : require\n#define gl_DrawID gl_DrawIDARB\n#define gl_BaseInstance gl_BaseInstanceARB\n"
            "#define gl_BaseVertex gl_BaseVertexARB\n";
    }
    // Not needed, but a host may use it: the state guard puts the clamp back.
    if (offers("GL_ARB_polygon_offset_clamp"))
      functions_.PolygonOffsetClamp =
          reinterpret_cast<PFNGLPOLYGONOFFSETCLAMPPROC>(getProc("glPolygonOffsetClamp"));
    if (!missing.empty())
      return fail("{} ({}): OpenGL 4.5 lacks what 4.6 made core: {}", name, info_.renderer, missing);
  }
  for (const char* rasterizer : {"llvmpipe", "softpipe", "lavapipe", "SWR", "swrast"})
    info_.software = info_.software || info_.renderer.find(rasterizer) != std::string::npos;
  if (debug) {
    gl.Enable(GL_DEBUG_OUTPUT);
    gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    gl.DebugMessageCallback(&onDebugMessage, errors_.get());
  }
  current = &functions_;
  if (backend != Backend::Host) applyClientTransfers();
  return {};
}

}  // namespace tessera::gl
