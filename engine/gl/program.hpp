// Shader programs from the embedded GLSL: includes, permutations by defines, per-context version lines.
#pragma once

#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <glad/gl.h>

#include "engine/core/result.hpp"
#include "engine/gl/objects.hpp"

namespace tessera::gl {

void deleteProgram(GLuint name);

/// One permutation: names and values that become #define lines, sorted by name.
using Defines = std::map<std::string, std::string>;

/// The text of one GLSL file: from the folder TESSERA_GLSL_DIR when that is set in the environment, else
/// embedded.
Result<std::string> glslText(std::string_view path);

/// The full text that the compiler is given: context header, defines, then the file with every
/// #include "x" replaced once. `files` receives the name behind each number of the #line directives.
Result<std::string> assembleShader(std::string_view header, std::string_view path, const Defines& defines,
                                   std::vector<std::string>& files);

/// A linked program. Uniform locations are fixed in the shaders (layout(location = n)).
class Program {
 public:
  Program() = default;
  /// Compiles and links; the stage follows from each file's ending (.vert .frag .comp .tesc .tese).
  static Result<Program> build(const Context& context, const std::vector<std::string>& paths,
                               const Defines& defines = {});
  [[nodiscard]] GLuint get() const { return name_.get(); }
  [[nodiscard]] explicit operator bool() const { return static_cast<bool>(name_); }
  void use() const;
  void set(GLint location, int value) const;
  void set(GLint location, unsigned value) const;
  void set(GLint location, float value) const;

 private:
  Name<&deleteProgram> name_;
};

/// Runs the compute program in use with a thread for each of width x height pixels, in groups of side x side.
void dispatchOver(int width, int height, int side = 8);
/// Runs it with the group counts, a uvec3, at `offset` of a buffer.
void dispatchIndirect(const Buffer& groups, std::size_t offset = 0);

/// Programs by files and defines, each compiled once and kept.
class ProgramCache {
 public:
  explicit ProgramCache(const Context& context) : context_(&context) {}
  /// Added to the defines of every program from here on.
  void setCommon(Defines defines) { common_ = std::move(defines); }
  /// The program, compiled on first use. The reference lives as long as the cache.
  Result<const Program*> get(const std::vector<std::string>& paths, const Defines& defines = {});
  /// A program and where its reference goes.
  struct Wanted {
    const Program** program;
    std::string path;
    Defines defines = {};
  };
  Result<void> getAll(std::initializer_list<Wanted> wanted);
  /// "shade.frag NORMAL_MAP SHADOWS" of every program compiled so far, in order of compilation.
  [[nodiscard]] const std::vector<std::string>& compiled() const { return compiled_; }

 private:
  const Context* context_;
  Defines common_;
  std::map<std::string, std::unique_ptr<Program>> programs_;
  std::vector<std::string> compiled_;
};

}  // namespace tessera::gl
