// The shared headers give on the GPU what they give in C++, and the tessellator spawns what they say.
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "engine/gl/objects.hpp"
#include "engine/gl/program.hpp"
#include "tests/gl_test.hpp"
#include "tests/tessellation/probe.h"

namespace tessera {
namespace {

using glsl::Probe;
using glsl::uint;
using Twin = test::GlTest;

constexpr uint kProbes = 8192;

/// The headers' text for the compiler of `header`'s version, then that of probe.h and a main.
std::string withHeaders(const std::string& header, const std::string& rest) {
  std::vector<std::string> files;
  const auto text = gl::assembleShader(header, "shared/tess_measure.h", {}, files);
  EXPECT_TRUE(text);
  return text ? *text + "\n" + rest : "";
}

std::string probeShader(const std::string& header) {
  std::ifstream in(TESSERA_SOURCE_DIR "/tests/tessellation/probe.h");
  EXPECT_TRUE(in);
  std::string probe;
  for (std::string line; std::getline(in, line);)
    if (line.rfind("#include", 0) != 0) probe += line + "\n";
  return withHeaders(header, probe + R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Found { Probe found[]; };
void main() { found[gl_GlobalInvocationID.x] = probe(gl_GlobalInvocationID.x); }
)");
}

GLuint link(const std::vector<std::pair<GLenum, std::string>>& stages) {
  const auto& gl = gl::api();
  const GLuint program = gl.CreateProgram();
  for (const auto& [stage, text] : stages) {
    const GLuint shader = gl.CreateShader(stage);
    const char* source = text.c_str();
    gl.ShaderSource(shader, 1, &source, nullptr);
    gl.CompileShader(shader);
    std::string log(4096, '\0');
    gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    GLint ok = 0;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    EXPECT_EQ(ok, GL_TRUE) << log.c_str();
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program);
  GLint ok = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
  EXPECT_EQ(ok, GL_TRUE);
  return program;
}

bool near(const glm::vec4& a, const glm::vec4& b, float absolute, float relative) {
  for (int i = 0; i < 4; ++i)
    if (!(std::abs(a[i] - b[i]) <= absolute + relative * std::abs(b[i]))) return false;
  return true;
}

TEST_F(Twin, TheGpuGivesWhatCppGives) {
  const GLuint program = link({{GL_COMPUTE_SHADER, probeShader(test::context().info().shaderHeader)}});
  const gl::Buffer buffer(kProbes * sizeof(Probe));
  buffer.bindStorage(0);
  gl::api().UseProgram(program);
  gl::api().DispatchCompute(kProbes / 64, 1, 1);
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  const auto found = buffer.readAll<Probe>(kProbes);
  gl::api().UseProgram(0);
  gl::api().DeleteProgram(program);
  // Sizes are rounded up, and the cut of an L leads to either arm: on such a border the last bit decides.
  int borders = 0;
  int kinds[4] = {};  // of the shapes
  for (uint i = 0; i < kProbes; ++i) {
    const Probe& gpu = found[i];
    const Probe cpu = glsl::probe(i);
    ASSERT_EQ(gpu.place, cpu.place) << i;
    ASSERT_EQ(gpu.texels, cpu.texels) << i;
    ASSERT_EQ(gpu.back, cpu.back) << i;
    ASSERT_EQ(gpu.cell, cpu.cell) << i;
    ASSERT_EQ(gpu.record, cpu.record) << i;
    ASSERT_TRUE(near(gpu.sites, cpu.sites, 1e-6f, 1e-4f)) << i;
    ASSERT_TRUE(near(gpu.even, cpu.even, 1e-5f, 1e-5f)) << i;
    const float longest = std::max({cpu.measure.x, cpu.measure.y, cpu.measure.z});
    for (int edge = 0; edge < 3; ++edge)
      ASSERT_NEAR(gpu.measure[edge], cpu.measure[edge], 1e-5f * longest) << i;
    // A flat triangle's height is the root of what rounding leaves.
    ASSERT_NEAR(gpu.measure.w * gpu.measure.w, cpu.measure.w * cpu.measure.w, 2e-6f * longest * longest) << i;
    ASSERT_TRUE(near(gpu.surface, cpu.surface, 1e-4f, 1e-4f)) << i;
    ASSERT_TRUE(near(gpu.screen, cpu.screen, 1e-6f, 1e-5f)) << i;
    borders += near(gpu.decodes, cpu.decodes, 1e-3f, 0.0f) && near(gpu.atlas, cpu.atlas, 1e-2f, 0.0f) ? 0 : 1;
    borders += gpu.shape == cpu.shape ? 0 : 1;
    ++kinds[glsl::kindOf(cpu.shape.x)];
  }
  EXPECT_LE(borders, static_cast<int>(kProbes / 1000));
  for (const uint kind : {glsl::kTessSingle, glsl::kTessL, glsl::kTessOver})
    EXPECT_GT(kinds[kind], 100) << kind;
}

TEST_F(Twin, TheHeadersCompileWithGlslang) {
  if (std::system("glslangValidator --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "glslangValidator is not installed (package glslang-tools)";
  const std::string path =
      std::string(TESSERA_BINARY_DIR) + "/tessellation_probe_" + test::context().info().backendName + ".comp";
  std::ofstream(path) << probeShader("#version 460 core\n");
  EXPECT_EQ(std::system(("glslangValidator '" + path + "' > '" + path + ".log' 2>&1").c_str()), 0)
      << path << ".log";
}

/// What a context's own tessellator spawns for these levels: how often each thread, and where it is.
TEST_F(Twin, TheTessellatorSpawnsEachThreadOnce) {
  const std::string& header = test::context().info().shaderHeader;
  const GLuint program = link({{GL_VERTEX_SHADER, header + "void main() { gl_Position = vec4(0.0); }\n"},
                               {GL_TESS_EVALUATION_SHADER, withHeaders(header, R"(
layout(triangles, equal_spacing, point_mode) in;
layout(std430, binding = 0) buffer Sites { vec4 sites[]; };
layout(std430, binding = 1) buffer Counts { uint counts[]; };
layout(location = 0) uniform uvec4 wanted;
void main() {
  TessLevels levels;
  levels.outer0 = wanted.x;
  levels.outer1 = wanted.y;
  levels.outer2 = wanted.z;
  levels.inner = wanted.w;
  uint thread = tessThread(tessPlaceAt(gl_TessCoord, levels), levels);
  atomicAdd(counts[min(thread, 3169u)], 1u);
  sites[min(thread, 3169u)] = vec4(gl_TessCoord, 0.0);
  gl_Position = vec4(0.0);
}
)")}});
  const auto& gl = gl::api();
  GLuint vao = 0;
  gl.CreateVertexArrays(1, &vao);
  gl.BindVertexArray(vao);
  gl.UseProgram(program);
  // A context may have no framebuffer of its own, and wants one even for what is discarded.
  GLuint framebuffer = 0;
  gl.CreateFramebuffers(1, &framebuffer);
  gl.NamedFramebufferParameteri(framebuffer, GL_FRAMEBUFFER_DEFAULT_WIDTH, 1);
  gl.NamedFramebufferParameteri(framebuffer, GL_FRAMEBUFFER_DEFAULT_HEIGHT, 1);
  GLint before = 0;
  gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &before);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
  gl.Enable(GL_RASTERIZER_DISCARD);
  gl.PatchParameteri(GL_PATCH_VERTICES, 3);
  gl::Buffer sites(3170 * sizeof(glm::vec4));
  gl::Buffer counts(3170 * sizeof(uint));
  sites.bindStorage(0);
  counts.bindStorage(1);
  float worst = 0.0f;
  std::vector<std::array<uint, 4>> cases;
  for (uint l = 1; l <= glsl::kTessLargest; ++l) cases.push_back({l, l, l, l});
  for (uint i = 0; i < 200; ++i) {
    const uint r = glsl::probeNext(i + 77);
    cases.push_back({1 + r % 64, 1 + (r >> 8) % 64, 1 + (r >> 16) % 64, 1 + (r >> 24) % 64});
  }
  for (const auto& c : cases) {
    const glsl::TessLevels levels{c[0], c[1], c[2], c[3]};
    SCOPED_TRACE(testing::Message() << c[0] << " " << c[1] << " " << c[2] << ", inner " << c[3]);
    counts.fill(0);
    const float outer[4] = {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]),
                            1.0f};
    const float inner[2] = {static_cast<float>(c[3]), 1.0f};
    gl.PatchParameterfv(GL_PATCH_DEFAULT_OUTER_LEVEL, outer);
    gl.PatchParameterfv(GL_PATCH_DEFAULT_INNER_LEVEL, inner);
    gl.Uniform4ui(0, c[0], c[1], c[2], c[3]);
    gl.DrawArrays(GL_PATCHES, 0, 3);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const auto hits = counts.readAll<uint>(3170);
    const auto at = sites.readAll<glm::vec4>(3170);
    const uint total = glsl::tessCount(levels);
    for (uint thread = 0; thread < 3170; ++thread) {
      ASSERT_EQ(hits[thread], thread < total ? 1u : 0u) << "thread " << thread << " of " << total;
      if (thread >= total) continue;
      const glm::vec3 expected = glsl::tessBary(glsl::tessPlaceOf(thread, levels), levels);
      for (int axis = 0; axis < 3; ++axis)
        worst = std::max(worst, std::abs(at[thread][axis] - expected[axis]));
    }
  }
  std::printf("gl_TessCoord is off by %.2g at most\n", static_cast<double>(worst));
  // Mesa 22.3 works in fixed point: 2.5e-4, a sixtieth of the smallest step. Gatherers use tessBary instead.
  EXPECT_LT(worst, 3e-4f);
  gl.Disable(GL_RASTERIZER_DISCARD);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(before));
  gl.DeleteFramebuffers(1, &framebuffer);
  gl.UseProgram(0);
  gl.BindVertexArray(0);
  gl.DeleteVertexArrays(1, &vao);
  gl.DeleteProgram(program);
}

}  // namespace
}  // namespace tessera
