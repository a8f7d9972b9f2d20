// Structs of glsl/shared have the same layout in C++ and in the driver's std430 and std140.
#include <cstddef>

#include "engine/gl/program.hpp"
#include "glsl/shared/acuity.h"
#include "glsl/shared/blocks.h"
#include "glsl/shared/material.h"
#include "glsl/shared/scene.h"
#include "glsl/shared/tess_atlas.h"
#include "glsl/shared/texel.h"
#include "glsl/shared/yuv.h"
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

TEST_F(Layout, TessellationGatherer) {
  const GLenum variable = GL_BUFFER_VARIABLE;
  const GLuint request = use({"pass/tess_request.comp"}, {});
  expectStride(request, "states[0].epoch", sizeof(glsl::TessState));
  expectOffset(request, variable, "states[0].shape.form", offsetof(glsl::TessState, shape.form));
  expectOffset(request, variable, "states[0].place0", offsetof(glsl::TessState, place0));
  expectOffset(request, variable, "states[0].pending", offsetof(glsl::TessState, pending));
  expectOffset(request, variable, "states[0].epoch", offsetof(glsl::TessState, epoch));
  expectStride(request, "measures[0].edge0", sizeof(glsl::TessMeasure));
  expectOffset(request, variable, "measures[0].height", offsetof(glsl::TessMeasure, height));
  const GLuint plan = use({"pass/tess_plan.comp"}, {});
  expectStride(plan, "bins[0].cellWidth", sizeof(glsl::TessBin));
  expectOffset(plan, variable, "bins[0].stackCount", offsetof(glsl::TessBin, stackCount));
  expectOffset(plan, variable, "bins[0].spare", offsetof(glsl::TessBin, spare));
  expectOffset(plan, variable, "bins[0].provided", offsetof(glsl::TessBin, provided));
  expectStride(plan, "runs[0].firstCell", sizeof(glsl::TessRun));
  expectOffset(plan, variable, "runs[0].columns", offsetof(glsl::TessRun, columns));
  using State = glsl::TessAtlasState;
  for (const auto& [name, offset] :
       {std::pair<const char*, std::size_t>{"config.height", offsetof(State, config.height)},
        {"config.views", offsetof(State, config.views)},
        {"config.hysteresis", offsetof(State, config.hysteresis)},
        {"config.limits.columns", offsetof(State, config.limits.columns)},
        {"config.pressure.highWater", offsetof(State, config.pressure.highWater)},
        {"config.pressure.adapts", offsetof(State, config.pressure.adapts)},
        {"requestGroupsX", offsetof(State, requestGroupsX)},
        {"epoch", offsetof(State, epoch)},
        {"rectCount", offsetof(State, rectCount)},
        {"liveTexels", offsetof(State, liveTexels)},
        {"wantedTexels", offsetof(State, wantedTexels)},
        {"bias", offsetof(State, bias)},
        {"pressure.target", offsetof(State, pressure.target)},
        {"pressure.reset", offsetof(State, pressure.reset)},
        {"events.failures", offsetof(State, events.failures)},
        {"events.outside", offsetof(State, events.outside)},
        {"rects[0].x", offsetof(State, rects)},
        {"rects[0].height", offsetof(State, rects) + offsetof(glsl::FreeRect, height)},
        {"ideal[0].low", offsetof(State, ideal)},
        {"ideal[0].singles", offsetof(State, ideal) + offsetof(glsl::TessIdeal, singles)}})
    expectOffset(plan, variable, std::string("atlas.") + name, offset);
  const GLuint emit = use({"pass/tess_emit.comp"}, {});
  expectStride(emit, "entries[0].place0", sizeof(glsl::TessEntry));
  expectOffset(emit, variable, "entries[0].shape.form", offsetof(glsl::TessEntry, shape.form));
  expectOffset(emit, variable, "entries[0].place1", offsetof(glsl::TessEntry, place1));
  expectOffset(emit, variable, "entries[0].vertex2", offsetof(glsl::TessEntry, vertex2));
  expectOffset(emit, variable, "entries[0].instance", offsetof(glsl::TessEntry, instance));
  expectStride(emit, "drawVertices[0].x", sizeof(glsl::TessVertex));
  expectOffset(emit, variable, "drawVertices[0].w", offsetof(glsl::TessVertex, w));
  expectStride(emit, "commands[0].count", sizeof(glsl::TessCommand));
  expectOffset(emit, variable, "commands[0].first", offsetof(glsl::TessCommand, first));
  const GLuint scan = use({"pass/tess_scan.comp"}, {});
  expectStride(scan, "groups[0].x", sizeof(glsl::TessGroups));
  expectOffset(scan, variable, "groups[0].samples", offsetof(glsl::TessGroups, samples));
}

TEST_F(Layout, Video) {
  const GLenum variable = GL_BUFFER_VARIABLE;
  const GLuint pack = use({"pass/yuv_pack.comp"}, {{"SIDE", "2"}});
  expectOffset(pack, variable, "header.frame", offsetof(glsl::YuvHeader, frame));
  expectOffset(pack, variable, "header.width", offsetof(glsl::YuvHeader, width));
  expectOffset(pack, variable, "header.height", offsetof(glsl::YuvHeader, height));
  expectOffset(pack, variable, "header.side", offsetof(glsl::YuvHeader, side));
  expectOffset(pack, variable, "planes[0]", sizeof(glsl::YuvHeader));
}

TEST_F(Layout, TexelShading) {
  const GLenum variable = GL_BUFFER_VARIABLE;
  const GLuint queue = use({"pass/texel_queue.comp"}, {});
  expectStride(queue, "tiles[0].patchId", sizeof(glsl::TexelTile));
  expectOffset(queue, variable, "queue[0].slot", offsetof(glsl::TexelTile, slot));
  expectStride(queue, "batches[0].queued", sizeof(glsl::TexelBatch));
  expectOffset(queue, variable, "batches[0].firstTile", offsetof(glsl::TexelBatch, firstTile));
  const GLuint scan = use({"pass/texel_scan.comp"}, {});
  expectOffset(scan, variable, "batches[0].recordGroupsX", offsetof(glsl::TexelBatch, recordGroupsX));
  expectOffset(scan, variable, "batches[0].entries", offsetof(glsl::TexelBatch, entries));
  const GLuint mark = use({"pass/texel_mark.comp"}, {});
  expectStride(mark, "charts[0].base", sizeof(glsl::TexelChart));
  const GLuint fit = use({"pass/texel_fit.comp"}, {});
  using State = glsl::TexelState;
  for (const auto& [name, offset] :
       {std::pair<const char*, std::size_t>{"config.lowestBias", offsetof(State, config.lowestBias)},
        {"pressure.bias", offsetof(State, pressure.bias)},
        {"pressure.falling", offsetof(State, pressure.falling)},
        {"shownCoarser", offsetof(State, shownCoarser)},
        {"tiles1", offsetof(State, tiles1)},
        {"clearGroupsX", offsetof(State, clearGroupsX)},
        {"tileGroupsZ", offsetof(State, tileGroupsZ)}})
    expectOffset(fit, variable, std::string("texels.") + name, offset);
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
