// What makes a self-contained page of the embedded templates, styles and scripts.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// The template `page`, one of the files under page/, with each {{name}} replaced: {{chart}} by the chart
/// library, {{x.css}} and {{x.js}} by the file of that name, {{x.html}} by that template filled in, and the
/// others by `values`, which must have them: of head.html `title` and `context`, of foot.html `data`.
std::string fillPage(std::string_view page,
                     const std::map<std::string, std::string_view, std::less<>>& values);
/// JSON for the inside of a script element.
std::string scriptData(const nlohmann::ordered_json& json);
/// The bytes of a PNG, a JPEG or an MP4 as an address that an image or video element takes; null for none.
nlohmann::ordered_json dataUri(std::span<const std::uint8_t> bytes);
/// Items of a description list.
std::string contextList(const ReportContext& context);

}  // namespace tessera
