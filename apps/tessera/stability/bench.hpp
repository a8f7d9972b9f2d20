// What the cases draw with: one context, small pictures, every way to fill an atlas.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/tessera.hpp"

namespace tessera::stability {

/// Tess is with the ways to sample that its default threshold gives, Over with oversampling alone.
enum class Method : std::uint8_t { Forward, Rect, Tess, Over, Texel };
inline constexpr std::array<Method, 5> kMethods = {Method::Forward, Method::Rect, Method::Tess, Method::Over,
                                                   Method::Texel};
const char* nameOf(Method method);

inline constexpr int kWidth = 192;
inline constexpr int kHeight = 108;

/// What a covered pixel may not be.
enum class Pixels : std::uint8_t {
  Any,
  Lit,   // black: light falls on everything, and shading writes black in place of what is not a number
  White  // other than white: the scene is, and what was not shaded is black
};

struct Bench {
  gl::Context& context;
  bool full = false;  // what takes minutes, in full
};

/// An engine whose atlases are small and hold half floats, at time 0.
Result<std::unique_ptr<Engine>> makeEngine(Bench& bench, Scene scene, std::optional<Stage> stage = {},
                                           EngineOptions options = {});
/// The picture by one method. What the atlas held before is gone.
Result<Image> draw(Engine& engine, Method method, const View& view);

/// Texels that are not finite, covered pixels that `pixels` forbids, and pixels that forward covers and a
/// method does not or the other way round: over all methods and views.
/// Fails where forward covers less than `leastCovered` of a picture: what is not drawn proves nothing.
Result<double> badPixels(Bench& bench, Scene scene, std::optional<Stage> stage, std::span<const View> views,
                         Pixels pixels, const EngineOptions& options = {}, double leastCovered = 0.0);

/// Makes `method` the one that fills the atlas; nothing to do for Forward.
Result<void> use(Engine& engine, Method method, const RectMemoryOptions& memory = {});

/// A scene with its lights, and the views of it.
struct Shot {
  Scene scene;
  std::optional<Stage> stage;
  std::vector<View> views;
};
/// PSNR of the same views of two scenes, the least over the methods and views in dB; 99 where they are equal.
/// 0 where the first covers less than a tenth of a picture: nothing would be compared.
Result<double> leastPsnr(Bench& bench, const Shot& a, const Shot& b, const EngineOptions& options = {},
                         std::span<const Method> methods = kMethods);

/// A view of kWidth x kHeight.
View look(const glm::dvec3& eye, const glm::dvec3& target, double fovYDegrees = 60.0, double zNear = 0.01);
std::size_t countCovered(const Image& image);
/// Bytes that differ, and by how much the farthest two.
std::size_t countDifferent(const Image& a, const Image& b);
int largestDifference(const Image& a, const Image& b);

}  // namespace tessera::stability
