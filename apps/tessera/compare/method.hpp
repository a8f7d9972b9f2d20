// What `tessera compare --methods` names: ways to draw a frame.
#pragma once

#include <cstdint>
#include <string>

#include "engine/core/result.hpp"

namespace tessera::app {

enum class Kind : std::uint8_t { Forward, ForwardPrepass, Rect, RectDeferred };

struct Method {
  std::string name;
  Kind kind = Kind::Forward;
  double bias = 0.0;
  [[nodiscard]] bool usesAtlas() const { return kind == Kind::Rect || kind == Kind::RectDeferred; }
};

/// "rect:bias=-2" as a method; `defaultBias` where the text says none.
Result<Method> parseMethod(const std::string& text, double defaultBias);

}  // namespace tessera::app
