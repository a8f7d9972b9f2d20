// One scene by every method.
#pragma once

#include <string>
#include <vector>

#include "apps/tessera/compare/method.hpp"
#include "apps/tessera/compare/options.hpp"
#include "apps/tessera/report/report.hpp"

namespace tessera::app {

/// Loads the scene `file`, draws it by every method, forward first, those that fill an atlas again with each
/// visible set of `pvs`, and reports what was measured.
Result<ReportScene> compareScene(gl::Context& context, const std::string& file,
                                 const std::vector<Method>& asked, const std::vector<Pvs>& pvs,
                                 const CompareOptions& options, glm::ivec2 size);

}  // namespace tessera::app
