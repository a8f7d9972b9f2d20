// Where a cursor rests in a picture.
#pragma once

#include <algorithm>

#include <glm/glm.hpp>

#include "rectangle.hpp"

namespace embed {

/// The place in `picture` under a cursor, as a share of the picture from its top left: what Foveation::gaze
/// takes. A cursor beside the picture is at its nearest edge. `cursor` is in pixels from the top left of a
/// framebuffer of `height` rows, which the picture's rectangle counts from the lower left of.
inline glm::dvec2 gazeUnder(const glm::dvec2& cursor, const Rectangle& picture, int height) {
  const glm::dvec2 corner(picture.x, height - picture.y - picture.height);
  const glm::dvec2 size(picture.width, picture.height);
  return glm::clamp((cursor - corner) / size, glm::dvec2(0.0), glm::dvec2(1.0));
}

}  // namespace embed
