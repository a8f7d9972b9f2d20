#include "apps/tessera/compare/drawing.hpp"

#include <algorithm>
#include <array>

namespace tessera::app {

namespace {

View quarterOf(View view) {
  view.width /= 2;
  view.height /= 2;
  return view;
}

void addTimes(std::vector<PassTime>& sums, const std::vector<PassTime>& times, bool lens) {
  for (const PassTime& time : times) {
    // A reference is drawn through the lens for others to be compared with, at no cost of its own.
    if (time.name == "distort" && !lens) continue;
    const auto found =
        std::find_if(sums.begin(), sums.end(), [&](const PassTime& sum) { return sum.name == time.name; });
    if (found == sums.end())
      sums.push_back(time);
    else
      found->milliseconds += time.milliseconds;
  }
}

}  // namespace

Result<void> useAtlas(Engine& engine, const Method& method) {
  if (!method.usesAtlas()) return {};
  auto setup = engineOptions(method.atlas);
  if (!setup) return tl::unexpected(setup.error());
  return setup->gatherer == GathererKind::Tess    ? engine.remakeAtlas(setup->tess)
         : setup->gatherer == GathererKind::Texel ? engine.remakeAtlas(setup->texel)
                                                  : engine.remakeAtlas(setup->atlas);
}

std::vector<View> eyesOf(const Method& method, const View& view, double eyeDistance) {
  if (!method.isStereo()) return {view};
  const std::array<View, 2> pair = stereoViews(view, eyeDistance);
  return {pair.begin(), pair.end()};
}

Result<void> placeFrame(Engine& engine, const Method& method, const TimedView& timed,
                        const std::vector<View>& eyes) {
  if (method.pvs) {
    std::vector<View> seen = pvsViews(timed.view, *method.pvs);
    seen.insert(seen.end(), eyes.begin(), eyes.end());
    engine.findVisible(seen);
  } else {
    engine.findVisible(eyes);
  }
  return engine.place(eyes, method.spatial.at(timed.time));
}

Result<Drawn> drawFrame(Engine& engine, const Method& method, const TimedView& timed,
                        const DrawingOptions& options) {
  const PlaceOptions placing = method.spatial.at(timed.time);
  const std::vector<View> eyes = eyesOf(method, timed.view, options.eyeDistance);
  Drawn drawn;
  const auto count = [&] {
    drawn.invocations += engine.fragments();
    drawn.passed += engine.samplesPassed();
  };
  const auto forward = [&](const View& view, bool prepass = false) {
    engine.forward(view, prepass);
    count();
  };
  const auto picture = [&](std::size_t eye) -> Result<void> {
    switch (method.kind) {
      case Kind::Forward:
      case Kind::ForwardStereo:
        forward(eyes[eye]);
        return {};
      case Kind::ForwardPrepass:
        forward(eyes[eye], true);
        return {};
      case Kind::ForwardLanczos:
        forward(quarterOf(eyes[eye]));
        return engine.upsample(eyes[eye].width, eyes[eye].height);
      case Kind::WarpStereo:
        if (eye > 0) return engine.warp(eyes[0], eyes[eye]);
        forward(eyes[eye]);
        return {};
      case Kind::Rect:
      case Kind::RectStereo:
        engine.display(eyes[eye], DisplayMode::Geometry);
        return {};
      case Kind::RectDeferred:
        engine.display(eyes[eye], DisplayMode::Deferred);
        return {};
    }
    return {};
  };

  engine.clearTimes();
  engine.update(timed.time);
  if (method.usesAtlas()) {
    if (auto placed = placeFrame(engine, method, timed, eyes); !placed) return tl::unexpected(placed.error());
    engine.shade(timed.view, shadeOptions(method.atlas));
    count();
  }
  for (std::size_t eye = 0; eye < eyes.size(); ++eye) {
    if (auto done = picture(eye); !done) return tl::unexpected(done.error());
    if (placing.lens)
      if (auto done = engine.distort(*placing.lens); !done) return tl::unexpected(done.error());
    if (!options.read) continue;
    drawn.pictures.push_back(engine.readColor());
    if (!options.alsoBehind || placing.lens) continue;
    if (auto done = engine.distort(*options.alsoBehind); !done) return tl::unexpected(done.error());
    drawn.behindLens.push_back(engine.readColor());
  }
  addTimes(drawn.times, engine.times(), placing.lens.has_value());
  return drawn;
}

}  // namespace tessera::app
