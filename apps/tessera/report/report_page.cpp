#include "apps/tessera/report/report_page.hpp"

#include <algorithm>
#include <span>

#include <fmt/format.h>

#include "apps/tessera/report/report_table.hpp"
#include "engine/core/embedded.hpp"

namespace tessera {

std::span<const EmbeddedText> embeddedReportPage();
std::span<const EmbeddedText> embeddedChart();

namespace {

const EmbeddedText* find(std::span<const EmbeddedText> files, std::string_view path) {
  for (const EmbeddedText& file : files)
    if (file.path == path) return &file;
  return nullptr;
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8U | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out += k <= count ? kDigits[group >> (18U - 6U * static_cast<std::uint32_t>(k)) & 63U] : '=';
  }
  return out;
}

}  // namespace

std::string fillPage(std::string_view page,
                     const std::map<std::string, std::string_view, std::less<>>& values) {
  std::string_view rest = find(embeddedReportPage(), page)->text;
  std::string out;
  // Left to right, each once: text that is put in is never searched.
  while (!rest.empty()) {
    const std::size_t open = rest.find("{{");
    out += rest.substr(0, open);
    if (open == std::string_view::npos) break;
    const std::size_t close = rest.find("}}", open);
    const std::string name(rest.substr(open + 2, close - open - 2));
    if (name == "chart")
      out += find(embeddedChart(), "chart.min.js")->text;
    else if (name.ends_with(".html"))
      out += fillPage(name, values);
    else if (const EmbeddedText* file = find(embeddedReportPage(), name); file != nullptr)
      out += file->text;
    else
      out += values.at(name);
    rest.remove_prefix(close + 2);
  }
  return out;
}

std::string scriptData(const nlohmann::ordered_json& root) {
  const std::string json = root.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string out;
  out.reserve(json.size());
  // Only "<" could end a script element early.
  for (const char c : json) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

nlohmann::ordered_json dataUri(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return nullptr;
  constexpr std::uint8_t kPngStart = 0x89;
  constexpr std::string_view kMp4Start = "ftyp";  // behind the length of the first box
  const char* type = bytes[0] == kPngStart ? "image/png" : "image/jpeg";
  if (bytes.size() > 8 && std::equal(kMp4Start.begin(), kMp4Start.end(), bytes.begin() + 4))
    type = "video/mp4";
  return fmt::format("data:{};base64,{}", type, base64(bytes));
}

std::string contextList(const ReportContext& context) {
  std::string out;
  const auto add = [&out](std::string_view name, const std::string& value) {
    if (!value.empty()) out += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", name, escapeHtml(value));
  };
  add("Renderer", context.renderer);
  add("Context", context.backend);
  add("GL", context.gl);
  add("GLSL", context.glsl);
  add("Timer", context.timer);
  add("Commit", context.commit);
  add("Command", context.command);
  return out;
}

}  // namespace tessera
