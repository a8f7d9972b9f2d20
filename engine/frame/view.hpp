// A camera over a picture: all that a stage needs to know of where it looks from.
#pragma once

#include <array>
#include <optional>

#include <glm/glm.hpp>

#include "engine/lens/lens.hpp"
#include "engine/measure/acuity.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/stage.hpp"
#include "glsl/shared/acuity.h"
#include "glsl/shared/scene.h"

namespace tessera {

/// A perspective view. Depth is reversed, 1 at `zNear` and 0 at infinity: there is no far plane.
struct View {
  glm::dvec3 eye{0.0};
  glm::dvec3 forward{0.0, 0.0, -1.0};  // unit
  glm::dvec3 up{0.0, 1.0, 0.0};        // unit, orthogonal to forward
  double fovY = 1.0;                   // radians, (0, pi)
  double zNear = 0.05;                 // metres, > 0
  int width = 1280;                    // pixels
  int height = 720;

  bool operator==(const View&) const = default;

  /// r / f of Mueller 2021, eq. 3.1, taken along the height: pixels are square.
  [[nodiscard]] double pixelsPerRadian() const { return static_cast<double>(height) / fovY; }
};

/// What levels follow beside the views' distances. Absent is off, and costs nothing.
struct PlaceOptions {
  std::optional<Foveation> foveation =
      std::nullopt;  // the gaze is a place in each view's own picture, before any lens
  std::optional<Lens> lens = std::nullopt;
};

/// A view from an eye towards a target. `up` is +y, or -z when looking straight up or down.
View lookAt(const glm::dvec3& eye, const glm::dvec3& target, double fovYDegrees, int width, int height,
            double zNear);
View viewOf(const CameraKey& key, int width, int height, double zNear);
/// Two parallel eyes, left and right, each half of `eyeDistance` metres from the centre. Visibility, levels
/// and display take the pair; shading is once, and best from `centre`: neither eye's highlights are favoured.
std::array<View, 2> stereoViews(const View& centre, double eyeDistance);
/// The scene's camera `index` at the state's time. Orthographic cameras become a narrow perspective from
/// farther off.
View viewOf(const Scene& scene, const SceneState& state, std::size_t index, int width, int height,
            double zNear);
/// A view that shows the whole scene from a little above: what `--camera auto` means.
View autoView(const Scene& scene, int width, int height);
/// A near plane for a scene: close enough for its smallest views, and one place to say so.
double defaultNear(const Scene& scene);

/// Rotation and projection, from positions relative to `anchor` to clip space; computed in double.
glm::dmat4 viewProjection(const View& view, const glm::dvec3& anchor);
/// `reversed`: depth 1 at zNear, 0 at infinity; false: 0 and 1.
glsl::ViewGpu viewGpu(const View& view, const glm::dvec3& anchor, bool reversed = true);
/// What level selection reads of a view when options are on; fields of an absent option are not read.
glsl::DensityGpu densityGpu(const View& view, const PlaceOptions& options);
/// Columns c0, c1, c2: the ray through (x, y) in pixels from the bottom left is c0 + x c1 + y c2, relative to
/// the eye.
glm::dmat3 pixelToRay(const View& view);
/// The unit direction of a place in the view's picture, a share of it from its top left.
glm::dvec3 gazeDirection(const View& view, const glm::dvec2& place);

/// The planes of a frustum (five without a far plane), positive inside, from a matrix to clip space with
/// depth in [0, w].
struct Frustum {
  std::array<glm::dvec4, 6> planes{};
  int count = 0;
  /// False only if the box lies wholly outside.
  [[nodiscard]] bool touches(const Box& box) const;
};
Frustum frustumOf(const glm::dmat4& toClip);

}  // namespace tessera
