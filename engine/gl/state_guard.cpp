#include "engine/gl/state_guard.hpp"

#include <array>
#include <cstddef>
#include <vector>

#include "engine/gl/context.hpp"
#include "engine/gl/draw_state.hpp"
#include "glsl/shared/bindings.h"

namespace tessera::gl {

namespace {

struct Binding {
  GLenum target;
  GLenum query;
};

// Indexed storage and uniform bindings also set the generic binding of their target.
constexpr std::array kBuffers = {
    Binding{GL_DRAW_INDIRECT_BUFFER, GL_DRAW_INDIRECT_BUFFER_BINDING},
    Binding{GL_DISPATCH_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER_BINDING},
    Binding{GL_PIXEL_PACK_BUFFER, GL_PIXEL_PACK_BUFFER_BINDING},
    Binding{GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_UNPACK_BUFFER_BINDING},
    Binding{GL_QUERY_BUFFER, GL_QUERY_BUFFER_BINDING},
    Binding{GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING},
    Binding{GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING},
};

// The targets that gl::Texture makes. Binding one leaves a unit's other targets alone.
constexpr std::array kTextures = {
    Binding{GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D},
    Binding{GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BINDING_2D_ARRAY},
};

constexpr GLuint kImageUnits = 1;

GLint integer(GLenum name) {
  GLint value = 0;
  api().GetIntegerv(name, &value);
  return value;
}
GLint integer(GLenum name, GLuint index) {
  GLint value = 0;
  api().GetIntegeri_v(name, index, &value);
  return value;
}
GLenum symbol(GLenum name) { return static_cast<GLenum>(integer(name)); }
GLenum symbol(GLenum name, GLuint index) { return static_cast<GLenum>(integer(name, index)); }
GLuint object(GLenum name) { return static_cast<GLuint>(integer(name)); }
GLuint object(GLenum name, GLuint index) { return static_cast<GLuint>(integer(name, index)); }

float number(GLenum name) {
  float value = 0.0f;
  api().GetFloatv(name, &value);
  return value;
}

struct Enable {
  GLenum what = 0;
  bool on = false;
  void save(GLenum name) {
    what = name;
    on = api().IsEnabled(name) == GL_TRUE;
  }
  void restore() const { (on ? api().Enable : api().Disable)(what); }
};

void enableIndexed(GLenum what, GLuint index, bool on) { (on ? api().Enablei : api().Disablei)(what, index); }

/// A buffer bound to an indexed target, whole or in part.
struct IndexedBuffer {
  GLuint name = 0;
  GLint64 start = 0;
  GLint64 size = 0;  // 0: the whole buffer, by BindBufferBase

  void save(GLuint index, GLenum binding, GLenum startQuery, GLenum sizeQuery) {
    name = object(binding, index);
    api().GetInteger64i_v(startQuery, index, &start);
    api().GetInteger64i_v(sizeQuery, index, &size);
  }
  void restore(GLuint index, GLenum target) const {
    if (name == 0 || size == 0)
      api().BindBufferBase(target, index, name);
    else
      api().BindBufferRange(target, index, name, static_cast<GLintptr>(start), static_cast<GLsizeiptr>(size));
  }
};

struct TextureUnit {
  std::array<GLuint, kTextures.size()> textures{};
  GLuint sampler = 0;

  void save(GLuint unit) {
    api().ActiveTexture(GL_TEXTURE0 + unit);
    for (std::size_t i = 0; i < kTextures.size(); ++i) textures[i] = object(kTextures[i].query);
    sampler = object(GL_SAMPLER_BINDING);
  }
  void restore(GLuint unit) const {
    api().ActiveTexture(GL_TEXTURE0 + unit);
    for (std::size_t i = 0; i < kTextures.size(); ++i) api().BindTexture(kTextures[i].target, textures[i]);
    api().BindSampler(unit, sampler);
  }
};

struct ImageUnit {
  GLuint name = 0;
  GLint level = 0;
  GLboolean layered = GL_FALSE;
  GLint layer = 0;
  GLenum access = 0;
  GLenum format = 0;

  void save(GLuint unit) {
    name = object(GL_IMAGE_BINDING_NAME, unit);
    level = integer(GL_IMAGE_BINDING_LEVEL, unit);
    api().GetBooleani_v(GL_IMAGE_BINDING_LAYERED, unit, &layered);
    layer = integer(GL_IMAGE_BINDING_LAYER, unit);
    access = symbol(GL_IMAGE_BINDING_ACCESS, unit);
    format = symbol(GL_IMAGE_BINDING_FORMAT, unit);
  }
  void restore(GLuint unit) const {
    api().BindImageTexture(unit, name, level, layered, layer, access, format);
  }
};

/// What the unindexed calls of draw_state.cpp set for every viewport at once.
struct Viewport {
  std::array<float, 4> rectangle{};
  std::array<double, 2> depthRange{};
  bool scissor = false;

  void save(GLuint index) {
    api().GetFloati_v(GL_VIEWPORT, index, rectangle.data());
    api().GetDoublei_v(GL_DEPTH_RANGE, index, depthRange.data());
    scissor = api().IsEnabledi(GL_SCISSOR_TEST, index) == GL_TRUE;
  }
  void restore(GLuint index) const {
    api().ViewportIndexedfv(index, rectangle.data());
    api().DepthRangeIndexed(index, depthRange[0], depthRange[1]);
    enableIndexed(GL_SCISSOR_TEST, index, scissor);
  }
};

/// What the unindexed calls of draw_state.cpp set for every draw buffer at once.
struct DrawBuffer {
  bool blend = false;
  GLenum equationColor = 0, equationAlpha = 0;
  GLenum sourceColor = 0, destinationColor = 0, sourceAlpha = 0, destinationAlpha = 0;
  std::array<GLboolean, 4> mask{};

  void save(GLuint index) {
    blend = api().IsEnabledi(GL_BLEND, index) == GL_TRUE;
    equationColor = symbol(GL_BLEND_EQUATION_RGB, index);
    equationAlpha = symbol(GL_BLEND_EQUATION_ALPHA, index);
    sourceColor = symbol(GL_BLEND_SRC_RGB, index);
    destinationColor = symbol(GL_BLEND_DST_RGB, index);
    sourceAlpha = symbol(GL_BLEND_SRC_ALPHA, index);
    destinationAlpha = symbol(GL_BLEND_DST_ALPHA, index);
    api().GetBooleani_v(GL_COLOR_WRITEMASK, index, mask.data());
  }
  void restore(GLuint index) const {
    enableIndexed(GL_BLEND, index, blend);
    api().BlendEquationSeparatei(index, equationColor, equationAlpha);
    api().BlendFuncSeparatei(index, sourceColor, destinationColor, sourceAlpha, destinationAlpha);
    api().ColorMaski(index, mask[0], mask[1], mask[2], mask[3]);
  }
};

}  // namespace

struct StateGuard::Saved {
  GLuint drawFramebuffer = 0, readFramebuffer = 0, program = 0, vertexArray = 0;
  std::array<GLuint, kBuffers.size()> buffers{};
  std::array<IndexedBuffer, BIND_STORAGE_COUNT> storage{};
  std::array<IndexedBuffer, BIND_UNIFORM_COUNT> uniform{};
  GLenum activeTexture = 0;
  std::array<TextureUnit, UNIT_COUNT> textureUnits{};
  std::array<ImageUnit, kImageUnits> imageUnits{};
  std::array<GLint, kPixelStore.size()> pixelStore{};
  std::array<Enable, kAlwaysOff.size() + kPerPassEnables.size()> enables{};
  std::vector<Viewport> viewports;
  std::vector<DrawBuffer> drawBuffers;
  GLenum depthFunction = 0, cullFace = 0, frontFace = 0, clipOrigin = 0, clipDepth = 0, provokingVertex = 0;
  // A compatibility profile returns two polygon modes, front and back; the core profile has one.
  std::array<GLint, 2> polygonMode{};
  GLboolean depthMask = GL_TRUE;
  GLint patchVertices = 0;
  float offsetFactor = 0.0f, offsetUnits = 0.0f, offsetClamp = 0.0f;

  Saved();
  void restore() const;
};

StateGuard::Saved::Saved()
    : viewports(static_cast<std::size_t>(integer(GL_MAX_VIEWPORTS))),
      drawBuffers(static_cast<std::size_t>(integer(GL_MAX_DRAW_BUFFERS))) {
  const GladGLContext& gl = api();
  drawFramebuffer = object(GL_DRAW_FRAMEBUFFER_BINDING);
  readFramebuffer = object(GL_READ_FRAMEBUFFER_BINDING);
  program = object(GL_CURRENT_PROGRAM);
  vertexArray = object(GL_VERTEX_ARRAY_BINDING);
  for (std::size_t i = 0; i < kBuffers.size(); ++i) buffers[i] = object(kBuffers[i].query);
  for (GLuint i = 0; i < storage.size(); ++i)
    storage[i].save(i, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
                    GL_SHADER_STORAGE_BUFFER_SIZE);
  for (GLuint i = 0; i < uniform.size(); ++i)
    uniform[i].save(i, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE);
  activeTexture = symbol(GL_ACTIVE_TEXTURE);
  for (GLuint i = 0; i < textureUnits.size(); ++i) textureUnits[i].save(i);
  gl.ActiveTexture(activeTexture);
  for (GLuint i = 0; i < imageUnits.size(); ++i) imageUnits[i].save(i);
  for (std::size_t i = 0; i < kPixelStore.size(); ++i) pixelStore[i] = integer(kPixelStore[i]);
  std::size_t next = 0;
  for (const GLenum what : kAlwaysOff) enables[next++].save(what);
  for (const GLenum what : kPerPassEnables) enables[next++].save(what);
  for (GLuint i = 0; i < viewports.size(); ++i) viewports[i].save(i);
  for (GLuint i = 0; i < drawBuffers.size(); ++i) drawBuffers[i].save(i);
  depthFunction = symbol(GL_DEPTH_FUNC);
  gl.GetBooleanv(GL_DEPTH_WRITEMASK, &depthMask);
  cullFace = symbol(GL_CULL_FACE_MODE);
  frontFace = symbol(GL_FRONT_FACE);
  clipOrigin = symbol(GL_CLIP_ORIGIN);
  clipDepth = symbol(GL_CLIP_DEPTH_MODE);
  provokingVertex = symbol(GL_PROVOKING_VERTEX);
  gl.GetIntegerv(GL_POLYGON_MODE, polygonMode.data());
  patchVertices = integer(GL_PATCH_VERTICES);
  offsetFactor = number(GL_POLYGON_OFFSET_FACTOR);
  offsetUnits = number(GL_POLYGON_OFFSET_UNITS);
  if (gl.PolygonOffsetClamp != nullptr) offsetClamp = number(GL_POLYGON_OFFSET_CLAMP);
}

void StateGuard::Saved::restore() const {
  const GladGLContext& gl = api();
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, drawFramebuffer);
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, readFramebuffer);
  gl.UseProgram(gl.IsProgram(program) == GL_TRUE ? program : 0);
  gl.BindVertexArray(vertexArray);
  for (GLuint i = 0; i < storage.size(); ++i) storage[i].restore(i, GL_SHADER_STORAGE_BUFFER);
  for (GLuint i = 0; i < uniform.size(); ++i) uniform[i].restore(i, GL_UNIFORM_BUFFER);
  // After the indexed ones, which overwrite the generic binding of their target.
  for (std::size_t i = 0; i < kBuffers.size(); ++i) gl.BindBuffer(kBuffers[i].target, buffers[i]);
  for (GLuint i = 0; i < textureUnits.size(); ++i) textureUnits[i].restore(i);
  gl.ActiveTexture(activeTexture);
  for (GLuint i = 0; i < imageUnits.size(); ++i) imageUnits[i].restore(i);
  for (std::size_t i = 0; i < kPixelStore.size(); ++i) gl.PixelStorei(kPixelStore[i], pixelStore[i]);
  for (const Enable& enable : enables) enable.restore();
  // After the unindexed enables, which set every index.
  for (GLuint i = 0; i < viewports.size(); ++i) viewports[i].restore(i);
  for (GLuint i = 0; i < drawBuffers.size(); ++i) drawBuffers[i].restore(i);
  gl.DepthFunc(depthFunction);
  gl.DepthMask(depthMask);
  gl.CullFace(cullFace);
  gl.FrontFace(frontFace);
  gl.ClipControl(clipOrigin, clipDepth);
  gl.ProvokingVertex(provokingVertex);
  gl.PolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(polygonMode[0]));
  gl.PatchParameteri(GL_PATCH_VERTICES, patchVertices);
  if (gl.PolygonOffsetClamp != nullptr)
    gl.PolygonOffsetClamp(offsetFactor, offsetUnits, offsetClamp);
  else
    gl.PolygonOffset(offsetFactor, offsetUnits);
}

StateGuard::StateGuard() : saved_(std::make_unique<Saved>()) { applyClientTransfers(); }
StateGuard::~StateGuard() { saved_->restore(); }

}  // namespace tessera::gl
