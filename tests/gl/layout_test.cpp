// Structs of glsl/shared have the same layout in C++ and in the driver's std430 and std140.
#include <cstddef>

#include "engine/gl/program.hpp"
#include "glsl/shared/acuity.h"
#include "glsl/shared/blocks.h"
#include "glsl/shared/material.h"
#include "glsl/shared/scene.h"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

class Layout : public test::GlTest {
 protected:
  GLuint use(const std::vector<std::string>& paths, const gl::Defines& defines) {
    auto program = programs_.get(paths, defines);
    if (!program) {
      ADD_FAILURE() << program.error().message;
      return 0;
    }
    return (*program)->get();
  }
  /// A property of a buffer variable or uniform; -1 where the driver does not list it.
  static GLint property(GLuint program, GLenum interface, const std::string& name, GLenum what) {
    const GLuint index = gl::api().GetProgramResourceIndex(program, interface, name.c_str());
    GLint value = -1;
    if (index != GL_INVALID_INDEX)
      gl::api().GetProgramResourceiv(program, interface, index, 1, &what, 1, nullptr, &value);
    return value;
  }
  static void expectOffset(GLuint program, GLenum interface, const std::string& name, std::size_t offset) {
    EXPECT_EQ(property(program, interface, name, GL_OFFSET), static_cast<GLint>(offset)) << name;
  }
  static void expectStride(GLuint program, const std::string& name, std::size_t size) {
    EXPECT_EQ(property(program, GL_BUFFER_VARIABLE, name, GL_TOP_LEVEL_ARRAY_STRIDE),
              static_cast<GLint>(size))
        << name;
  }

 private:
  gl::ProgramCache programs_{test::context()};
};

TEST_F(Layout, StorageBuffers) {
  const GLuint emit = use({"pass/rect_emit.comp"}, {});
  const GLenum variable = GL_BUFFER_VARIABLE;
  expectStride(emit, "instances[0].row0", sizeof(glsl::InstanceGpu));
  expectOffset(emit, variable, "instances[0].row2", offsetof(glsl::InstanceGpu, row2));
  expectOffset(emit, variable, "instances[0].patchBase", offsetof(glsl::InstanceGpu, patchBase));
  expectOffset(emit, variable, "instances[0].singles", offsetof(glsl::InstanceGpu, singles));
  expectOffset(emit, variable, "instances[0].batch", offsetof(glsl::InstanceGpu, batch));
  expectOffset(emit, variable, "instances[0].flags", offsetof(glsl::InstanceGpu, flags));
  expectStride(emit, "patches[0].v0", sizeof(glsl::PatchGeometry));
  expectOffset(emit, variable, "patches[0].v4", offsetof(glsl::PatchGeometry, v4));
  expectOffset(emit, variable, "patches[0].triangles", offsetof(glsl::PatchGeometry, triangles));
  expectStride(emit, "drawVertices[0].x", sizeof(glsl::DisplayVertex));
  expectOffset(emit, variable, "drawVertices[0].texel", offsetof(glsl::DisplayVertex, texel));
  expectStride(emit, "gatherVertices[0].vertex", sizeof(glsl::GatherVertex));
  expectOffset(emit, variable, "gatherVertices[0].instance", offsetof(glsl::GatherVertex, instance));
  expectStride(emit, "commands[0].count", sizeof(glsl::DrawCommand));
  expectOffset(emit, variable, "commands[0].baseInstance", offsetof(glsl::DrawCommand, baseInstance));
  expectStride(emit, "batches[0].firstEntry", sizeof(glsl::BatchGpu));
}

TEST_F(Layout, UniformBlocks) {
  const GLuint shade = use({"pass/forward.vert", "pass/shade.frag"}, {{"BASE_TEX", "1"},
                                                                      {"USES_UV0", "1"},
                                                                      {"UV_TRANSFORM", "1"},
                                                                      {"LIGHTS", "1"},
                                                                      {"SHADOWS", "1"},
                                                                      {"HEMISPHERE", "1"}});
  const GLenum uniform = GL_UNIFORM;
  expectOffset(shade, uniform, "material.baseColor", offsetof(glsl::MaterialGpu, baseColor));
  expectOffset(shade, uniform, "material.factors", offsetof(glsl::MaterialGpu, factors));
  expectOffset(shade, uniform, "material.uvRows[0]", offsetof(glsl::MaterialGpu, uvRows));
  EXPECT_EQ(property(shade, uniform, "material.uvRows[0]", GL_ARRAY_STRIDE), 16);
  expectOffset(shade, uniform, "frame.ambientGround", offsetof(glsl::FrameGpu, ambientGround));
  expectOffset(shade, uniform, "frame.lightCount", offsetof(glsl::FrameGpu, lightCount));
  expectOffset(shade, uniform, "lights[0].radiance", offsetof(glsl::LightGpu, radiance));
  expectOffset(shade, uniform, "lights[0].coneScale", offsetof(glsl::LightGpu, coneScale));
  expectOffset(shade, uniform, "lights[0].shadowLayer", offsetof(glsl::LightGpu, shadowLayer));
  expectOffset(shade, uniform, "lights[1].position", sizeof(glsl::LightGpu));
  expectOffset(shade, uniform, "shadows[0].texel", offsetof(glsl::ShadowGpu, texel));
  expectOffset(shade, uniform, "shadows[1].viewProjection", sizeof(glsl::ShadowGpu));
  expectOffset(shade, uniform, "view.eye", offsetof(glsl::ViewGpu, eye));
  const GLuint measure = use({"pass/rect_measure.comp"}, {{"FOVEATE", "1"}, {"LENS", "1"}});
  expectOffset(measure, uniform, "densities[0].axis", offsetof(glsl::DensityGpu, axis));
  expectOffset(measure, uniform, "densities[0].acuity", offsetof(glsl::DensityGpu, acuity));
  expectOffset(measure, uniform, "densities[0].lens", offsetof(glsl::DensityGpu, lens));
  expectOffset(measure, uniform, "densities[1].gaze", sizeof(glsl::DensityGpu));
}

}  // namespace
}  // namespace tessera
