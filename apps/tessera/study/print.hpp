#pragma once

#include "apps/tessera/report/study_report.hpp"

namespace tessera::app {

/// The figures of a scene, and what follows from them, on stdout.
void printStudy(const StudyScene& scene);

}  // namespace tessera::app
