#include "tests/frame/host_state.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include <EGL/egl.h>
#include <GL/osmesa.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

namespace tessera::test {

namespace {

struct Field {
  const char* name;
  GLenum query;
  int count = 1;
};
#define FIELD(name) \
  Field { #name, GL_##name }

constexpr GLuint kUnits = 16;    // texture units looked at
constexpr GLuint kIndexed = 32;  // storage and uniform bindings looked at, at most

const std::array kScalars = {
    // Objects
    FIELD(DRAW_FRAMEBUFFER_BINDING), FIELD(READ_FRAMEBUFFER_BINDING), FIELD(RENDERBUFFER_BINDING),
    FIELD(CURRENT_PROGRAM), FIELD(PROGRAM_PIPELINE_BINDING), FIELD(VERTEX_ARRAY_BINDING),
    FIELD(TRANSFORM_FEEDBACK_BINDING), FIELD(ARRAY_BUFFER_BINDING), FIELD(ELEMENT_ARRAY_BUFFER_BINDING),
    FIELD(COPY_READ_BUFFER_BINDING), FIELD(COPY_WRITE_BUFFER_BINDING), FIELD(DRAW_INDIRECT_BUFFER_BINDING),
    FIELD(DISPATCH_INDIRECT_BUFFER_BINDING), FIELD(PIXEL_PACK_BUFFER_BINDING),
    FIELD(PIXEL_UNPACK_BUFFER_BINDING), FIELD(QUERY_BUFFER_BINDING), FIELD(TEXTURE_BUFFER_BINDING),
    FIELD(ATOMIC_COUNTER_BUFFER_BINDING), FIELD(TRANSFORM_FEEDBACK_BUFFER_BINDING),
    FIELD(UNIFORM_BUFFER_BINDING), FIELD(SHADER_STORAGE_BUFFER_BINDING), FIELD(ACTIVE_TEXTURE),
    // Pixel store
    FIELD(PACK_SWAP_BYTES), FIELD(PACK_LSB_FIRST), FIELD(PACK_ROW_LENGTH), FIELD(PACK_IMAGE_HEIGHT),
    FIELD(PACK_SKIP_ROWS), FIELD(PACK_SKIP_PIXELS), FIELD(PACK_SKIP_IMAGES), FIELD(PACK_ALIGNMENT),
    FIELD(UNPACK_SWAP_BYTES), FIELD(UNPACK_LSB_FIRST), FIELD(UNPACK_ROW_LENGTH), FIELD(UNPACK_IMAGE_HEIGHT),
    FIELD(UNPACK_SKIP_ROWS), FIELD(UNPACK_SKIP_PIXELS), FIELD(UNPACK_SKIP_IMAGES), FIELD(UNPACK_ALIGNMENT),
    // Depth and stencil
    FIELD(DEPTH_FUNC), FIELD(DEPTH_WRITEMASK), FIELD(DEPTH_CLEAR_VALUE), FIELD(STENCIL_FUNC),
    FIELD(STENCIL_REF), FIELD(STENCIL_VALUE_MASK), FIELD(STENCIL_WRITEMASK), FIELD(STENCIL_FAIL),
    FIELD(STENCIL_PASS_DEPTH_FAIL), FIELD(STENCIL_PASS_DEPTH_PASS), FIELD(STENCIL_BACK_FUNC),
    FIELD(STENCIL_BACK_REF), FIELD(STENCIL_BACK_VALUE_MASK), FIELD(STENCIL_BACK_WRITEMASK),
    FIELD(STENCIL_BACK_FAIL), FIELD(STENCIL_BACK_PASS_DEPTH_FAIL), FIELD(STENCIL_BACK_PASS_DEPTH_PASS),
    FIELD(STENCIL_CLEAR_VALUE),
    // Rasterization
    FIELD(CULL_FACE_MODE), FIELD(FRONT_FACE), FIELD(POLYGON_OFFSET_FACTOR), FIELD(POLYGON_OFFSET_UNITS),
    FIELD(CLIP_ORIGIN), FIELD(CLIP_DEPTH_MODE), FIELD(PROVOKING_VERTEX), FIELD(POINT_SIZE),
    FIELD(POINT_FADE_THRESHOLD_SIZE), FIELD(POINT_SPRITE_COORD_ORIGIN), FIELD(SAMPLE_COVERAGE_VALUE),
    FIELD(SAMPLE_COVERAGE_INVERT), FIELD(MIN_SAMPLE_SHADING_VALUE), FIELD(PRIMITIVE_RESTART_INDEX),
    FIELD(PATCH_VERTICES), FIELD(LOGIC_OP_MODE), FIELD(FRAGMENT_SHADER_DERIVATIVE_HINT),
    FIELD(CLAMP_READ_COLOR),
    // Several values
    Field{"COLOR_CLEAR_VALUE", GL_COLOR_CLEAR_VALUE, 4}, Field{"BLEND_COLOR", GL_BLEND_COLOR, 4},
    Field{"PATCH_DEFAULT_OUTER_LEVEL", GL_PATCH_DEFAULT_OUTER_LEVEL, 4},
    Field{"PATCH_DEFAULT_INNER_LEVEL", GL_PATCH_DEFAULT_INNER_LEVEL, 2},
    Field{"POLYGON_MODE", GL_POLYGON_MODE, 1}};

const std::array kEnables = {FIELD(STENCIL_TEST),
                             FIELD(DEPTH_TEST),
                             FIELD(RASTERIZER_DISCARD),
                             FIELD(DEPTH_CLAMP),
                             FIELD(PRIMITIVE_RESTART),
                             FIELD(PRIMITIVE_RESTART_FIXED_INDEX),
                             FIELD(SAMPLE_ALPHA_TO_COVERAGE),
                             FIELD(SAMPLE_ALPHA_TO_ONE),
                             FIELD(SAMPLE_COVERAGE),
                             FIELD(SAMPLE_MASK),
                             FIELD(SAMPLE_SHADING),
                             FIELD(COLOR_LOGIC_OP),
                             FIELD(POLYGON_SMOOTH),
                             FIELD(LINE_SMOOTH),
                             FIELD(MULTISAMPLE),
                             FIELD(PROGRAM_POINT_SIZE),
                             FIELD(TEXTURE_CUBE_MAP_SEAMLESS),
                             FIELD(DITHER),
                             FIELD(POLYGON_OFFSET_FILL),
                             FIELD(POLYGON_OFFSET_LINE),
                             FIELD(POLYGON_OFFSET_POINT),
                             FIELD(CULL_FACE),
                             FIELD(FRAMEBUFFER_SRGB),
                             FIELD(CLIP_DISTANCE0),
                             FIELD(CLIP_DISTANCE1),
                             FIELD(CLIP_DISTANCE2),
                             FIELD(CLIP_DISTANCE3),
                             FIELD(CLIP_DISTANCE4),
                             FIELD(CLIP_DISTANCE5),
                             FIELD(CLIP_DISTANCE6),
                             FIELD(CLIP_DISTANCE7)};

struct TextureTarget {
  Field binding;
  GLenum target;
};
const std::array kTextureTargets = {
    TextureTarget{FIELD(TEXTURE_BINDING_1D), GL_TEXTURE_1D},
    TextureTarget{FIELD(TEXTURE_BINDING_2D), GL_TEXTURE_2D},
    TextureTarget{FIELD(TEXTURE_BINDING_3D), GL_TEXTURE_3D},
    TextureTarget{FIELD(TEXTURE_BINDING_1D_ARRAY), GL_TEXTURE_1D_ARRAY},
    TextureTarget{FIELD(TEXTURE_BINDING_2D_ARRAY), GL_TEXTURE_2D_ARRAY},
    TextureTarget{FIELD(TEXTURE_BINDING_RECTANGLE), GL_TEXTURE_RECTANGLE},
    TextureTarget{FIELD(TEXTURE_BINDING_CUBE_MAP), GL_TEXTURE_CUBE_MAP},
    TextureTarget{FIELD(TEXTURE_BINDING_CUBE_MAP_ARRAY), GL_TEXTURE_CUBE_MAP_ARRAY},
    TextureTarget{FIELD(TEXTURE_BINDING_BUFFER), GL_TEXTURE_BUFFER},
    TextureTarget{FIELD(TEXTURE_BINDING_2D_MULTISAMPLE), GL_TEXTURE_2D_MULTISAMPLE},
    TextureTarget{FIELD(TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY), GL_TEXTURE_2D_MULTISAMPLE_ARRAY}};

const std::array kImageFields = {FIELD(IMAGE_BINDING_NAME),    FIELD(IMAGE_BINDING_LEVEL),
                                 FIELD(IMAGE_BINDING_LAYERED), FIELD(IMAGE_BINDING_LAYER),
                                 FIELD(IMAGE_BINDING_ACCESS),  FIELD(IMAGE_BINDING_FORMAT)};
const std::array kDrawBufferFields = {FIELD(BLEND_EQUATION_RGB), FIELD(BLEND_EQUATION_ALPHA),
                                      FIELD(BLEND_SRC_RGB),      FIELD(BLEND_DST_RGB),
                                      FIELD(BLEND_SRC_ALPHA),    FIELD(BLEND_DST_ALPHA)};

struct IndexedTarget {
  Field name, start, size;
  GLenum target, most, alignment;
};
const std::array kIndexedTargets = {
    IndexedTarget{FIELD(SHADER_STORAGE_BUFFER_BINDING), FIELD(SHADER_STORAGE_BUFFER_START),
                  FIELD(SHADER_STORAGE_BUFFER_SIZE), GL_SHADER_STORAGE_BUFFER,
                  GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT},
    IndexedTarget{FIELD(UNIFORM_BUFFER_BINDING), FIELD(UNIFORM_BUFFER_START), FIELD(UNIFORM_BUFFER_SIZE),
                  GL_UNIFORM_BUFFER, GL_MAX_UNIFORM_BUFFER_BINDINGS, GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT}};

// Bindings without an index, and the indexed ones' generic side.
constexpr std::array<GLenum, 13> kBufferTargets = {GL_ARRAY_BUFFER,
                                                   GL_COPY_READ_BUFFER,
                                                   GL_COPY_WRITE_BUFFER,
                                                   GL_DRAW_INDIRECT_BUFFER,
                                                   GL_DISPATCH_INDIRECT_BUFFER,
                                                   GL_PIXEL_PACK_BUFFER,
                                                   GL_PIXEL_UNPACK_BUFFER,
                                                   GL_QUERY_BUFFER,
                                                   GL_TEXTURE_BUFFER,
                                                   GL_ATOMIC_COUNTER_BUFFER,
                                                   GL_TRANSFORM_FEEDBACK_BUFFER,
                                                   GL_UNIFORM_BUFFER,
                                                   GL_SHADER_STORAGE_BUFFER};

GLint limit(const GladGLContext& gl, GLenum name, GLint most = 1 << 30) {
  GLint value = 0;
  gl.GetIntegerv(name, &value);
  return std::min(value, most);
}

double address(const void* pointer) { return static_cast<double>(reinterpret_cast<std::uintptr_t>(pointer)); }

}  // namespace

gl::GetProc procLoader(gl::Backend backend) {
  if (backend == gl::Backend::Egl) return &eglGetProcAddress;
  return &OSMesaGetProcAddress;
}

GLuint linkEmptyProgram(const GladGLContext& gl, bool separable) {
  const GLuint program = gl.CreateProgram();
  if (separable) gl.ProgramParameteri(program, GL_PROGRAM_SEPARABLE, GL_TRUE);
  const char* source =
      "#version 450 core\nout gl_PerVertex { vec4 gl_Position; };\nvoid main() { gl_Position = vec4(0.0); "
      "}\n";
  const GLuint shader = gl.CreateShader(GL_VERTEX_SHADER);
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  gl.AttachShader(program, shader);
  gl.LinkProgram(program);
  gl.DetachShader(program, shader);
  gl.DeleteShader(shader);
  return program;
}

HostState readHostState(const GladGLContext& gl) {
  HostState state;
  for (const Field& field : kScalars) {
    // Some queries of one value write two.
    std::array<double, 4> values{};
    gl.GetDoublev(field.query, values.data());
    state[field.name].assign(values.begin(), values.begin() + field.count);
  }
  for (const Field& field : kEnables) state[field.name] = {static_cast<double>(gl.IsEnabled(field.query))};
  if (gl.PolygonOffsetClamp != nullptr) {
    double clamp = 0.0;
    gl.GetDoublev(GL_POLYGON_OFFSET_CLAMP, &clamp);
    state["POLYGON_OFFSET_CLAMP"] = {clamp};
  }
  const auto indexed = [&](const Field& field, GLuint index) {
    GLint value = 0;
    gl.GetIntegeri_v(field.query, index, &value);
    state[fmt::format("{}[{}]", field.name, index)] = {static_cast<double>(value)};
  };
  const auto indexedLong = [&](const Field& field, GLuint index) {
    GLint64 value = 0;
    gl.GetInteger64i_v(field.query, index, &value);
    state[fmt::format("{}[{}]", field.name, index)] = {static_cast<double>(value)};
  };
  for (const IndexedTarget& target : kIndexedTargets)
    for (GLuint i = 0; i < static_cast<GLuint>(limit(gl, target.most, kIndexed)); ++i) {
      indexed(target.name, i);
      indexedLong(target.start, i);
      indexedLong(target.size, i);
    }
  GLint active = 0;
  gl.GetIntegerv(GL_ACTIVE_TEXTURE, &active);
  for (GLuint unit = 0; unit < kUnits; ++unit) {
    gl.ActiveTexture(GL_TEXTURE0 + unit);
    GLint value = 0;
    for (const TextureTarget& target : kTextureTargets) {
      gl.GetIntegerv(target.binding.query, &value);
      state[fmt::format("{}[unit {}]", target.binding.name, unit)] = {static_cast<double>(value)};
    }
    gl.GetIntegerv(GL_SAMPLER_BINDING, &value);
    state[fmt::format("SAMPLER_BINDING[unit {}]", unit)] = {static_cast<double>(value)};
  }
  gl.ActiveTexture(static_cast<GLenum>(active));
  for (GLuint unit = 0; unit < static_cast<GLuint>(limit(gl, GL_MAX_IMAGE_UNITS, kUnits)); ++unit)
    for (const Field& field : kImageFields) indexed(field, unit);
  for (GLuint i = 0; i < static_cast<GLuint>(limit(gl, GL_MAX_VIEWPORTS)); ++i) {
    std::array<double, 4> values{};
    gl.GetDoublei_v(GL_VIEWPORT, i, values.data());
    state[fmt::format("VIEWPORT[{}]", i)].assign(values.begin(), values.end());
    gl.GetDoublei_v(GL_SCISSOR_BOX, i, values.data());
    state[fmt::format("SCISSOR_BOX[{}]", i)].assign(values.begin(), values.end());
    gl.GetDoublei_v(GL_DEPTH_RANGE, i, values.data());
    state[fmt::format("DEPTH_RANGE[{}]", i)].assign(values.begin(), values.begin() + 2);
    state[fmt::format("SCISSOR_TEST[{}]", i)] = {static_cast<double>(gl.IsEnabledi(GL_SCISSOR_TEST, i))};
  }
  for (GLuint i = 0; i < static_cast<GLuint>(limit(gl, GL_MAX_DRAW_BUFFERS)); ++i) {
    for (const Field& field : kDrawBufferFields) indexed(field, i);
    state[fmt::format("BLEND[{}]", i)] = {static_cast<double>(gl.IsEnabledi(GL_BLEND, i))};
    std::array<GLboolean, 4> mask{};
    gl.GetBooleani_v(GL_COLOR_WRITEMASK, i, mask.data());
    state[fmt::format("COLOR_WRITEMASK[{}]", i)].assign(mask.begin(), mask.end());
  }
  GLint sampleMask = 0;
  gl.GetIntegeri_v(GL_SAMPLE_MASK_VALUE, 0, &sampleMask);
  state["SAMPLE_MASK_VALUE[0]"] = {static_cast<double>(sampleMask)};
  void* pointer = nullptr;
  gl.GetPointerv(GL_DEBUG_CALLBACK_FUNCTION, &pointer);
  state["DEBUG_CALLBACK_FUNCTION"] = {address(pointer)};
  gl.GetPointerv(GL_DEBUG_CALLBACK_USER_PARAM, &pointer);
  state["DEBUG_CALLBACK_USER_PARAM"] = {address(pointer)};
  for (const Field& field : {FIELD(DEBUG_OUTPUT), FIELD(DEBUG_OUTPUT_SYNCHRONOUS)})
    state[field.name] = {static_cast<double>(gl.IsEnabled(field.query))};
  return state;
}

std::vector<std::string> differences(const HostState& before, const HostState& after) {
  std::vector<std::string> lines;
  for (const auto& [name, value] : before)
    if (const auto found = after.find(name); found == after.end() || found->second != value)
      lines.push_back(fmt::format("{}: was {}, is {}", name, value,
                                  found == after.end() ? std::vector<double>{} : found->second));
  return lines;
}

OddState::OddState(const GladGLContext& gl) : gl_(gl) {
  bindBuffers();
  bindTexturesAndImages();
  bindObjects();
  setFixedFunction();
  // Mesa 22.3 clamps the stencil reference to the bits of the framebuffer that it last validated.
  gl_.Clear(0);
}

GLuint OddState::buffer() {
  GLuint name = 0;
  gl_.CreateBuffers(1, &name);
  gl_.NamedBufferStorage(name, 4096, nullptr, 0);
  buffers_.push_back(name);
  return name;
}

GLuint OddState::texture(GLenum target) {
  GLuint name = 0;
  gl_.CreateTextures(target, 1, &name);
  textures_.push_back(name);
  return name;
}

void OddState::bindBuffers() {
  for (const IndexedTarget& target : kIndexedTargets) {
    const GLintptr alignment = limit(gl_, target.alignment);
    for (GLuint i = 0; i < static_cast<GLuint>(limit(gl_, target.most, kIndexed)); ++i)
      gl_.BindBufferRange(target.target, i, buffer(), alignment * (1 + static_cast<GLintptr>(i) % 3),
                          16 * (1 + static_cast<GLsizeiptr>(i)));
  }
  // Whole buffers are restored another way than ranges.
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, buffer());
  gl_.GenVertexArrays(1, &vertexArray_);
  gl_.BindVertexArray(vertexArray_);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer());
  gl_.GenTransformFeedbacks(1, &feedback_);
  gl_.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, feedback_);
  for (const GLenum target : kBufferTargets) gl_.BindBuffer(target, buffer());
}

void OddState::bindTexturesAndImages() {
  for (GLuint unit = 0; unit < kUnits; ++unit) {
    for (const TextureTarget& target : kTextureTargets) gl_.BindTextureUnit(unit, texture(target.target));
    GLuint sampler = 0;
    gl_.CreateSamplers(1, &sampler);
    samplers_.push_back(sampler);
    // Would spoil every picture if a pass of the engine left it on a unit that it reads.
    gl_.SamplerParameteri(sampler, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl_.SamplerParameteri(sampler, GL_TEXTURE_COMPARE_FUNC, GL_NEVER);
    gl_.SamplerParameteri(sampler, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    gl_.SamplerParameterf(sampler, GL_TEXTURE_LOD_BIAS, 3.0f);
    gl_.SamplerParameterf(sampler, GL_TEXTURE_MIN_LOD, 2.0f);
    gl_.BindSampler(unit, sampler);
  }
  for (GLuint unit = 0; unit < static_cast<GLuint>(limit(gl_, GL_MAX_IMAGE_UNITS, kUnits)); ++unit) {
    const GLuint name = texture(GL_TEXTURE_2D_ARRAY);
    gl_.TextureStorage3D(name, 4, GL_RGBA8, 16, 16, 5);
    gl_.BindImageTexture(unit, name, 1 + static_cast<GLint>(unit % 3), unit % 2 == 1 ? GL_TRUE : GL_FALSE,
                         1 + static_cast<GLint>(unit % 4), GL_READ_WRITE, GL_RGBA8UI);
  }
  gl_.ActiveTexture(GL_TEXTURE0 + 11);
}

void OddState::bindObjects() {
  for (const GLenum target : {GL_DRAW_FRAMEBUFFER, GL_READ_FRAMEBUFFER}) {
    GLuint name = 0;
    gl_.CreateFramebuffers(1, &name);
    framebuffers_.push_back(name);
    const GLuint attached = texture(GL_TEXTURE_2D);
    gl_.TextureStorage2D(attached, 1, GL_RGBA8, 8, 8);
    gl_.NamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, attached, 0);
    // With stencil bits, or its reference reads as 0.
    const GLuint depth = texture(GL_TEXTURE_2D);
    gl_.TextureStorage2D(depth, 1, GL_DEPTH24_STENCIL8, 8, 8);
    gl_.NamedFramebufferTexture(name, GL_DEPTH_STENCIL_ATTACHMENT, depth, 0);
    gl_.BindFramebuffer(target, name);
  }
  gl_.CreateRenderbuffers(1, &renderbuffer_);
  gl_.BindRenderbuffer(GL_RENDERBUFFER, renderbuffer_);
  program_ = linkEmptyProgram(gl_);
  separable_ = linkEmptyProgram(gl_, true);
  gl_.CreateProgramPipelines(1, &pipeline_);
  gl_.UseProgramStages(pipeline_, GL_VERTEX_SHADER_BIT, separable_);
  gl_.BindProgramPipeline(pipeline_);
  gl_.UseProgram(program_);
}

void OddState::setFixedFunction() {
  for (const GLenum parameter :
       {GL_PACK_SWAP_BYTES, GL_PACK_LSB_FIRST, GL_UNPACK_SWAP_BYTES, GL_UNPACK_LSB_FIRST})
    gl_.PixelStorei(parameter, GL_TRUE);
  GLint odd = 3;
  for (const GLenum parameter :
       {GL_PACK_ROW_LENGTH, GL_PACK_IMAGE_HEIGHT, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_IMAGES,
        GL_UNPACK_ROW_LENGTH, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS,
        GL_UNPACK_SKIP_IMAGES})
    gl_.PixelStorei(parameter, ++odd);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 8);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 2);

  gl_.DepthFunc(GL_NOTEQUAL);
  gl_.DepthMask(GL_FALSE);
  gl_.ClearDepth(0.375);
  gl_.StencilFuncSeparate(GL_FRONT, GL_LESS, 3, 0x5a);
  gl_.StencilFuncSeparate(GL_BACK, GL_GEQUAL, 5, 0x6b);
  gl_.StencilMaskSeparate(GL_FRONT, 0x17);
  gl_.StencilMaskSeparate(GL_BACK, 0x2c);
  gl_.StencilOpSeparate(GL_FRONT, GL_INCR, GL_DECR, GL_INVERT);
  gl_.StencilOpSeparate(GL_BACK, GL_ZERO, GL_INCR_WRAP, GL_DECR_WRAP);
  gl_.ClearStencil(9);
  gl_.ClearColor(0.1f, 0.2f, 0.3f, 0.4f);
  gl_.BlendColor(0.5f, 0.6f, 0.7f, 0.8f);

  gl_.CullFace(GL_FRONT_AND_BACK);
  gl_.FrontFace(GL_CW);
  gl_.PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  if (gl_.PolygonOffsetClamp != nullptr)
    gl_.PolygonOffsetClamp(2.5f, 3.5f, 0.25f);
  else
    gl_.PolygonOffset(2.5f, 3.5f);
  gl_.ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  gl_.ProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
  gl_.PointSize(3.0f);
  gl_.PointParameterf(GL_POINT_FADE_THRESHOLD_SIZE, 2.0f);
  gl_.PointParameteri(GL_POINT_SPRITE_COORD_ORIGIN, GL_LOWER_LEFT);
  gl_.SampleCoverage(0.25f, GL_TRUE);
  gl_.SampleMaski(0, 0);
  gl_.MinSampleShading(0.5f);
  gl_.PrimitiveRestartIndex(2);
  gl_.PatchParameteri(GL_PATCH_VERTICES, 4);
  const std::array<float, 4> levels = {2.0f, 3.0f, 4.0f, 5.0f};
  gl_.PatchParameterfv(GL_PATCH_DEFAULT_OUTER_LEVEL, levels.data());
  gl_.PatchParameterfv(GL_PATCH_DEFAULT_INNER_LEVEL, levels.data());
  gl_.LogicOp(GL_XOR);
  gl_.Hint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, GL_NICEST);
  gl_.ClampColor(GL_CLAMP_READ_COLOR, GL_TRUE);

  // On by default: dither and multisample. All others are off.
  for (const Field& field : kEnables)
    (gl_.IsEnabled(field.query) == GL_TRUE ? gl_.Disable : gl_.Enable)(field.query);
  for (GLuint i = 0; i < static_cast<GLuint>(limit(gl_, GL_MAX_VIEWPORTS)); ++i) {
    const auto f = static_cast<float>(i);
    gl_.ViewportIndexedf(i, 1.5f + f, 2.0f + f, 3.0f + f, 4.0f + f);
    gl_.DepthRangeIndexed(i, 0.875 - 0.03125 * static_cast<double>(i), 0.125);
    gl_.ScissorIndexed(i, 1, static_cast<GLint>(i), 2 + static_cast<GLint>(i), 1);
    if (i % 2 == 0) gl_.Enablei(GL_SCISSOR_TEST, i);
  }
  constexpr std::array<GLenum, 8> factors = {GL_DST_COLOR,           GL_SRC_COLOR,
                                             GL_ONE_MINUS_DST_COLOR, GL_CONSTANT_COLOR,
                                             GL_CONSTANT_ALPHA,      GL_ONE_MINUS_CONSTANT_ALPHA,
                                             GL_DST_ALPHA,           GL_ONE_MINUS_DST_ALPHA};
  constexpr std::array<GLenum, 4> equations = {GL_MAX, GL_MIN, GL_FUNC_SUBTRACT, GL_FUNC_REVERSE_SUBTRACT};
  for (GLuint i = 0; i < static_cast<GLuint>(limit(gl_, GL_MAX_DRAW_BUFFERS)); ++i) {
    gl_.BlendFuncSeparatei(i, factors[i % 8], factors[(i + 1) % 8], factors[(i + 2) % 8],
                           factors[(i + 3) % 8]);
    gl_.BlendEquationSeparatei(i, equations[i % 4], equations[(i + 1) % 4]);
    gl_.ColorMaski(i, i % 2 == 1 ? GL_TRUE : GL_FALSE, GL_FALSE, GL_TRUE, GL_FALSE);
    if (i % 2 == 0) gl_.Enablei(GL_BLEND, i);
  }
}

OddState::~OddState() {
  gl_.UseProgram(0);
  gl_.DeleteProgram(program_);
  gl_.DeleteProgram(separable_);
  gl_.DeleteProgramPipelines(1, &pipeline_);
  gl_.DeleteTransformFeedbacks(1, &feedback_);
  gl_.DeleteVertexArrays(1, &vertexArray_);
  gl_.DeleteRenderbuffers(1, &renderbuffer_);
  gl_.DeleteFramebuffers(static_cast<GLsizei>(framebuffers_.size()), framebuffers_.data());
  gl_.DeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
  gl_.DeleteSamplers(static_cast<GLsizei>(samplers_.size()), samplers_.data());
  gl_.DeleteBuffers(static_cast<GLsizei>(buffers_.size()), buffers_.data());
}

}  // namespace tessera::test
