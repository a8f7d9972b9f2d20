#include "codec/transport/pins.hpp"

#include <fstream>
#include <sstream>

#include "codec/transport/identity.hpp"

namespace tessera::transport {

Result<Pins> Pins::load(const std::filesystem::path& file) {
  Pins pins;
  pins.file_ = file;
  std::ifstream in(file);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line);
    std::string kind, name, digits, rest;
    words >> kind;
    if (kind == "server") words >> name;
    words >> digits >> rest;
    const auto fingerprint = readSha256(digits);
    if ((kind != "server" && kind != "viewer") || !fingerprint || !rest.empty())
      return fail("{}: line {}: expected 'server HOST:PORT SHA256' or 'viewer SHA256'", file.string(),
                  number);
    if (kind == "viewer") {
      pins.viewers_.insert(*fingerprint);
    } else if (!pins.servers_.emplace(name, *fingerprint).second) {
      return fail("{}: line {}: {} has a certificate already", file.string(), number, name);
    }
  }
  return pins;
}

std::optional<Sha256> Pins::serverAt(const std::string& name) const {
  const auto found = servers_.find(name);
  if (found == servers_.end()) return std::nullopt;
  return found->second;
}

Result<void> Pins::addServer(const std::string& name, const Sha256& fingerprint) {
  const auto [place, added] = servers_.emplace(name, fingerprint);
  if (place->second != fingerprint) return fail("{}: paired with another certificate", name);
  return added ? write() : Result<void>();
}

Result<void> Pins::addViewer(const Sha256& fingerprint) {
  return viewers_.insert(fingerprint).second ? write() : Result<void>();
}

Result<void> Pins::write() const {
  std::string text;
  for (const auto& [name, fingerprint] : servers_)
    text += fmt::format("server {} {}\n", name, hex(fingerprint));
  for (const Sha256& fingerprint : viewers_) text += fmt::format("viewer {}\n", hex(fingerprint));
  return writePrivateFile(file_, text);
}

}  // namespace tessera::transport
