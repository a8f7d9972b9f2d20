// What `tessera compare --methods` names: ways to draw a frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "apps/tessera/compare/pvs.hpp"
#include "apps/tessera/options.hpp"
#include "apps/tessera/report/report.hpp"

namespace tessera::app {

enum class Kind : std::uint8_t {
  Forward,
  ForwardPrepass,
  ForwardLanczos,  // a quarter of the pixels, upsampled
  ForwardStereo,   // an eye after the other: what the stereo methods are compared with
  WarpStereo,      // the left eye drawn forward, the right one warped from it
  Rect,
  RectDeferred,
  RectStereo  // shaded once from between the eyes, displayed twice
};

struct Method {
  std::string name;
  Kind kind = Kind::Forward;
  AtlasChoice atlas;                      // of methods that use one
  SpatialReuse spatial;                   // none but of methods that use an atlas
  std::optional<Pvs> pvs = std::nullopt;  // its visible set is a moving camera's
  double equalSamples = kNotMeasured;     // where its bias was set for it: samples against rect's
  [[nodiscard]] bool usesAtlas() const {
    return kind == Kind::Rect || kind == Kind::RectDeferred || kind == Kind::RectStereo;
  }
  /// Whether it fills an atlas for one view.
  [[nodiscard]] bool usesAtlasOnce() const { return usesAtlas() && !isStereo(); }
  [[nodiscard]] bool isStereo() const {
    return kind == Kind::ForwardStereo || kind == Kind::WarpStereo || kind == Kind::RectStereo;
  }
  /// Whether its pictures are what others are compared with.
  [[nodiscard]] bool isReference() const { return kind == Kind::Forward || kind == Kind::ForwardStereo; }
};

/// The name of the method that such a method is compared with.
inline const char* referenceOf(const Method& method) {
  return method.isStereo() ? "forward-stereo" : "forward";
}

/// The method's name with another setting behind those that it has.
std::string withSetting(const std::string& name, const std::string& setting);

/// "rect-stereo:mpix=16+bias=off" as a method: settings after a colon, joined by +, for those that use an
/// atlas. `atlas` and `spatial` are what holds where the text says nothing. Fails with the method and the
/// setting that it does not know, or whose value is out of range.
///   mpix=N      an atlas of N * 2^20 texels, 0.0625 to 128
///   bias=N      constant level bias, -8 to 16
///   bias=off    no constant bias, and none by memory pressure
///   floor=N     lowest bias that room to spare may lead to, -4 to 0
///   slanted=N   longest edge to height from which tess oversamples a triangle, 1 to 1e6
///   gather=WAY  how the tessellation gatherer spawns its samples, see gatherNames()
///   decode=plain, decode=exact   of Ls, see TessDecode
///   texbias=N   added to the mip level of textures where texels are shaded, -2 to 1
///   foveate     fewer texels where the eye resolves less
///   lens        drawn through the lens
Result<Method> parseMethod(const std::string& text, const AtlasChoice& atlas, const SpatialReuse& spatial);

}  // namespace tessera::app
