#pragma once

namespace embed {

/// Pixels from the lower left of the host's framebuffer.
struct Rectangle {
  int x = 0, y = 0, width = 0, height = 0;
};

}  // namespace embed
