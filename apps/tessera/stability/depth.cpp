// A near plane at a millimetre under a scene of a thousand kilometres.
#include <cmath>

#include "apps/tessera/stability/case.hpp"
#include "engine/scene/build.hpp"

namespace tessera::stability {

namespace {

constexpr double kNear = 1e-3;
constexpr double kFar = 1e6;

/// Boards from 0.1 m to 1e6 m, each with another a ten-thousandth of its distance behind it that is a little
/// wider, as if seen through a corridor.
Scene boards() {
  Scene scene = build::emptyScene();
  Material white = build::unlit();
  white.doubleSided = true;
  const auto material = build::addMaterial(scene, white);
  float x = -0.9f;
  for (float distance = 0.1f; distance <= 1.01e6f; distance *= 10.0f) {
    for (const float layer : {1.0f, 1.0001f}) {
      const float reach = distance * layer;
      build::place(scene, build::addGrid(scene, {x * reach, -0.5f * reach, -reach},
                                         {0.22f * reach * layer, 0, 0}, {0, reach, 0}, 2, 2, material));
    }
    x += 0.23f;
  }
  build::finish(scene);
  return scene;
}

/// Share of the pixels whose id is another after the camera moved so far, in percent; of a hundred frames the
/// worst.
Result<double> changedIds(Bench& bench, double step) {
  EngineOptions options;
  options.splitEdges = 0.0;
  auto made = makeEngine(bench, boards(), {}, options);
  if (!made) return tl::unexpected(made.error());
  Engine& engine = **made;
  const auto idsFrom = [&](double x) {
    const View view = look({x, 0, 0}, {x, 0, -1}, 60.0, kNear);
    engine.findVisible({&view, 1});
    return engine.readIds();
  };
  const std::vector<std::uint32_t> first = idsFrom(0.0);
  std::size_t covered = 0;
  for (const std::uint32_t id : first) covered += id != 0 ? 1 : 0;
  if (covered < first.size() / 2) return fail("only {} of {} pixels are covered", covered, first.size());
  double worst = 0.0;
  for (int frame = 1; frame <= 20; ++frame) {
    const std::vector<std::uint32_t> now = idsFrom(frame % 2 == 0 ? 0.0 : step);
    std::size_t changed = 0;
    for (std::size_t i = 0; i < first.size(); ++i) changed += now[i] != first[i] ? 1 : 0;
    worst = std::max(worst, 100.0 * static_cast<double>(changed) / static_cast<double>(first.size()));
  }
  return worst;
}

/// Pixels of the boards that show the layer behind.
Result<double> wrongLayer(Bench& bench, bool reversed) {
  EngineOptions options;
  options.forms.reversedDepth = reversed;
  options.splitEdges = 0.0;
  Scene scene = boards();
  // Green in front, red behind; both of one size, so that no red is to be seen.
  Material front = build::unlit();
  Material behind = build::unlit();
  front.baseColorFactor = {0, 1, 0, 1};
  behind.baseColorFactor = {1, 0, 0, 1};
  const auto green = build::addMaterial(scene, front);
  const auto red = build::addMaterial(scene, behind);
  for (std::size_t i = 0; i < scene.primitives.size(); ++i)
    scene.primitives[i].material = i % 2 == 0 ? green : red;
  auto made = makeEngine(bench, std::move(scene), {}, options);
  if (!made) return tl::unexpected(made.error());
  const auto image = draw(**made, Method::Forward, look({0, 0, 0}, {0, 0, -1}, 50.0, kNear));
  if (!image) return tl::unexpected(image.error());
  double wrong = 0.0;
  for (std::size_t i = 0; i < image->pixels.size(); i += 4) wrong += image->pixels[i] > 200 ? 1.0 : 0.0;
  return countCovered(*image) > image->pixels.size() / 8 ? wrong : 1e9;
}

/// Pairs of surfaces, the farther one behind by `share` of its distance, whose depths are not in order.
template <class Depth>
double unordered(const Depth& depth, double share) {
  double wrong = 0.0;
  for (double distance = kNear * 1.001; distance < kFar; distance *= 1.01)
    wrong += depth(distance) > depth(distance * (1.0 + share)) ? 0.0 : 1.0;
  return wrong;
}

double reversedFloat(double distance) {
  View view;
  view.zNear = kNear;
  const glsl::ViewGpu gpu = viewGpu(view, {0, 0, 0});
  const glm::vec4 clip = gpu.viewProjection * glm::vec4(0.0f, 0.0f, static_cast<float>(-distance), 1.0f);
  return static_cast<double>(clip.z / clip.w);
}

/// Greater is nearer, as above.
double forward24(double distance) {
  const double z = kFar / (kFar - kNear) * (1.0 - kNear / distance);
  return -std::round(z * 16777215.0);
}

}  // namespace

void addDepthCases(Cases& cases) {
  cases.push_back({"depth/same-camera", "near 1e-3, far 1e6, and the camera stands: ids between frames",
                   "% of pixels changed", 0.0, Sense::AtMost,
                   [](Bench& bench) { return changedIds(bench, 0.0); }});
  cases.push_back({"depth/moved-1e-6", "the same, and the camera moves by 1e-6", "% of pixels changed", 0.01,
                   Sense::AtMost, [](Bench& bench) { return changedIds(bench, 1e-6); }});
  cases.push_back({"depth/layers",
                   "pairs of surfaces a ten-thousandth of their distance apart, from 0.1 to 1e6: the "
                   "nearer is seen",
                   "wrong pixels", 0.0, Sense::AtMost, [](Bench& bench) { return wrongLayer(bench, true); }});
  cases.push_back({"depth/layers-24-bit-fail", "the same in 24-bit depth that is 0 at the near plane",
                   "wrong pixels", 1000.0, Sense::AtLeast,
                   [](Bench& bench) { return wrongLayer(bench, false); }});
  cases.push_back({"depth/reversed-float",
                   "pairs a millionth of their distance apart, from 1e-3 to 1e6, in reversed "
                   "32-bit depth",
                   "unordered pairs", 0.0, Sense::AtMost,
                   [](Bench&) -> Result<double> { return unordered(reversedFloat, 1e-6); }});
  cases.push_back({"depth/24-bit-forward-fails",
                   "pairs a tenth of their distance apart in 24-bit depth that is 0 at "
                   "the near plane",
                   "unordered pairs", 500.0, Sense::AtLeast,
                   [](Bench&) -> Result<double> { return unordered(forward24, 0.1); }});
}

}  // namespace tessera::stability
