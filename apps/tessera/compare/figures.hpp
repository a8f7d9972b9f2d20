// The figures of Mueller 2021, ch. 4: which methods each needs, and what the page says of it.
#pragma once

#include <string>
#include <vector>

#include "apps/tessera/report/report.hpp"
#include "engine/core/result.hpp"

namespace tessera::app {

/// The figures named: "4.1", "4.3", "4.6", "4.7", or "all". Their bars name methods as --methods takes them.
/// Fails with a name that is none of these.
Result<std::vector<ReportFigure>> figuresOf(const std::vector<std::string>& names);

}  // namespace tessera::app
