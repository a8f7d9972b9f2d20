// Certificates that were paired with, kept in a file beside a side's own.
//
//   server HOST:PORT SHA256    a viewer's: that server has this certificate
//   viewer SHA256              a server's: a viewer with this certificate was paired
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "codec/transport/crypto.hpp"

namespace tessera::transport {

class Pins {
 public:
  /// Reads the file; no file is no pins. Fails naming the line that is none.
  static Result<Pins> load(const std::filesystem::path& file);

  /// The certificate that a server was paired with. name: HOST:PORT as the user gives it.
  [[nodiscard]] std::optional<Sha256> serverAt(const std::string& name) const;
  [[nodiscard]] bool knowsViewer(const Sha256& fingerprint) const { return viewers_.contains(fingerprint); }
  /// Adds and writes the file, mode 0600. A server that has another pin keeps it: fails.
  Result<void> addServer(const std::string& name, const Sha256& fingerprint);
  Result<void> addViewer(const Sha256& fingerprint);
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  [[nodiscard]] Result<void> write() const;

  std::filesystem::path file_;
  std::map<std::string, Sha256> servers_;
  std::set<Sha256> viewers_;
};

}  // namespace tessera::transport
