#include "painter.hpp"

#include <string>
#include <utility>

namespace embed {

namespace {

constexpr const char* kVertexText = R"(#version 450 core
layout(location = 0) uniform vec4 place;   // x, y, width, height in clip space
layout(location = 1) uniform vec4 bottom;
layout(location = 2) uniform vec4 top;
out vec4 color;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  color = mix(bottom, top, corner.y);
  gl_Position = vec4(place.xy + corner * place.zw, 0.0, 1.0);
}
)";
constexpr const char* kFragmentText = R"(#version 450 core
in vec4 color;
layout(location = 0) out vec4 result;
void main() { result = color; }
)";

Result<GLuint> link(const GladGLContext& gl) {
  const GLuint program = gl.CreateProgram();
  for (const auto& [stage, text] :
       {std::pair{GL_VERTEX_SHADER, kVertexText}, {GL_FRAGMENT_SHADER, kFragmentText}}) {
    const GLuint shader = gl.CreateShader(static_cast<GLenum>(stage));
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program);
  GLint linked = GL_FALSE;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return program;
  std::string log(1024, '\0');
  GLsizei length = 0;
  gl.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  gl.DeleteProgram(program);
  return tessera::fail("the host's own shader does not link: {}", log);
}

}  // namespace

Result<Painter> Painter::create(const Host& host) {
  const GladGLContext& gl = host.gl();
  auto program = link(gl);
  if (!program) return tl::unexpected(program.error());
  Painter painter(host);
  painter.program_ = *program;
  gl.CreateVertexArrays(1, &painter.vertexArray_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
  gl.Viewport(0, 0, host.width(), host.height());
  gl.UseProgram(painter.program_);
  gl.BindVertexArray(painter.vertexArray_);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  return painter;
}

Painter::Painter(Painter&& other) noexcept
    : host_(other.host_),
      program_(std::exchange(other.program_, 0)),
      vertexArray_(std::exchange(other.vertexArray_, 0)) {}

Painter::~Painter() {
  if (program_ == 0) return;
  host_->gl().DeleteProgram(program_);
  host_->gl().DeleteVertexArrays(1, &vertexArray_);
}

void Painter::fill(const Rectangle& where, const Color& bottom, const Color& top) const {
  const GladGLContext& gl = host_->gl();
  const float x = 2.0f / static_cast<float>(host_->width());
  const float y = 2.0f / static_cast<float>(host_->height());
  gl.Uniform4f(0, static_cast<float>(where.x) * x - 1.0f, static_cast<float>(where.y) * y - 1.0f,
               static_cast<float>(where.width) * x, static_cast<float>(where.height) * y);
  gl.Uniform4fv(1, 1, bottom.data());
  gl.Uniform4fv(2, 1, top.data());
  gl.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

void Painter::frame(const Rectangle& where, int thickness, const Color& color) const {
  const int inner = where.height - 2 * thickness;
  fill({where.x, where.y, where.width, thickness}, color);
  fill({where.x, where.y + where.height - thickness, where.width, thickness}, color);
  fill({where.x, where.y + thickness, thickness, inner}, color);
  fill({where.x + where.width - thickness, where.y + thickness, thickness, inner}, color);
}

}  // namespace embed
