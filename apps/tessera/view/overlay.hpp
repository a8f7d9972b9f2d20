// What a window shows over the picture.
#pragma once

#include "apps/tessera/view/viewing.hpp"

namespace tessera::app {

/// Draws with Dear ImGui, within a frame of it: why there is no live picture, whenever there is none; the
/// figures where `figures` is set.
void drawOverlay(const Viewing& viewing, bool figures);

}  // namespace tessera::app
