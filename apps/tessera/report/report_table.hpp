// The tables of the report page, as HTML.
#pragma once

#include <string>
#include <string_view>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// Text made fit for HTML content and for attributes in double or single quotes.
std::string escapeHtml(std::string_view text);
/// One row per measure, one column per method.
std::string methodTable(const ReportScene& scene);
/// One row per scene and method with the few numbers that matter most.
std::string summaryTable(const Report& report);
/// What stands for a number that is not there.
inline constexpr const char* kDash = "–";
/// With so many decimals; a dash for what was not measured.
std::string formatFixed(double value, int decimals);
/// Three significant digits or so, as milliseconds and nanoseconds want it.
std::string formatDuration(double value);
/// Median and 95th percentile.
std::string timingCell(const Statistics& ms);
/// 1234567.4 as "1,234,567".
std::string formatCount(double value);
/// 0.1234 as "12.3 %"; a dash for what does not apply.
std::string formatShare(double value, int decimals = 1);

}  // namespace tessera
