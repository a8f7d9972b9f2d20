#include "codec/wire/handshake.hpp"

namespace tessera::wire {

namespace {

bool sameToken(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const char other = i < b.size() ? b[i] : '\0';
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(other);
  }
  return difference == 0;
}

const char* nameOf(Role role) { return role == Role::Server ? "server" : "viewer"; }

}  // namespace

Answer answer(const Hello& hello, Role own, const Versions& spoken, const std::string& token) {
  Answer result;
  result.refusal.versions = spoken;
  const auto version = commonVersion(hello.versions, spoken);
  if (!version) {
    result.refusal.reason = RefusalReason::Version;
    result.refusal.why = fmt::format("this {} speaks {}, the other side {}: none is common", nameOf(own),
                                     describe(spoken), describe(hello.versions));
  } else if (hello.role == own) {
    result.refusal.reason = RefusalReason::Role;
    result.refusal.why = fmt::format("both sides are a {}", nameOf(own));
  } else if (!sameToken(token, hello.token) && !token.empty()) {
    result.refusal.reason = RefusalReason::Token;
    result.refusal.why = "the pairing token is not this side's";
  } else {
    result.version = version;
  }
  return result;
}

}  // namespace tessera::wire
