#include "apps/tessera/accuracy/knobs.hpp"

#include <algorithm>
#include <bit>
#include <charconv>

#include <fmt/ranges.h>

namespace tessera::app {

namespace {

using Apply = std::function<Result<void>(Configuration&, std::string_view)>;

Result<double> numberIn(std::string_view value, double least, double most) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || !(number >= least && number <= most))
    return fail("'{}' is not a number from {} to {}", value, least, most);
  return number;
}

Apply number(double AtlasChoice::*field, double least, double most) {
  return [=](Configuration& configuration, std::string_view value) -> Result<void> {
    auto parsed = numberIn(value, least, most);
    if (!parsed) return tl::unexpected(parsed.error());
    configuration.method.atlas.*field = *parsed;
    return {};
  };
}

/// A power of two.
Result<int> sizeIn(std::string_view value, int least, int most) {
  int size = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), size);
  if (error != std::errc() || end != value.data() + value.size() || size < least || size > most ||
      !std::has_single_bit(static_cast<unsigned>(size)))
    return fail("'{}' is not a power of two from {} to {}", value, least, most);
  return size;
}

Apply size(int AtlasChoice::*field, int least, int most) {
  return [=](Configuration& configuration, std::string_view value) -> Result<void> {
    auto parsed = sizeIn(value, least, most);
    if (!parsed) return tl::unexpected(parsed.error());
    configuration.method.atlas.*field = *parsed;
    return {};
  };
}

Result<std::size_t> indexIn(const std::vector<std::string>& names, std::string_view value) {
  const auto found = std::find(names.begin(), names.end(), value);
  if (found == names.end()) return fail("'{}' is not one of {}", value, fmt::join(names, ", "));
  return static_cast<std::size_t>(found - names.begin());
}

Apply oneOf(std::vector<std::string> names, std::function<void(Configuration&, std::size_t index)> set) {
  return [names = std::move(names), set = std::move(set)](Configuration& configuration,
                                                          std::string_view value) -> Result<void> {
    auto index = indexIn(names, value);
    if (!index) return tl::unexpected(index.error());
    set(configuration, *index);
    return {};
  };
}

Settings with(const char* method) { return {{"method", method}}; }

bool usesAtlas(const Configuration& c) { return c.method.usesAtlas(); }
bool usesRect(const Configuration& c) { return c.isSampledBy(Sampling::Rect); }
bool takesLs(const Configuration& c) {
  return c.isSampledBy(Sampling::Tess) || c.isSampledBy(Sampling::LPack);
}

std::vector<Knob> makeKnobs() {
  const std::vector<std::string> methods = {"forward", "forward-prepass", "forward-lanczos", "rect",
                                            "tess",    "lpack",           "oversample",      "texel"};
  std::vector<Knob> all;
  const auto add = [&](Knob knob) { all.push_back(std::move(knob)); };
  add({.name = "method",
       .label = "Method",
       .sentence =
           "How frames are drawn: forward shades what the screen shows (lanczos: a quarter of its pixels, "
           "then "
           "enlarged), the others fill an atlas by rectangles of patches, by the samples of the tessellator, "
           "or by the tiles that pixels touch.",
       .values = methods,
       .quickValues = methods,
       .standard = "rect",
       .curves = {{}},
       .heeded = [](const Configuration&) { return true; },
       .apply = [methods](Configuration& c, std::string_view value) -> Result<void> {
         if (auto known = indexIn(methods, value); !known) return tl::unexpected(known.error());
         auto method = parseMethod(std::string(value), {}, {});
         if (!method) return tl::unexpected(method.error());
         c.method = std::move(*method);
         return {};
       }});
  add({.name = "bias",
       .label = "Constant bias",
       .sentence = "Taken off log2 of every texel's place: 2^-bias texels a pixel, so 1 halves them, and -2 "
                   "shades four times as many.",
       .values = {"-3", "-2", "-1", "-0.5", "0", "0.5", "1", "2", "3"},
       .quickValues = {"-2", "-1", "0", "1", "2"},
       .standard = "0",
       .curves = {with("rect"), with("texel"), with("tess"), with("lpack"), with("oversample")},
       .quickCurves = 3,
       .heeded = usesAtlas,
       .apply = number(&AtlasChoice::bias, -8.0, 16.0)});
  add({.name = "mpix",
       .label = "Atlas size, 2^20 texels",
       .sentence = "A small atlas makes its own bias: what does not fit is shaded with fewer texels.",
       .values = {"0.125", "0.25", "0.5", "1", "2", "8", "16"},
       .quickValues = {"0.125", "0.5", "8"},
       .standard = "8",
       .curves = {with("rect"), with("texel"), with("tess")},
       .heeded = usesAtlas,
       .apply = number(&AtlasChoice::megapixels, 0.0625, 128.0)});
  add({.name = "floor",
       .label = "Bias floor",
       .sentence = "How far the bias may sink where the atlas has room to spare: texels are used because "
                   "they are there.",
       .values = {"-3", "-2", "-1", "0"},
       .standard = "0",
       .curves = {withKnob(with("rect"), "mpix", "0.5"), withKnob(with("texel"), "mpix", "0.5")},
       .heeded = usesAtlas,
       .apply = number(&AtlasChoice::biasFloor, -4.0, 0.0)});
  add({.name = "texbias",
       .label = "Texture bias",
       .sentence = "Mip levels added where texels are shaded: below 0 is sharper, and costs fetches that "
                   "miss the cache.",
       .values = {"-1.5", "-1", "-0.5", "0", "0.5", "1"},
       .quickValues = {"-1", "-0.5", "0", "1"},
       .standard = "-0.5",
       .curves = {with("rect"), withKnob(with("rect"), "bias", "-2"), with("texel"), with("tess")},
       .heeded = usesAtlas,
       .apply = number(&AtlasChoice::textureBias, -2.0, 1.0)});
  add({.name = "shadow-size",
       .label = "Shadow map, texels a side",
       .sentence = "The resolution of every shadow map: redrawn only where lights or casters move.",
       .values = {"256", "512", "1024", "2048", "4096"},
       .quickValues = {"256", "1024", "4096"},
       .standard = "1024",
       .curves = {with("rect"), with("forward")},
       .heeded = [](const Configuration&) { return true; },
       .apply = [](Configuration& c, std::string_view value) -> Result<void> {
         auto parsed = sizeIn(value, 64, 8192);
         if (!parsed) return tl::unexpected(parsed.error());
         c.shadowSize = *parsed;
         return {};
       }});
  add({.name = "display",
       .label = "Display",
       .sentence =
           "Geometry draws the triangles again; deferred reads the ids that the visible set was found with.",
       .values = {"geometry", "deferred"},
       .quickValues = {"geometry", "deferred"},
       .standard = "geometry",
       .curves = {with("rect"), with("tess"), with("texel")},
       .heeded = usesAtlas,
       .apply = oneOf({"geometry", "deferred"}, [](Configuration& c, std::size_t i) {
         c.method.kind = i == 0 ? Kind::Rect : Kind::RectDeferred;
       })});
  add({.name = "shadow-filter",
       .label = "Shadow filter",
       .sentence =
           "linear blends the four nearest texels of the shadow map; nearest takes one, and shows its "
           "edges; wide blends nine such blends, and its edges are soft.",
       .values = {"nearest", "linear", "wide"},
       .quickValues = {"nearest", "wide", "linear"},
       .standard = "linear",
       .curves = {with("rect"), with("forward")},
       .heeded = [](const Configuration&) { return true; },
       .apply = oneOf({"nearest", "linear", "wide"}, [](Configuration& c, std::size_t i) {
         c.shadowFilter = static_cast<ShadowFilter>(i);
       })});
  add({.name = "format",
       .label = "Atlas format",
       .sentence =
           "srgb8 holds display-encoded bytes; the others hold linear light: 10 bits, small floats, and half "
           "floats in twice the memory.",
       .values = atlasFormatNames(),
       .quickValues = atlasFormatNames(),
       .standard = "srgb8",
       .curves = {with("rect"), with("texel"), with("tess")},
       .heeded = usesAtlas,
       .apply = [](Configuration& c, std::string_view value) -> Result<void> {
         if (auto known = indexIn(atlasFormatNames(), value); !known) return tl::unexpected(known.error());
         c.method.atlas.format = value;
         return {};
       }});
  add({.name = "slanted",
       .label = "Slantedness threshold",
       .sentence = "Triangles whose longest edge is so many times their height or more are oversampled, the "
                   "others get "
                   "Ls.",
       .values = {"1", "1.3", "1.6", "2", "4", "16"},
       .quickValues = {"1.3", "1.6", "4"},
       .standard = "1.6",
       .curves = {with("tess")},
       .heeded = [](const Configuration& c) { return c.isSampledBy(Sampling::Tess); },
       .apply = number(&AtlasChoice::slanted, 1.0, 1e6)});
  add({.name = "decode",
       .label = "Decoding of Ls",
       .sentence =
           "exact keeps straight lines straight; plain, the paper's formula, bends them by up to 0.15 of a "
           "sample's step.",
       .values = {"plain", "exact"},
       .quickValues = {"plain", "exact"},
       .standard = "exact",
       .curves = {with("lpack"), with("tess")},
       .heeded = takesLs,
       .apply = oneOf({"plain", "exact"},
                      [](Configuration& c, std::size_t i) { c.method.atlas.plainDecode = i == 0; })});
  add({.name = "gather",
       .label = "Way to gather",
       .sentence = "What spawns the samples: rasterized rectangles, the tessellator itself, or compute "
                   "groups of so many "
                   "threads.",
       .values = gatherNames(),
       .quickValues = {"raster", "compute-64"},
       .standard = "compute-64",
       .curves = {with("tess")},
       .heeded = [](const Configuration& c) { return c.isTess(); },
       .apply = [](Configuration& c, std::string_view value) -> Result<void> {
         if (auto known = indexIn(gatherNames(), value); !known) return tl::unexpected(known.error());
         c.method.atlas.gather = value;
         return {};
       }});
  add({.name = "hysteresis",
       .label = "Hysteresis, log2",
       .sentence =
           "How far past the border of its level an area must be before a block is replaced; -1: none.",
       .values = {"-1", "0", "0.2", "0.5", "1"},
       .standard = "0.2",
       .curves = {with("rect")},
       .heeded = usesRect,
       .apply = number(&AtlasChoice::hysteresis, -1.0, 2.0)});
  add({.name = "smallest-block",
       .label = "Smallest block, texels a side",
       .sentence = "Blocks below it are rounded up: more texels, better filtered.",
       .values = {"1", "2", "4", "8"},
       .quickValues = {"1", "4"},
       .standard = "1",
       .curves = {with("rect")},
       .heeded = usesRect,
       .apply = size(&AtlasChoice::smallestBlock, 1, 256)});
  add({.name = "largest-block",
       .label = "Largest block, texels a side",
       .sentence = "Nearby patches that would have more are blurred.",
       .values = {"16", "32", "64", "256", "1024"},
       .quickValues = {"32", "1024"},
       .standard = "1024",
       .curves = {with("rect")},
       .heeded = usesRect,
       .apply = size(&AtlasChoice::largestBlock, 2, 1024)});
  add({.name = "largest-aspect",
       .label = "Largest aspect of a block",
       .sentence =
           "Width to height at most: below that of a patch, its blocks shade more than the picture asks for.",
       .values = {"2", "4", "16", "1024"},
       .standard = "1024",
       .curves = {with("rect")},
       .heeded = usesRect,
       .apply = size(&AtlasChoice::largestAspect, 2, 1024)});
  add({.name = "superblock",
       .label = "Superblock, texels a side",
       .sentence =
           "What the atlas is cut from: no block is larger; small ones waste less, and hold fewer widths.",
       .values = {"64", "128", "256", "512"},
       .standard = "256",
       .curves = {withKnob(with("rect"), "mpix", "2")},
       .heeded = usesRect,
       .apply = size(&AtlasChoice::superblock, 32, 1024)});
  add({.name = "strategy",
       .label = "Memory strategy",
       .sentence = "S0 has columns, stacks and resets; S1 no columns, S2 no stacks either, S3 never resets.",
       .values = {"S0", "S1", "S2", "S3"},
       .standard = "S0",
       .curves = {withKnob(with("rect"), "mpix", "0.5")},
       .heeded = usesRect,
       .apply = [](Configuration& c, std::string_view value) -> Result<void> {
         if (auto known = indexIn({"S0", "S1", "S2", "S3"}, value); !known)
           return tl::unexpected(known.error());
         c.method.atlas.strategy = value;
         return {};
       }});
  add({.name = "split-edges",
       .label = "Split edges, of the scene's diagonal",
       .sentence = "Longer edges are split at load: smaller patches follow the picture more closely, and are "
                   "more. 0: "
                   "never.",
       .values = {"0", "0.0104", "0.0417", "0.2"},
       .standard = "0.0417",
       .curves = {with("rect")},
       .heeded = usesAtlas,
       .apply = number(&AtlasChoice::splitEdges, 0.0, 1.0)});
  add({.name = "patches",
       .label = "Patches",
       .sentence =
           "What shares a block: up to three triangles that lie nearly in a plane, or each triangle alone.",
       .values = {"paired", "alone"},
       .quickValues = {"paired", "alone"},
       .standard = "paired",
       .curves = {with("rect"), with("texel")},
       .heeded =
           [](const Configuration& c) {
             return c.isSampledBy(Sampling::Rect) || c.isSampledBy(Sampling::Texel);
           },
       .apply = oneOf({"paired", "alone"},
                      [](Configuration& c, std::size_t i) { c.method.atlas.pairs = i == 0; })});
  const auto form = [&](const char* name, const char* label, const char* sentence, const char* stable,
                        const char* other, bool NumericForms::*field, std::vector<Settings> curves,
                        auto heeded) {
    add({.name = name,
         .label = label,
         .sentence = sentence,
         .values = {other, stable},
         .quickValues = {other, stable},
         .standard = stable,
         .curves = std::move(curves),
         .heeded = heeded,
         .apply =
             oneOf({stable, other}, [field](Configuration& c, std::size_t i) { c.forms.*field = i == 0; })});
  };
  const auto always = [](const Configuration&) { return true; };
  const auto measures = [](const Configuration& c) { return c.isSampledBy(Sampling::Rect) || c.isTess(); };
  const auto isTess = [](const Configuration& c) { return c.isTess(); };
  form("angles", "Angles of edges",
       "cross: atan2 of the cross and the dot product, all digits at any angle; acos, as printed, loses "
       "those below 3.5e-4 rad.",
       "cross", "acos", &NumericForms::anglesByCross, {with("rect"), with("tess")}, measures);
  form("areas", "Areas of triangles",
       "kahan orders the edges, so that needles keep their digits; heron, as printed, cancels.", "kahan",
       "heron", &NumericForms::areasByKahan, {with("rect"), with("tess")}, measures);
  form(
      "samples", "Where triangles are sampled",
      "perspective: evenly in the picture; surface: evenly on the triangle, so that its near end is blurred.",
      "perspective", "surface", &NumericForms::perspectiveSamples, {with("tess")}, isTess);
  form("positions", "What positions are relative to",
       "camera: a place near the eye, moved in double precision; world: the scene's origin, which costs the "
       "digits of its distance.",
       "camera", "world", &NumericForms::cameraRelative, {with("rect"), with("forward")}, always);
  form("depth", "Depth buffer",
       "reversed: 32-bit floats, 0 at infinity; forward24: 24 bits, 1 there, which far surfaces share.",
       "reversed", "forward24", &NumericForms::reversedDepth, {with("rect"), with("forward")}, always);
  return all;
}

const Knob* knobNamed(std::string_view name) {
  const auto found =
      std::find_if(knobs().begin(), knobs().end(), [&](const Knob& knob) { return knob.name == name; });
  return found == knobs().end() ? nullptr : &*found;
}

}  // namespace

const std::vector<Knob>& knobs() {
  static const std::vector<Knob> all = makeKnobs();
  return all;
}

std::string settingOf(const Settings& settings, std::string_view knob, std::string_view otherwise) {
  for (const auto& [name, value] : settings)
    if (name == knob) return value;
  return std::string(otherwise);
}

Settings withKnob(Settings settings, const std::string& knob, const std::string& value) {
  for (auto& [name, old] : settings)
    if (name == knob) {
      old = value;
      return settings;
    }
  settings.emplace_back(knob, value);
  return settings;
}

Result<Configuration> configurationOf(const Settings& settings) {
  for (auto it = settings.begin(); it != settings.end(); ++it) {
    if (knobNamed(it->first) == nullptr) {
      std::vector<std::string> names;
      for (const Knob& knob : knobs()) names.push_back(knob.name);
      return fail("{}: not one of the knobs {}", it->first, fmt::join(names, ", "));
    }
    if (std::any_of(settings.begin(), it, [&](const auto& before) { return before.first == it->first; }))
      return fail("{}: set twice", it->first);
  }
  Configuration configuration;
  for (const Knob& knob : knobs()) {
    const auto set =
        std::find_if(settings.begin(), settings.end(), [&](const auto& s) { return s.first == knob.name; });
    if (!knob.heeded(configuration)) {
      if (set == settings.end()) continue;
      return fail("{}: method {} does not heed it", knob.name, configuration.method.name);
    }
    const std::string& value = set == settings.end() ? knob.standard : set->second;
    if (auto applied = knob.apply(configuration, value); !applied)
      return fail("{}: {}", knob.name, applied.error().message);
  }
  return configuration;
}

Result<Settings> completed(const Settings& settings) {
  auto configuration = configurationOf(settings);
  if (!configuration) return tl::unexpected(configuration.error());
  Settings all;
  for (const Knob& knob : knobs())
    if (knob.heeded(*configuration))
      all.emplace_back(knob.name, settingOf(settings, knob.name, knob.standard));
  return all;
}

std::string nameOf(const Settings& settings) {
  std::string name = settingOf(settings, "method", knobs().front().standard);
  for (const Knob& knob : knobs()) {
    if (knob.name == "method") continue;
    const std::string value = settingOf(settings, knob.name, knob.standard);
    if (value != knob.standard) name += fmt::format(", {} {}", knob.name, value);
  }
  return name;
}

}  // namespace tessera::app
