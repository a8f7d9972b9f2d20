// GL contexts: OSMesa, EGL surfaceless, or the one that a host has current. One function table a context.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glad/gl.h>

#include "engine/core/result.hpp"

namespace tessera::gl {

enum class Backend { OsMesa, Egl, Host };

/// What a context is, for reports and for the first lines of every shader.
struct ContextInfo {
  Backend backend = Backend::OsMesa;
  std::string backendName;  // "osmesa", "egl", "host"
  std::string vendor;
  std::string renderer;
  std::string version;      // GL_VERSION
  std::string glslVersion;  // GL_SHADING_LANGUAGE_VERSION
  int major = 0;
  int minor = 0;
  /// Extensions that stand in for what 4.6 made core; empty on a true 4.6.
  std::vector<std::string> standIns;
  /// "#version 460 core" or "#version 450 core" with its #extension lines.
  std::string shaderHeader;
  bool vertexLayers = false;  // vertex shaders may write gl_Layer: GL_ARB_shader_viewport_layer_array
  bool software = false;      // a software rasterizer: timers fall back to finish and wall clock
};

struct ContextOptions {
#ifdef NDEBUG
  bool debug = false;  // KHR_debug, synchronous; error-severity messages are kept, see takeErrors
#else
  bool debug = true;
#endif
};

/// The loader a host passes: the address of a GL function by name, or null.
using GetProc = void (*(*)(const char* name))();

/// A GL context with its own function table. 4.6 is asked for; 4.5 is accepted when the extensions that 4.6
/// made core and that the engine uses are there; less is refused with the list of what is missing.
class Context {
 public:
  static Result<std::unique_ptr<Context>> createOsMesa(const ContextOptions& options = {});
  static Result<std::unique_ptr<Context>> createEgl(const ContextOptions& options = {});
  /// Wraps the context that is current on this thread. It is neither owned nor destroyed; its debug callback
  /// stays, and every call of Engine leaves its state as it was (see StateGuard for what a host must not have
  /// active).
  static Result<std::unique_ptr<Context>> adoptCurrent(GetProc getProc);

  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  virtual ~Context();

  /// Makes the context current on this thread, and its functions the ones that gl::api() returns.
  Result<void> makeCurrent();
  [[nodiscard]] const ContextInfo& info() const { return info_; }
  /// Error-severity KHR_debug messages since the last call. Always empty without ContextOptions::debug.
  std::vector<std::string> takeErrors();

 protected:
  Context() = default;
  virtual bool bind() = 0;
  Result<void> load(Backend backend, const char* name, GetProc getProc, bool debug);

  GladGLContext functions_{};
  ContextInfo info_;
  std::unique_ptr<std::vector<std::string>> errors_ = std::make_unique<std::vector<std::string>>();
};

/// The function table of the context that is current on this thread. One must be.
const GladGLContext& api();

}  // namespace tessera::gl
