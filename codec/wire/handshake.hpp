// Whether two sides can speak with each other, and in which version.
#pragma once

#include <optional>
#include <string>

#include "codec/wire/message.hpp"

namespace tessera::wire {

/// Versions that this code speaks.
inline constexpr Versions kSpoken{2, 2};  // 1 sent masks unpacked

/// A side's answer to a hello: the version to speak, or the refusal to send before hanging up. `token`: what
/// a peer must give, empty for none; compared in a time that does not depend on where they differ.
struct Answer {
  std::optional<std::uint16_t> version;
  Refusal refusal;  // where there is no version
};
Answer answer(const Hello& hello, Role own, const Versions& spoken, const std::string& token);

}  // namespace tessera::wire
