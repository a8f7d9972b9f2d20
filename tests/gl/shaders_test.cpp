// Every pass in every permutation that matters compiles: on this context, and with glslangValidator, since
// some compilers accept what others refuse.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "engine/core/embedded.hpp"
#include "engine/gl/program.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

struct Case {
  std::string path;
  std::string defines;  // space-separated, NAME or NAME=VALUE
};

const std::string kAll =
    "BASE_TEX MR_TEX NORMAL_TEX OCCLUSION_TEX EMISSIVE_TEX VERTEX_COLOR USES_UV0 USES_UV1 UV_TRANSFORM "
    "LIGHTS SHADOWS "
    "HEMISPHERE";

/// The permutations of one pass. A pass that is not named here has one, without defines.
std::vector<std::string> permutationsOf(const std::string& path) {
  const std::vector<std::string> surface = {"",
                                            kAll,
                                            kAll + " MASK DOUBLE_SIDED",
                                            kAll + " BLEND DOUBLE_SIDED",
                                            "UNLIT BASE_TEX USES_UV0",
                                            "UNLIT VERTEX_COLOR",
                                            "BASE_TEX USES_UV1 LIGHTS",
                                            "NORMAL_TEX USES_UV0 DOUBLE_SIDED LIGHTS SHADOWS"};
  const std::vector<std::string> depth = {"", "MASK", "MASK BASE_TEX", "MASK BASE_TEX USES_UV1 VERTEX_COLOR",
                                          "MASK VERTEX_COLOR"};
  std::vector<std::string> all;
  if (path == "pass/shade.frag") {
    all = surface;
    for (const std::string& defines : surface)
      if (defines.find("MASK") == std::string::npos) all.push_back(defines + " GATHER");
    all.push_back(kAll + " DOUBLE_SIDED GATHER");
  } else if (path == "pass/forward.vert") {
    all = surface;
  } else if (path == "pass/gather.vert") {
    for (const std::string& defines : surface) all.push_back(defines + " GATHER");
  } else if (path == "pass/depth.vert") {
    for (const std::string& defines : depth)
      for (const char* more : {"", " WRITE_ID", " WRITE_ID LAYERS", " SHADOW_LAYER"})
        all.push_back(defines + more);
  } else if (path == "pass/depth.frag" || path == "pass/id.frag" || path == "pass/tess_display.vert" ||
             path == "pass/tess_display.frag") {
    all = depth;
  } else if (path == "pass/display.vert" || path == "pass/display.frag") {
    for (const std::string& defines : depth)
      for (const char* charts : {"", " CHARTS"}) all.push_back(defines + charts);
  } else if (path == "pass/visible_blended.frag") {
    all = {"", "TRIANGLES"};
  } else if (path == "pass/visible_mark.comp") {
    all = {"", "LAYERS", "TRIANGLES", "TRIANGLES LAYERS"};
  } else if (path == "pass/debug_screen.comp") {
    all = {"MODE=0", "MODE=1", "MODE=2", "MODE=3"};
  } else if (path == "pass/rect_measure.comp" || path == "pass/tess_measure.comp") {
    all = {"", "FOVEATE", "LENS", "FOVEATE LENS"};
  } else if (path == "pass/display_deferred.comp") {
    all = {"", "LINEAR_ATLAS", "TRIANGLES", "TRIANGLES LINEAR_ATLAS", "CHARTS", "CHARTS LINEAR_ATLAS"};
  } else if (path == "pass/rect_emit.comp") {
    all = {"", "CHARTS"};
  } else if (path == "pass/yuv_pack.comp" || path == "pass/yuv_unpack.comp") {
    all = {"SIDE=1", "SIDE=2"};
  } else if (path == "pass/texel_mark.comp") {
    all = {"", "LAYERS"};
  } else if (path == "pass/tess_gather.comp" || path == "pass/texel_gather.comp" ||
             path == "pass/tess_raster.frag" || path == "pass/tess_spawn.tesc" ||
             path == "pass/tess_spawn.tese") {
    // What gathers is never masked, and never blends.
    const std::string group = path == "pass/tess_gather.comp" ? " GROUP=64" : "";
    for (const std::string& defines : surface)
      if (defines.find("MASK") == std::string::npos && defines.find("BLEND") == std::string::npos)
        for (const char* encoded : {"", " ENCODED"}) all.push_back(defines + group + encoded);
    if (!group.empty())
      for (const char* other : {"32", "128", "256", "512"}) all.push_back(std::string("GROUP=") + other);
  } else {
    all = {""};
  }
  return all;
}

std::vector<Case> allCases() {
  std::vector<Case> cases;
  for (const EmbeddedText& file : embeddedGlsl()) {
    const std::string path(file.path);
    if (path.rfind("pass/", 0) != 0) continue;
    for (const std::string& defines : permutationsOf(path)) cases.push_back({path, defines});
  }
  return cases;
}

gl::Defines parse(const std::string& text) {
  gl::Defines defines;
  std::istringstream in(text);
  for (std::string word; in >> word;) {
    const std::size_t equals = word.find('=');
    defines[word.substr(0, equals)] = equals == std::string::npos ? "1" : word.substr(equals + 1);
  }
  return defines;
}

using Shaders = test::GlTest;

TEST_F(Shaders, AllCompileHere) {
  const auto cases = allCases();
  ASSERT_GT(cases.size(), 40u);
  for (const Case& one : cases) {
    std::vector<std::string> files;
    const auto text =
        gl::assembleShader(test::context().info().shaderHeader, one.path, parse(one.defines), files);
    ASSERT_TRUE(text) << text.error().message;
    const std::string ending = std::filesystem::path(one.path).extension().string();
    const GLenum stage = ending == ".vert"   ? GL_VERTEX_SHADER
                         : ending == ".frag" ? GL_FRAGMENT_SHADER
                         : ending == ".tesc" ? GL_TESS_CONTROL_SHADER
                         : ending == ".tese" ? GL_TESS_EVALUATION_SHADER
                                             : GL_COMPUTE_SHADER;
    const GLuint shader = gl::api().CreateShader(stage);
    const char* source = text->c_str();
    gl::api().ShaderSource(shader, 1, &source, nullptr);
    gl::api().CompileShader(shader);
    GLint ok = 0;
    gl::api().GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    std::string log(4096, '\0');
    gl::api().GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    EXPECT_EQ(ok, GL_TRUE) << one.path << " " << one.defines << "\n" << log.c_str();
    gl::api().DeleteShader(shader);
  }
}

TEST_F(Shaders, AllCompileWithGlslang) {
  if (std::system("glslangValidator --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "glslangValidator is not installed (package glslang-tools)";
  const std::filesystem::path folder =
      std::filesystem::path(TESSERA_BINARY_DIR) / "glslang" / test::context().info().backendName;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::string list;
  int number = 0;
  for (const Case& one : allCases()) {
    std::vector<std::string> files;
    const auto text = gl::assembleShader("#version 460 core\n", one.path, parse(one.defines), files);
    ASSERT_TRUE(text) << text.error().message;
    const std::string name =
        fmt::format("{:03}_{}", number++, std::filesystem::path(one.path).filename().string());
    std::ofstream(folder / name) << *text;
    list += " " + name;
  }
  const std::string log = (folder / "log.txt").string();
  const int status =
      std::system(fmt::format("cd '{}' && glslangValidator{} > log.txt 2>&1", folder.string(), list).c_str());
  std::ifstream in(log);
  EXPECT_EQ(status, 0) << std::string(std::istreambuf_iterator<char>(in), {});
}

}  // namespace
}  // namespace tessera
