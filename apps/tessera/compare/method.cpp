#include "apps/tessera/compare/method.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include <fmt/ranges.h>

namespace tessera::app {

namespace {

struct KindName {
  std::string_view name;
  Kind kind;
  Sampling sampling = Sampling::Rect;
};
constexpr std::array<KindName, 20> kKinds = {
    {{"forward", Kind::Forward},
     {"forward-prepass", Kind::ForwardPrepass},
     {"forward-lanczos", Kind::ForwardLanczos},
     {"forward-stereo", Kind::ForwardStereo},
     {"warp-stereo", Kind::WarpStereo},
     {"rect", Kind::Rect},
     {"rect-deferred", Kind::RectDeferred},
     {"rect-stereo", Kind::RectStereo},
     {"tess", Kind::Rect, Sampling::Tess},
     {"tess-deferred", Kind::RectDeferred, Sampling::Tess},
     {"tess-stereo", Kind::RectStereo, Sampling::Tess},
     {"lpack", Kind::Rect, Sampling::LPack},
     {"lpack-deferred", Kind::RectDeferred, Sampling::LPack},
     {"lpack-stereo", Kind::RectStereo, Sampling::LPack},
     {"oversample", Kind::Rect, Sampling::Oversample},
     {"oversample-deferred", Kind::RectDeferred, Sampling::Oversample},
     {"oversample-stereo", Kind::RectStereo, Sampling::Oversample},
     {"texel", Kind::Rect, Sampling::Texel},
     {"texel-deferred", Kind::RectDeferred, Sampling::Texel},
     {"texel-stereo", Kind::RectStereo, Sampling::Texel}}};

/// The number after "key=", in [least, most].
Result<double> numberOf(std::string_view value, double least, double most) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || !(number >= least && number <= most))
    return fail("'{}' is not a number from {} to {}", value, least, most);
  return number;
}

Result<void> apply(Method& method, std::string_view setting) {
  const std::size_t equals = setting.find('=');
  const std::string_view key = setting.substr(0, equals);
  const std::string_view value = equals == std::string_view::npos ? "" : setting.substr(equals + 1);
  const auto set = [&](double& number, double least, double most) -> Result<void> {
    auto parsed = numberOf(value, least, most);
    if (!parsed) return tl::unexpected(parsed.error());
    number = *parsed;
    return {};
  };
  if (key == "mpix") return set(method.atlas.megapixels, 0.0625, 128.0);
  if (key == "floor") return set(method.atlas.biasFloor, -4.0, 0.0);
  if (setting == "bias=off") {
    method.atlas.bias = 0.0;
    method.atlas.pressureBias = false;
    return {};
  }
  if (key == "gather") {
    const auto& names = gatherNames();
    if (std::find(names.begin(), names.end(), value) == names.end())
      return fail("'{}' is not one of {}", value, fmt::join(names, ", "));
    method.atlas.gather = value;
    return {};
  }
  if (setting == "decode=plain" || setting == "decode=exact") {
    method.atlas.plainDecode = value == "plain";
    return {};
  }
  if (key == "slanted") return set(method.atlas.slanted, 1.0, 1e6);
  if (key == "bias") return set(method.atlas.bias, -8.0, 16.0);
  if (key == "texbias") return set(method.atlas.textureBias, -2.0, 1.0);
  PlaceOptions& placing = method.spatial.options;
  if (setting == "foveate") {
    if (!placing.foveation) placing.foveation.emplace();
    return {};
  }
  if (setting == "lens") {
    if (!placing.lens) placing.lens.emplace();
    return {};
  }
  return fail(
      "not one of mpix=N, bias=N, bias=off, floor=N, texbias=N, slanted=N, gather=WAY, decode=plain, "
      "decode=exact, foveate, "
      "lens");
}

}  // namespace

std::string withSetting(const std::string& name, const std::string& setting) {
  // The first setting comes after a colon, the others after a plus.
  return name + (name.find(':') == std::string::npos ? ":" : "+") + setting;
}

Result<Method> parseMethod(const std::string& text, const AtlasChoice& atlas, const SpatialReuse& spatial) {
  const std::size_t colon = text.find(':');
  const std::string_view name = std::string_view(text).substr(0, colon);
  Method method;
  method.name = text;
  std::string names;
  bool known = false;
  Sampling sampling = Sampling::Rect;
  for (const KindName& kind : kKinds) {
    names += names.empty() ? "" : ", ";
    names += kind.name;
    if (kind.name != name) continue;
    method.kind = kind.kind;
    sampling = kind.sampling;
    known = true;
  }
  if (!known) return fail("--methods {}: '{}' is not one of {}", text, name, names);
  if (method.usesAtlas()) {
    method.atlas = atlas;
    method.atlas.sampling = sampling;
    method.spatial = spatial;
  }
  if (colon == std::string::npos) return method;
  if (!method.usesAtlas()) return fail("--methods {}: {} takes no settings", text, name);
  std::string_view rest = std::string_view(text).substr(colon + 1);
  while (true) {
    const std::size_t plus = rest.find('+');
    const std::string_view setting = rest.substr(0, plus);
    if (auto applied = apply(method, setting); !applied)
      return fail("--methods {}: setting '{}': {}", text, setting, applied.error().message);
    if (plus == std::string_view::npos) return method;
    rest.remove_prefix(plus + 1);
  }
}

}  // namespace tessera::app
