// A host's GL state for tests: everything a core context holds that a library could disturb, read by names of
// its own (nothing is taken from the guard's tables), and a setter of values that differ from the defaults
// everywhere.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <glad/gl.h>

#include "engine/gl/context.hpp"

namespace tessera::test {

/// The loader that a host on this backend has at hand.
gl::GetProc procLoader(gl::Backend backend);

/// "TEXTURE_BINDING_2D[unit 3]" to its values.
using HostState = std::map<std::string, std::vector<double>>;

/// Reads the state of the current context. No call leaves a trace, except that an error flag would show.
HostState readHostState(const GladGLContext& gl);

/// A linked program that puts every vertex at the origin.
GLuint linkEmptyProgram(const GladGLContext& gl, bool separable = false);

/// One line a field that differs, with both values; empty when they are equal.
std::vector<std::string> differences(const HostState& before, const HostState& after);

/// Objects bound to every binding point, and odd values for every other field, until destruction.
class OddState {
 public:
  explicit OddState(const GladGLContext& gl);
  ~OddState();
  OddState(const OddState&) = delete;
  OddState& operator=(const OddState&) = delete;

 private:
  GLuint buffer();
  GLuint texture(GLenum target);
  void bindBuffers();
  void bindTexturesAndImages();
  void bindObjects();
  void setFixedFunction();

  const GladGLContext& gl_;
  std::vector<GLuint> buffers_, textures_, samplers_, framebuffers_;
  GLuint vertexArray_ = 0, renderbuffer_ = 0, feedback_ = 0, program_ = 0, separable_ = 0, pipeline_ = 0;
};

}  // namespace tessera::test
