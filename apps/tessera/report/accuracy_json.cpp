#include <charconv>
#include <cmath>
#include <optional>

#include "apps/tessera/report/accuracy_report.hpp"
#include "apps/tessera/report/report_json.hpp"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

/// Numbers as numbers, all else as text.
Json settingJson(const std::string& value) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(number)) return value;
  if (number == std::floor(number) && std::abs(number) < 1e15) return static_cast<std::int64_t>(number);
  return number;
}

Json configJson(const Settings& config) {
  Json json = Json::object();
  for (const auto& [knob, value] : config) json[knob] = settingJson(value);
  return json;
}

Json pointJson(const AccuracyPoint& point) {
  return {{"scene", point.scene},
          {"name", point.name},
          {"config", configJson(point.config)},
          {"ms", number(point.ms.median)},
          {"ms_low", number(point.ms.low)},
          {"ms_high", number(point.ms.high)},
          {"samples", number(point.samples)},
          {"texels", number(point.texels)},
          {"bytes", number(point.bytes)},
          {"dssim", number(point.dssim.median)},
          {"dssim_low", number(point.dssim.low)},
          {"dssim_high", number(point.dssim.high)},
          {"psnr_db", number(point.psnrDb)},
          {"flip", number(point.flip)},
          {"runs", point.runs},
          {"pareto", point.pareto},
          {"distinguishable", point.distinguishable}};
}

Json knobJson(const AccuracyKnob& knob, std::size_t firstPoint) {
  Json curves = Json::array();
  for (const AccuracyCurve& curve : knob.curves) {
    Json points = Json::array();
    for (const std::size_t point : curve.points) points.push_back(firstPoint + point);
    Json values = Json::array();
    for (const std::string& value : curve.values) values.push_back(settingJson(value));
    curves.push_back({{"with", curve.with},
                      {"values", std::move(values)},
                      {"points", std::move(points)},
                      {"standard", settingJson(curve.standard)}});
  }
  return {
      {"name", knob.name}, {"label", knob.label}, {"sentence", knob.sentence}, {"curves", std::move(curves)}};
}

/// A value as an error shows it: short.
std::string shown(const Json& value) {
  constexpr std::size_t kLongest = 40;
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  return text;
}

/// A point of a file that may hold anything.
class PointReader {
 public:
  PointReader(const Json& json, std::string where) : json_(json), where_(std::move(where)) {}

  Result<AccuracyPoint> read() {
    AccuracyPoint point;
    if (!json_.is_object()) return fail("{}: {} is not an object", where_, shown(json_));
    text("scene", point.scene);
    config(point.config);
    point.ms = spread("ms");
    point.dssim = spread("dssim");
    // What a machine without the counters, or a perfect picture, leaves null.
    point.samples = amount("samples", 0.0);
    point.texels = amount("texels", 0.0);
    point.bytes = amount("bytes", 0.0);
    point.psnrDb = amount("psnr_db", kNotMeasured);
    point.flip = amount("flip", kNotMeasured);
    flag("pareto", point.pareto);
    flag("distinguishable", point.distinguishable, false);
    if (json_.contains("name")) text("name", point.name);
    if (json_.contains("runs")) point.runs = static_cast<int>(std::min(needed("runs"), 1e6));
    if (error_) return tl::unexpected(*error_);
    return point;
  }

 private:
  void refuse(const std::string& member, const char* what) {
    if (error_) return;
    error_ = json_.contains(member)
                 ? Error{fmt::format("{}.{}: {} is not {}", where_, member, shown(json_[member]), what)}
                 : Error{fmt::format("{}.{} is missing", where_, member)};
  }
  void text(const char* member, std::string& value) {
    if (json_.contains(member) && json_[member].is_string())
      value = json_[member].get<std::string>();
    else
      refuse(member, "a text");
  }
  void flag(const char* member, bool& value, bool required = true) {
    if (json_.contains(member) && json_[member].is_boolean())
      value = json_[member].get<bool>();
    else if (required || json_.contains(member))
      refuse(member, "true or false");
  }
  double needed(const char* member) {
    if (json_.contains(member) && json_[member].is_number()) {
      const double value = json_[member].get<double>();
      if (std::isfinite(value) && value >= 0.0) return value;
    }
    refuse(member, "a number that is not negative");
    return 0.0;
  }
  double amount(const char* member, double absent) {
    if (!json_.contains(member) || json_[member].is_null()) return absent;
    return needed(member);
  }
  Spread spread(const std::string& member) {
    Spread spread = exactly(needed(member.c_str()));
    if (json_.contains(member + "_low")) spread.low = needed((member + "_low").c_str());
    if (json_.contains(member + "_high")) spread.high = needed((member + "_high").c_str());
    if (spread.low > spread.median) refuse(member + "_low", "at most the median");
    if (spread.high < spread.median) refuse(member + "_high", "at least the median");
    return spread;
  }
  void config(Settings& config) {
    if (!json_.contains("config") || !json_["config"].is_object()) return refuse("config", "an object");
    for (const auto& [knob, value] : json_["config"].items()) {
      if (value.is_string())
        config.emplace_back(knob, value.get<std::string>());
      else if (value.is_number_integer())
        config.emplace_back(knob, value.dump());
      else if (value.is_number() && std::isfinite(value.get<double>()))
        config.emplace_back(knob, fmt::format("{}", value.get<double>()));
      else if (!error_)
        error_ = Error{fmt::format("{}.config.{}: {} is not a number or a text", where_, knob, shown(value))};
    }
  }

  const Json& json_;
  std::string where_;
  std::optional<Error> error_;
};

/// Parsing nests no deeper than this: a file of brackets alone would exhaust the stack.
constexpr int kDeepest = 16;

}  // namespace

std::string toJson(const AccuracyReport& report) {
  Json points = Json::array();
  Json scenes = Json::array();
  for (const AccuracyScene& scene : report.scenes) {
    const std::size_t first = points.size();
    for (const AccuracyPoint& point : scene.points) points.push_back(pointJson(point));
    Json knobs = Json::array();
    for (const AccuracyKnob& knob : scene.knobs) knobs.push_back(knobJson(knob, first));
    scenes.push_back({{"scene", scene.file},
                      {"note", scene.note},
                      {"triangles", scene.triangles},
                      {"size", {scene.width, scene.height}},
                      {"frames", scene.frames},
                      {"supersampling", scene.supersampling},
                      {"skipped", scene.skipped},
                      {"knobs", std::move(knobs)}});
  }
  const Json root = {{"schema", 1},
                     {"context", contextJson(report.context)},
                     {"settings", report.settings},
                     {"scenes", std::move(scenes)},
                     {"points", std::move(points)}};
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<std::vector<AccuracyPoint>> parseAccuracy(std::string_view text, const std::string& name) {
  bool tooDeep = false;
  const auto watch = [&](int depth, Json::parse_event_t, Json&) {
    tooDeep = tooDeep || depth > kDeepest;
    return !tooDeep;
  };
  const Json root = Json::parse(text, watch, false);
  if (tooDeep) return fail("{}: nested deeper than {} levels", name, kDeepest);
  if (root.is_discarded()) return fail("{}: not JSON", name);
  if (!root.is_object()) return fail("{}: {} is not an object", name, shown(root));
  if (root.contains("schema") && root["schema"] != 1)
    return fail("{}: schema: {} is not 1, the one that is known", name, shown(root["schema"]));
  if (!root.contains("points")) return fail("{}: points is missing", name);
  const Json& points = root["points"];
  if (!points.is_array()) return fail("{}: points: {} is not an array", name, shown(points));
  if (points.empty()) return fail("{}: points: [] has no configuration", name);
  std::vector<AccuracyPoint> read;
  for (std::size_t i = 0; i < points.size(); ++i) {
    auto point = PointReader(points[i], fmt::format("{}: points[{}]", name, i)).read();
    if (!point) return tl::unexpected(point.error());
    read.push_back(std::move(*point));
  }
  return read;
}

}  // namespace tessera
