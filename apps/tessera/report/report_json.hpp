// Parts of the reports' JSON files.
#pragma once

#include <nlohmann/json.hpp>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// JSON has no NaN or infinity: null.
nlohmann::ordered_json number(double value);
nlohmann::ordered_json timingJson(const Statistics& s);
nlohmann::ordered_json contextJson(const ReportContext& context);

}  // namespace tessera
