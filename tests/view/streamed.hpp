// An engine and a viewer's display that was sent the same frame, coded video and geometry.
#pragma once

#include <memory>
#include <optional>

#include "engine/frame/engine.hpp"
#include "engine/image/image.hpp"
#include "engine/view/display.hpp"

namespace tessera::test {

struct Streamed {
  std::unique_ptr<Engine> engine;
  std::optional<view::StreamedDisplay> display;
  explicit operator bool() const { return engine && display; }
};

/// Shaded for one view. What goes wrong is a failure of the test, and the result is false.
Streamed streamed(Scene scene, GathererKind gatherer, const View& shaded,
                  const view::DisplayOptions& displayOptions = {});

/// Decibels, or 0 and a failure of the test.
double psnrOf(const Image& engine, const Image& viewer);

}  // namespace tessera::test
