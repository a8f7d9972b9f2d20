// Text files that were compiled into the library.
#pragma once

#include <span>
#include <string_view>

namespace tessera {

struct EmbeddedText {
  std::string_view path;  // relative to the folder it was embedded from
  std::string_view text;
};

std::span<const EmbeddedText> embeddedGlsl();

}  // namespace tessera
