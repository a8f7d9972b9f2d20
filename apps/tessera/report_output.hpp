// What the subcommands that write a report have in common.
#pragma once

#include <filesystem>
#include <string>

#include "apps/tessera/report/report.hpp"
#include "engine/gl/context.hpp"

namespace tessera::app {

/// The command line as a shell takes it, words quoted where it needs that.
std::string commandLine(int argc, const char* const* argv);

/// Fails where a file cannot be written or replaced, so that minutes of work are not lost at their end. Makes
/// missing folders; leaves a file that is there as it is.
Result<void> checkWritable(const std::filesystem::path& file);

/// `command`: what made the report.
ReportContext reportContext(const gl::ContextInfo& info, const std::string& command);

/// Where a report is written: `name`.json and `page`.html, or `name`.html, in a folder.
class ReportFiles {
 public:
  /// Makes the folder; fails where it or the files cannot be written.
  static Result<ReportFiles> create(const std::filesystem::path& folder, const std::string& name,
                                    const std::string& page = {});
  /// Writes both, and prints where the page is.
  [[nodiscard]] Result<void> write(const std::string& json, const std::string& html) const;

 private:
  std::filesystem::path json_, html_;
};

}  // namespace tessera::app
