#include "engine/gl/draw_state.hpp"

#include "engine/gl/context.hpp"

namespace tessera::gl {

namespace {

void enable(GLenum what, bool on) { (on ? api().Enable : api().Disable)(what); }

GLenum functionOf(DepthTest test) {
  switch (test) {
    case DepthTest::Off:
      return GL_ALWAYS;
    case DepthTest::Greater:
      return GL_GREATER;
    case DepthTest::GreaterEqual:
      return GL_GEQUAL;
    case DepthTest::Equal:
      return GL_EQUAL;
    case DepthTest::Less:
      return GL_LESS;
    case DepthTest::LessEqual:
      return GL_LEQUAL;
  }
  return GL_ALWAYS;
}

}  // namespace

void apply(const DrawState& state) {
  const GladGLContext& gl = api();
  for (const GLenum off : kAlwaysOff) gl.Disable(off);
  gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl.DepthRange(0.0, 1.0);
  gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  gl.ProvokingVertex(GL_LAST_VERTEX_CONVENTION);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  enable(GL_DEPTH_TEST, state.depth != DepthTest::Off);
  gl.DepthFunc(functionOf(state.depth));
  gl.DepthMask(state.depthWrite ? GL_TRUE : GL_FALSE);
  enable(GL_BLEND, state.blend);
  gl.BlendEquation(GL_FUNC_ADD);
  gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  enable(GL_FRAMEBUFFER_SRGB, state.encodeSrgb);
  enable(GL_POLYGON_OFFSET_FILL, state.offsetFactor != 0.0f || state.offsetUnits != 0.0f);
  gl.PolygonOffset(state.offsetFactor, state.offsetUnits);
  applyCulling(state.cullBack, state.mirrored);
}

void applyClientTransfers() {
  for (const GLenum parameter : kPixelStore)
    api().PixelStorei(parameter, parameter == GL_PACK_ALIGNMENT || parameter == GL_UNPACK_ALIGNMENT ? 1 : 0);
  for (const GLenum target : {GL_PIXEL_PACK_BUFFER, GL_PIXEL_UNPACK_BUFFER, GL_QUERY_BUFFER})
    api().BindBuffer(target, 0);
}

void applyCulling(bool cullBack, bool mirrored) {
  enable(GL_CULL_FACE, cullBack);
  api().CullFace(GL_BACK);
  api().FrontFace(mirrored ? GL_CW : GL_CCW);
}

}  // namespace tessera::gl
