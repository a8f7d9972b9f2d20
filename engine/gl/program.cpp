#include "engine/gl/program.hpp"

#include <cstdlib>
#include <filesystem>
#include <set>

#include "engine/core/embedded.hpp"
#include "engine/core/file.hpp"

namespace tessera::gl {

void deleteProgram(GLuint name) { api().DeleteProgram(name); }

namespace {

void deleteShader(GLuint name) { api().DeleteShader(name); }
using Shader = Name<&deleteShader>;

Result<GLenum> stageOf(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".vert") return GLenum{GL_VERTEX_SHADER};
  if (ending == ".frag") return GLenum{GL_FRAGMENT_SHADER};
  if (ending == ".comp") return GLenum{GL_COMPUTE_SHADER};
  if (ending == ".tesc") return GLenum{GL_TESS_CONTROL_SHADER};
  if (ending == ".tese") return GLenum{GL_TESS_EVALUATION_SHADER};
  return fail("{}: '{}' is not the ending of a shader stage", path, ending);
}

/// Replaces "N:" at the start of compiler lines by the file's name, for the drivers that print string
/// numbers.
std::string readableLog(const std::string& log, const std::vector<std::string>& files) {
  std::string legend;
  for (std::size_t i = 0; i < files.size(); ++i)
    legend += fmt::format("{}{} = {}", i == 0 ? "" : ", ", i, files[i]);
  return fmt::format("{}\n(source numbers: {})", log, legend);
}

Result<void> expand(std::string_view path, std::set<std::string, std::less<>>& seen,
                    std::vector<std::string>& files, std::string& out) {
  if (!seen.insert(std::string(path)).second) return {};
  auto text = glslText(path);
  if (!text) return tl::unexpected(text.error());
  const std::size_t number = files.size();
  files.emplace_back(path);
  out += fmt::format("#line 1 {}\n", number);
  std::size_t line = 1;
  for (std::size_t begin = 0; begin < text->size(); ++line) {
    std::size_t end = text->find('\n', begin);
    if (end == std::string::npos) end = text->size();
    const std::string_view row(text->data() + begin, end - begin);
    begin = end + 1;
    constexpr std::string_view kInclude = "#include \"";
    if (row.substr(0, kInclude.size()) != kInclude) {
      out.append(row).push_back('\n');
      continue;
    }
    const std::size_t close = row.find('"', kInclude.size());
    if (close == std::string_view::npos) return fail("{}:{}: #include without closing quote", path, line);
    if (auto included = expand(row.substr(kInclude.size(), close - kInclude.size()), seen, files, out);
        !included)
      return fail("{} (included from {}:{})", included.error().message, path, line);
    out += fmt::format("#line {} {}\n", line + 1, number);
  }
  return {};
}

}  // namespace

Result<std::string> glslText(std::string_view path) {
  // Read on each call: the override is a development aid, and a host may set it at any time.
  if (const char* folder = std::getenv("TESSERA_GLSL_DIR"); folder != nullptr && *folder != '\0') {
    auto bytes = readFile(std::filesystem::path(folder) / path);
    if (!bytes) return tl::unexpected(bytes.error());
    return std::string(bytes->begin(), bytes->end());
  }
  for (const EmbeddedText& file : embeddedGlsl())
    if (file.path == path) return std::string(file.text);
  return fail("{}: no such shader file is embedded", path);
}

Result<std::string> assembleShader(std::string_view header, std::string_view path, const Defines& defines,
                                   std::vector<std::string>& files) {
  std::string out(header);
  for (const auto& [name, value] : defines) out += fmt::format("#define {} {}\n", name, value);
  std::set<std::string, std::less<>> seen;
  if (auto expanded = expand(path, seen, files, out); !expanded) return tl::unexpected(expanded.error());
  return out;
}

Result<Program> Program::build(const Context& context, const std::vector<std::string>& paths,
                               const Defines& defines) {
  const GladGLContext& gl = api();
  Program program;
  program.name_ = Name<&deleteProgram>(gl.CreateProgram());
  std::vector<Shader> shaders;
  std::string label;
  for (const std::string& path : paths) {
    auto stage = stageOf(path);
    if (!stage) return tl::unexpected(stage.error());
    std::vector<std::string> files;
    auto text = assembleShader(context.info().shaderHeader, path, defines, files);
    if (!text) return tl::unexpected(text.error());
    Shader shader(gl.CreateShader(*stage));
    const char* source = text->c_str();
    gl.ShaderSource(shader.get(), 1, &source, nullptr);
    gl.CompileShader(shader.get());
    GLint ok = 0;
    gl.GetShaderiv(shader.get(), GL_COMPILE_STATUS, &ok);
    if (ok == 0) {
      std::string log(16384, '\0');
      GLsizei length = 0;
      gl.GetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), &length, log.data());
      log.resize(static_cast<std::size_t>(length));
      return fail("{}: does not compile: {}", path, readableLog(log, files));
    }
    gl.AttachShader(program.get(), shader.get());
    shaders.push_back(std::move(shader));
    label += (label.empty() ? "" : " + ") + path;
  }
  gl.LinkProgram(program.get());
  for (const Shader& shader : shaders) gl.DetachShader(program.get(), shader.get());
  GLint ok = 0;
  gl.GetProgramiv(program.get(), GL_LINK_STATUS, &ok);
  if (ok == 0) {
    std::string log(16384, '\0');
    GLsizei length = 0;
    gl.GetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    return fail("{}: does not link: {}", label, log);
  }
  return program;
}

void Program::use() const { api().UseProgram(name_.get()); }
void Program::set(GLint location, int value) const { api().ProgramUniform1i(name_.get(), location, value); }
void Program::set(GLint location, unsigned value) const {
  api().ProgramUniform1ui(name_.get(), location, value);
}
void Program::set(GLint location, float value) const { api().ProgramUniform1f(name_.get(), location, value); }

void dispatchOver(int width, int height, int side) {
  api().DispatchCompute(static_cast<GLuint>((width + side - 1) / side),
                        static_cast<GLuint>((height + side - 1) / side), 1);
}

void dispatchIndirect(const Buffer& groups, std::size_t offset) {
  api().BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, groups.get());
  api().DispatchComputeIndirect(static_cast<GLintptr>(offset));
}

Result<void> ProgramCache::getAll(std::initializer_list<Wanted> wanted) {
  for (const Wanted& want : wanted) {
    auto program = get({want.path}, want.defines);
    if (!program) return tl::unexpected(program.error());
    *want.program = *program;
  }
  return {};
}

Result<const Program*> ProgramCache::get(const std::vector<std::string>& paths, const Defines& own) {
  Defines defines = own;
  defines.insert(common_.begin(), common_.end());
  std::string key;
  for (const std::string& path : paths) key += (key.empty() ? "" : " + ") + path;
  for (const auto& [name, value] : defines)
    key += fmt::format(" {}{}", name, value == "1" ? "" : "=" + value);
  auto found = programs_.find(key);
  if (found == programs_.end()) {
    auto program = Program::build(*context_, paths, defines);
    if (!program) return tl::unexpected(program.error());
    found = programs_.emplace(key, std::make_unique<Program>(std::move(*program))).first;
    compiled_.push_back(key);
  }
  return static_cast<const Program*>(found->second.get());
}

}  // namespace tessera::gl
