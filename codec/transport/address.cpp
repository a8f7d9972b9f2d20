#include "codec/transport/address.hpp"

#include <asio/ip/address.hpp>
#include <charconv>

namespace tessera::transport {

Result<Address> parseAddress(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return fail("address '{}': expected HOST:PORT", text);
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return fail("address '{}': an IPv6 address goes in brackets: [::1]:7400", text);
  }
  if (host.empty()) return fail("address '{}': no host before the colon", text);
  Address address{std::string(host), 0};
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  if (error != std::errc() || end != port.data() + port.size() || port.empty())
    return fail("address '{}': port '{}' is not a whole number from 0 to 65535", text, port);
  return address;
}

std::string describe(const Address& address) {
  const bool v6 = address.host.find(':') != std::string::npos;
  return v6 ? fmt::format("[{}]:{}", address.host, address.port)
            : fmt::format("{}:{}", address.host, address.port);
}

bool isLoopback(const std::string& ip) {
  asio::error_code error;
  const asio::ip::address address = asio::ip::make_address(ip, error);
  if (error) return false;
  if (address.is_v6() && address.to_v6().is_v4_mapped())
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).is_loopback();
  return address.is_loopback();
}

bool plainAllowed(const std::string& ip, const TreatAsRemote& treatAsRemote) {
  return isLoopback(ip) && !(treatAsRemote && treatAsRemote(ip));
}

}  // namespace tessera::transport
