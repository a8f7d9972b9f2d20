// A report with made-up numbers, each of them different, and synthetic pictures.
#pragma once

#include <vector>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// `names` of the methods, the first one usually "forward"; `pictures` frames of 320x180.
ReportScene fixtureScene(const std::string& file, const std::vector<std::string>& names, int pictures);
Report fixtureReport();

}  // namespace tessera
