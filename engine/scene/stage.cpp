// Stage and camera-path files, read strictly, and what they give at one time.
#include "engine/scene/stage.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <initializer_list>
#include <set>
#include <string_view>

#include <nlohmann/json.hpp>

#include "engine/core/file.hpp"
#include "engine/measure/acuity.hpp"

namespace tessera {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{16} << 20;
constexpr std::size_t kMaxKeys = 100'000;
constexpr std::size_t kMaxLights = 256;
constexpr std::size_t kMaxPaths = 1'000;
constexpr int kMaxDepth = 32;  // lists within lists; a stage has 6, and printing a value recurses

struct Range {
  double min;
  double max;
};
constexpr Range kCoordinate{-1e7, 1e7};  // metres
constexpr Range kTime{0.0, 1e6};         // seconds
constexpr Range kFovY{1.0, 170.0};       // degrees
constexpr Range kUnit{0.0, 1.0};         // light colour
constexpr Range kRadiance{0.0, 1e6};     // ambient
constexpr Range kIntensity{0.0, 1e9};    // lux or candela
constexpr Range kGaze{-kGazeFarthest, kGazeFarthest};
constexpr Range kExposure{1e-6, 1e6};
constexpr Range kLightRange{1e-3, 1e7};  // metres
constexpr Range kConeDegrees{0.0, 90.0};

/// The value as it stands in the file, short enough for one line.
std::string shown(const Json& value) {
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > 40) text = text.substr(0, 37) + "...";
  return text;
}

/// A value of the file and its place ("lights[2].keyframes[0].t"). Reading goes on with defaults after an
/// error; only the first error is kept, so that parsing code needs no branch at every field.
class Element {
 public:
  Element(const Json& value, std::string path, std::optional<Error>& error, const std::string& file)
      : value_(&value), path_(std::move(path)), error_(&error), file_(&file) {}

  template <class... Args>
  void complain(fmt::format_string<Args...> format, Args&&... args) const {
    if (*error_) return;
    const std::string what = fmt::format(format, std::forward<Args>(args)...);
    *error_ = Error{oneLine(fmt::format("{}: {}: {}", *file_, path_.empty() ? "top level" : path_, what))};
  }

  [[nodiscard]] const Json& value() const { return *value_; }
  [[nodiscard]] bool has(const char* key) const { return value_->is_object() && value_->contains(key); }

  /// The value of a key; a complaint and null where it is missing.
  [[nodiscard]] Element at(const char* key) const {
    static const Json null;
    const std::string path = path_.empty() ? key : path_ + "." + key;
    if (has(key)) return {(*value_)[key], path, *error_, *file_};
    complain("key \"{}\" is missing", key);
    return {null, path, *error_, *file_};
  }

  void onlyKeys(std::initializer_list<std::string_view> allowed) const {
    if (!value_->is_object()) return complain("{} is not an object", shown(*value_));
    for (const auto& item : value_->items()) {
      if (std::ranges::find(allowed, item.key()) == allowed.end()) {
        complain("unknown key {}", shown(Json(item.key())));
      }
    }
  }

  /// The entries of a list with 1 to `max` of them.
  [[nodiscard]] std::vector<Element> list(std::size_t max) const {
    std::vector<Element> entries;
    if (!value_->is_array()) {
      complain("{} is not a list", shown(*value_));
    } else if (value_->empty()) {
      complain("the list is empty");
    } else if (value_->size() > max) {
      complain("{} entries are past the limit of {}", value_->size(), max);
    } else {
      entries.reserve(value_->size());
      for (std::size_t i = 0; i < value_->size(); ++i) {
        entries.emplace_back((*value_)[i], fmt::format("{}[{}]", path_, i), *error_, *file_);
      }
    }
    return entries;
  }

  [[nodiscard]] double number(Range range) const {
    if (!value_->is_number()) {
      complain("{} is not a number", shown(*value_));
      return range.min;
    }
    const auto number = value_->get<double>();
    if (!(number >= range.min && number <= range.max)) {
      complain("{} is not within {} and {}", shown(*value_), range.min, range.max);
      return range.min;
    }
    return number;
  }

  [[nodiscard]] glm::dvec3 vector(Range range) const {
    if (!value_->is_array() || value_->size() != 3) {
      complain("{} is not a list of 3 numbers", shown(*value_));
      return glm::dvec3(0.0);
    }
    glm::dvec3 result(0.0);
    for (int i = 0; i < 3; ++i) {
      const Element entry((*value_)[static_cast<std::size_t>(i)], fmt::format("{}[{}]", path_, i), *error_,
                          *file_);
      result[i] = entry.number(range);
    }
    return result;
  }

  [[nodiscard]] bool flag() const {
    if (!value_->is_boolean()) complain("{} is not true or false", shown(*value_));
    return value_->is_boolean() && value_->get<bool>();
  }

  [[nodiscard]] std::string text() const {
    if (!value_->is_string()) complain("{} is not a string", shown(*value_));
    if (value_->is_string() && value_->get_ref<const std::string&>().empty()) complain("the string is empty");
    return value_->is_string() ? value_->get<std::string>() : std::string();
  }

 private:
  const Json* value_;
  std::string path_;
  std::optional<Error>* error_;
  const std::string* file_;
};

/// Parses a whole file as one JSON value; a key given twice in one object and deep nesting are errors as
/// well.
Result<Json> parseFile(const std::filesystem::path& path) {
  const auto bytes = readFile(path, kMaxFileBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  std::vector<std::set<std::string>> keys;
  std::optional<std::string> repeated;
  bool deep = false;
  const auto watch = [&](int depth, Json::parse_event_t event, Json& parsed) {
    deep = deep || depth > kMaxDepth;
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second &&
        !repeated) {
      repeated = shown(parsed);
    }
    return !deep;
  };
  try {
    Json json = Json::parse(bytes->begin(), bytes->end(), watch);
    if (deep) return fail("{}: more than {} lists or objects within each other", path.string(), kMaxDepth);
    if (repeated) return fail("{}: key {} is given twice in one object", path.string(), oneLine(*repeated));
    return json;
  } catch (const Json::exception& exception) {
    return fail("{}: not valid JSON: {}", path.string(), oneLine(exception.what()));
  }
}

/// Reads a key's time and complains unless it is after the one before.
double nextTime(const Element& time, bool first, double previous) {
  const double t = time.number(kTime);
  if (!first && !(t > previous)) time.complain("{} is not after the {} of the key before", t, previous);
  return t;
}

std::vector<CameraKey> readCameraKeys(const Element& keyframes) {
  std::vector<CameraKey> keys;
  for (const Element& element : keyframes.list(kMaxKeys)) {
    element.onlyKeys({"t", "eye", "target", "fov_y"});
    CameraKey key;
    key.time = nextTime(element.at("t"), keys.empty(), keys.empty() ? 0.0 : keys.back().time);
    key.eye = element.at("eye").vector(kCoordinate);
    key.target = element.at("target").vector(kCoordinate);
    key.fovY = element.at("fov_y").number(kFovY);
    if (key.eye == key.target) {
      element.complain("eye and target are the same point ({}, {}, {})", key.eye.x, key.eye.y, key.eye.z);
    }
    keys.push_back(key);
  }
  return keys;
}

/// Reads what a light or one of its keyframes says into `key`; what it does not say stays as it is.
void readLightState(const Element& element, StageLightKey& key) {
  if (element.has("position")) key.position = element.at("position").vector(kCoordinate);
  if (element.has("target")) key.target = element.at("target").vector(kCoordinate);
  if (element.has("color")) key.color = glm::vec3(element.at("color").vector(kUnit));
  if (element.has("intensity"))
    key.intensity = static_cast<float>(element.at("intensity").number(kIntensity));
}

LightType readLightType(const Element& element) {
  const std::string name = element.text();
  if (name == "directional") return LightType::Directional;
  if (name == "spot") return LightType::Spot;
  if (name != "point") element.complain("{} is not directional, point or spot", shown(element.value()));
  return LightType::Point;
}

void refuse(const Element& element, const char* key, const char* owner) {
  if (element.has(key)) element.at(key).complain("a {} light has none", owner);
}

StageLight readLight(const Element& element) {
  element.onlyKeys({"name", "type", "cast_shadow", "range", "inner_cone", "outer_cone", "loop", "position",
                    "target", "color", "intensity", "keyframes"});
  StageLight result;
  Light& light = result.light;
  if (element.has("name")) light.name = element.at("name").text();
  light.type = readLightType(element.at("type"));
  if (element.has("cast_shadow")) light.castsShadow = element.at("cast_shadow").flag();
  if (element.has("range")) light.range = static_cast<float>(element.at("range").number(kLightRange));
  if (element.has("loop")) result.loop = element.at("loop").flag();
  if (light.type == LightType::Directional) refuse(element, "range", "directional");
  if (light.type != LightType::Spot) {
    refuse(element, "inner_cone", "directional or point");
    refuse(element, "outer_cone", "directional or point");
  } else {
    const double outer = element.has("outer_cone") ? element.at("outer_cone").number(kConeDegrees) : 45.0;
    const double inner = element.has("inner_cone") ? element.at("inner_cone").number(kConeDegrees) : 0.0;
    if (!(inner < outer)) element.complain("inner_cone {} is not below outer_cone {}", inner, outer);
    light.outerCone = static_cast<float>(glm::radians(outer));
    light.innerCone = static_cast<float>(glm::radians(inner));
  }

  StageLightKey base;
  readLightState(element, base);
  const bool aimed = light.type != LightType::Point;
  if (!element.has("keyframes")) {
    result.keys.push_back(base);
  } else {
    for (const Element& entry : element.at("keyframes").list(kMaxKeys)) {
      entry.onlyKeys({"t", "position", "target", "color", "intensity"});
      StageLightKey key = base;
      key.time =
          nextTime(entry.at("t"), result.keys.empty(), result.keys.empty() ? 0.0 : result.keys.back().time);
      readLightState(entry, key);
      result.keys.push_back(key);
    }
  }
  // Each place must come from the light or from every keyframe: a default place would be a guess.
  const auto stated = [&](const char* key) {
    if (element.has(key)) return;
    if (!element.has("keyframes")) return element.complain("key \"{}\" is missing", key);
    for (const Element& entry : element.at("keyframes").list(kMaxKeys)) (void)entry.at(key);
  };
  stated("position");
  if (aimed) stated("target");
  for (std::size_t i = 0; aimed && i < result.keys.size(); ++i) {
    if (result.keys[i].position == result.keys[i].target) {
      element.complain("position and target are the same point at keyframe {}", i);
    }
  }
  return result;
}

Ambient readAmbient(const Element& element) {
  Ambient ambient;
  if (element.value().is_array()) {
    ambient.sky = ambient.ground = glm::vec3(element.vector(kRadiance));
    return ambient;
  }
  element.onlyKeys({"sky", "ground"});
  ambient.sky = glm::vec3(element.at("sky").vector(kRadiance));
  ambient.ground = glm::vec3(element.at("ground").vector(kRadiance));
  return ambient;
}

/// Index of the last key at or before `time`, or nothing before the first.
template <class Keys>
std::optional<std::size_t> keyBefore(const Keys& keys, double time) {
  const auto next = std::ranges::upper_bound(keys, time, {}, &std::ranges::range_value_t<Keys>::time);
  if (next == keys.begin()) return std::nullopt;
  return static_cast<std::size_t>(next - keys.begin()) - 1;
}

/// Derivative at key i: that of the parabola through the key and its neighbours, which is Catmull-Rom for
/// unevenly spaced times. At an end it is the slope of the only segment, so that a path neither backs up nor
/// overshoots there.
template <class Value>
Value tangent(const std::vector<CameraKey>& keys, std::size_t i, Value CameraKey::*field) {
  const auto slope = [&](std::size_t k) {
    return (keys[k + 1].*field - keys[k].*field) / (keys[k + 1].time - keys[k].time);
  };
  if (i == 0) return slope(0);
  if (i + 1 == keys.size()) return slope(i - 1);
  const double before = keys[i].time - keys[i - 1].time;
  const double after = keys[i + 1].time - keys[i].time;
  return (slope(i - 1) * after + slope(i) * before) / (before + after);
}

template <class Value>
Value sampleSpline(const std::vector<CameraKey>& keys, std::size_t i, double s, Value CameraKey::*field) {
  const double interval = keys[i + 1].time - keys[i].time;
  const double s2 = s * s;
  const double s3 = s2 * s;
  return keys[i].*field * (2.0 * s3 - 3.0 * s2 + 1.0) + keys[i + 1].*field * (3.0 * s2 - 2.0 * s3) +
         tangent(keys, i, field) * (interval * (s3 - 2.0 * s2 + s)) +
         tangent(keys, i + 1, field) * (interval * (s3 - s2));
}

StageLightKey sampleLight(const StageLight& light, double time) {
  const std::vector<StageLightKey>& keys = light.keys;
  assert(!keys.empty());
  const double end = keys.back().time;
  if (light.loop && end > 0.0) {
    time = std::fmod(time, end);
    if (time < 0.0) time += end;
  }
  const std::optional<std::size_t> before = keyBefore(keys, time);
  if (!before) return keys.front();
  const StageLightKey& a = keys[*before];
  if (*before + 1 == keys.size()) return a;
  const StageLightKey& b = keys[*before + 1];
  const double s = (time - a.time) / (b.time - a.time);
  const auto f = static_cast<float>(s);
  return {time, glm::mix(a.position, b.position, s), glm::mix(a.target, b.target, s),
          glm::mix(a.color, b.color, f), glm::mix(a.intensity, b.intensity, f)};
}

/// Unit vector along `v`, or `otherwise` where v has no direction (a node scaled to nothing).
glm::dvec3 directionOf(const glm::dvec3& v, const glm::dvec3& otherwise) {
  const double length = glm::length(v);
  return length > 0.0 && std::isfinite(length) ? v / length : otherwise;
}

LightSample sampleOf(const Light& light) {
  LightSample sample;
  sample.type = light.type;
  sample.radiance = light.color * light.intensity;
  sample.range = light.range;
  sample.innerCone = light.innerCone;
  sample.outerCone = light.outerCone;
  sample.castsShadow = light.castsShadow;
  return sample;
}

bool moves(const StageLight& light) {
  const StageLightKey& first = light.keys.front();
  return std::ranges::any_of(light.keys, [&](const StageLightKey& key) {
    return key.position != first.position || key.target != first.target;
  });
}

}  // namespace

Result<Stage> loadStage(const std::filesystem::path& path) {
  const Result<Json> json = parseFile(path);
  if (!json) return tl::unexpected(json.error());
  Stage stage;
  stage.file = path.string();
  std::optional<Error> error;
  const Element root(*json, "", error, stage.file);
  root.onlyKeys({"scene_lights", "scene_lights_cast_shadows", "ambient", "exposure", "lights", "paths"});
  if (root.has("scene_lights")) stage.sceneLights = root.at("scene_lights").flag();
  if (root.has("scene_lights_cast_shadows")) {
    stage.sceneLightsCastShadows = root.at("scene_lights_cast_shadows").flag();
  }
  if (root.has("ambient")) stage.ambient = readAmbient(root.at("ambient"));
  if (root.has("exposure")) stage.exposure = static_cast<float>(root.at("exposure").number(kExposure));
  if (root.has("lights")) {
    for (const Element& element : root.at("lights").list(kMaxLights))
      stage.lights.push_back(readLight(element));
  }
  if (root.has("paths")) {
    for (const Element& element : root.at("paths").list(kMaxPaths)) {
      element.onlyKeys({"name", "keyframes"});
      CameraPath camera{element.at("name").text(), readCameraKeys(element.at("keyframes"))};
      if (std::ranges::any_of(stage.paths,
                              [&](const CameraPath& other) { return other.name == camera.name; })) {
        element.at("name").complain("a path before has the same name \"{}\"", camera.name);
      }
      stage.paths.push_back(std::move(camera));
    }
  }
  if (error) return tl::unexpected(*error);
  return stage;
}

Result<CameraPath> loadCameraPath(const std::filesystem::path& path) {
  const Result<Json> json = parseFile(path);
  if (!json) return tl::unexpected(json.error());
  const std::string file = path.string();
  std::optional<Error> error;
  const Element root(*json, "", error, file);
  root.onlyKeys({"keyframes"});
  CameraPath camera{path.stem().string(), readCameraKeys(root.at("keyframes"))};
  if (error) return tl::unexpected(*error);
  return camera;
}

Result<std::vector<GazeKey>> loadGaze(const std::filesystem::path& path) {
  const Result<Json> json = parseFile(path);
  if (!json) return tl::unexpected(json.error());
  const std::string file = path.string();
  std::optional<Error> error;
  std::vector<GazeKey> keys;
  for (const Element& element : Element(*json, "", error, file).list(kMaxKeys)) {
    element.onlyKeys({"time", "x", "y"});
    GazeKey key;
    key.time = nextTime(element.at("time"), keys.empty(), keys.empty() ? 0.0 : keys.back().time);
    key.place = {element.at("x").number(kGaze), element.at("y").number(kGaze)};
    keys.push_back(key);
  }
  if (error) return tl::unexpected(*error);
  return keys;
}

glm::dvec2 sampleGaze(std::span<const GazeKey> keys, double time) {
  assert(!keys.empty());
  const std::optional<std::size_t> before = keyBefore(keys, time);
  if (!before) return keys.front().place;
  const GazeKey& a = keys[*before];
  if (*before + 1 == keys.size()) return a.place;
  const GazeKey& b = keys[*before + 1];
  return glm::mix(a.place, b.place, (time - a.time) / (b.time - a.time));
}

CameraKey sampleCamera(const CameraPath& path, double time) {
  const std::vector<CameraKey>& keys = path.keys;
  assert(!keys.empty());
  const std::optional<std::size_t> before = keyBefore(keys, time);
  if (!before) return keys.front();
  const std::size_t i = *before;
  if (i + 1 == keys.size()) return keys.back();
  const double s = (time - keys[i].time) / (keys[i + 1].time - keys[i].time);
  // The spline may swing past its keys; an angle is held between the two that bound it, so it stays a valid
  // one.
  const auto [narrow, wide] = std::minmax(keys[i].fovY, keys[i + 1].fovY);
  return {time, sampleSpline(keys, i, s, &CameraKey::eye), sampleSpline(keys, i, s, &CameraKey::target),
          std::clamp(sampleSpline(keys, i, s, &CameraKey::fovY), narrow, wide)};
}

std::vector<LightSample> evaluateLights(const Scene& scene, const SceneState& state, const Stage* stage,
                                        double time) {
  assert(state.world.size() == scene.nodes.size());
  std::vector<LightSample> samples;
  if (!scene.lights.empty() && (stage == nullptr || stage->sceneLights)) {
    const std::vector<bool> moving = movingNodes(scene);
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
      if (scene.nodes[i].light == kNone) continue;
      const glm::dmat4& world = state.world[i];
      LightSample sample = sampleOf(scene.lights[scene.nodes[i].light]);
      sample.position = glm::dvec3(world[3]);
      sample.direction = directionOf(-glm::dvec3(world[2]), glm::dvec3(0.0, 0.0, -1.0));
      sample.castsShadow = sample.castsShadow || (stage != nullptr && stage->sceneLightsCastShadows);
      sample.moves = moving[i];
      samples.push_back(sample);
    }
  }
  if (stage == nullptr) return samples;
  for (const StageLight& light : stage->lights) {
    const StageLightKey key = sampleLight(light, time);
    LightSample sample = sampleOf(light.light);
    sample.radiance = key.color * key.intensity;
    sample.position = key.position;
    sample.direction = directionOf(key.target - key.position, glm::dvec3(0.0, -1.0, 0.0));
    sample.moves = moves(light);
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace tessera
