// Expected failures are values: a message that names the file, the element and the value.
#pragma once

#include <string>
#include <utility>

#include <fmt/format.h>
#include <tl/expected.hpp>

namespace tessera {

/// What went wrong, in one line fit for a user: "scene.glb: mesh 3, primitive 0: index 912 is past 640
/// vertices".
struct Error {
  std::string message;
};

template <class T>
using Result = tl::expected<T, Error>;

/// Text that came from a file, fit for one line: control characters become question marks.
inline std::string oneLine(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

/// Returns an error value with a formatted message: `return fail("{}: bad magic {:#x}", path, magic);`
template <class... Args>
tl::unexpected<Error> fail(fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(Error{fmt::format(format, std::forward<Args>(args)...)});
}

}  // namespace tessera
