// The figures of a report: bars of work and quality.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// A figure with its numbers, scene by scene; bars of methods that a scene has not are left out.
nlohmann::ordered_json figureJson(const Report& report, const ReportFigure& figure);
/// The figure's section of the page: room for its charts, and a table of its numbers.
std::string figureSection(const Report& report, std::size_t index);

}  // namespace tessera
