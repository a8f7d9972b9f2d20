// Where the time goes from a pose to its picture (Mueller 2021, sec. 7.2.5): `tessera serve` and `tessera
// view` as two processes on this machine.
#pragma once

#include <filesystem>

#include "apps/tessera/report/study_report.hpp"
#include "apps/tessera/study/path.hpp"

namespace tessera::app {

/// Streams the path through both programs. `folder` gets the path's file and what both measured. Does not
/// fail: the result says why there is no time line.
StudyTimeline measureLoopback(const std::string& sceneFile, const std::string& stageFile,
                              const ContextChoice& context, const StudyPath& path,
                              const StudySettings& settings, const std::filesystem::path& folder);

}  // namespace tessera::app
