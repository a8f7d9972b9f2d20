// Where a server listens and a viewer connects, and which addresses need pairing.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "engine/core/result.hpp"

namespace tessera::transport {

struct Address {
  std::string host;        // a name or an IP address, without brackets
  std::uint16_t port = 0;  // of TCP and of UDP alike; 0, for a server only: any that is free in both
};

/// "HOST:PORT", "[IPV6]:PORT"; port [0, 65535]. Fails naming the text.
Result<Address> parseAddress(std::string_view text);
/// The other way round.
std::string describe(const Address& address);

/// Whether an IP address is of this machine alone: 127.0.0.0/8, ::1, or the former mapped into IPv6. False
/// for what is no IP address.
bool isLoopback(const std::string& ip);

/// For tests: addresses to treat as remote though they are loopback. It can only make the rule stricter.
using TreatAsRemote = std::function<bool(const std::string& ip)>;
/// Whether plain TCP and RTP without encryption are allowed at an address.
bool plainAllowed(const std::string& ip, const TreatAsRemote& treatAsRemote);

}  // namespace tessera::transport
