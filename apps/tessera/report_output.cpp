#include "apps/tessera/report_output.hpp"

#include <fstream>

#include <fmt/core.h>

#include "engine/core/file.hpp"
#include "engine/gl/timer.hpp"

namespace tessera::app {

std::string commandLine(int argc, const char* const* argv) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=.,:/@%";
  std::string line = "tessera";
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    line += ' ';
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) {
      // A quote ends the quoted part, stands for itself, and starts the next.
      if (c == '\'')
        line += "'\\''";
      else
        line += c;
    }
    line += '\'';
  }
  return line;
}

Result<void> checkWritable(const std::filesystem::path& file) {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  if (error) return fail("{}: cannot be created ({})", file.parent_path().string(), error.message());
  if (std::filesystem::is_directory(file, error)) return fail("{}: is a folder, not a file", file.string());
  // As writeFile() does: beside its place, to be renamed.
  std::filesystem::path probe = file;
  probe += ".partial";
  if (!std::ofstream(probe, std::ios::binary | std::ios::app))
    return fail("{}: cannot be written", file.string());
  std::filesystem::remove(probe, error);
  return {};
}

ReportContext reportContext(const gl::ContextInfo& info, const std::string& command) {
  return {
      info.backendName, info.renderer, info.version, info.glslVersion, gl::nameOf(gl::timerModeFor(info)), {},
      command};
}

Result<ReportFiles> ReportFiles::create(const std::filesystem::path& folder, const std::string& name,
                                        const std::string& page) {
  ReportFiles files;
  files.json_ = folder / (name + ".json");
  files.html_ = folder / ((page.empty() ? name : page) + ".html");
  for (const auto& file : {files.json_, files.html_})
    if (auto writable = checkWritable(file); !writable) return tl::unexpected(writable.error());
  return files;
}

Result<void> ReportFiles::write(const std::string& json, const std::string& html) const {
  if (auto written = writeFile(json_, json); !written) return written;
  if (auto written = writeFile(html_, html); !written) return written;
  fmt::print("{}\n", html_.string());
  return {};
}

}  // namespace tessera::app
