// A side's own certificate: self-signed, made at first use, kept in a folder.
#pragma once

#include <filesystem>
#include <string>

#include "codec/transport/crypto.hpp"

namespace tessera::transport {

/// A certificate and its key, as PEM.
struct Identity {
  std::string certificate;
  std::string key;
  Sha256 fingerprint{};  // SHA-256 of the certificate in DER
};

/// A new one: ECDSA on P-256, valid for 20 years; what counts is its fingerprint, not its dates.
Result<Identity> makeIdentity();
/// FOLDER/certificate.pem and FOLDER/key.pem, made with mode 0600 (the folder 0700) where neither is there.
/// Fails where only one is there, they do not fit each other, or others than the owner may read the key.
Result<Identity> loadOrMakeIdentity(const std::filesystem::path& folder);

/// "ab12 cd34 …": SHA-256 in groups of four, to compare by eye.
std::string showFingerprint(const Sha256& fingerprint);

/// Writes a file of mode 0600 whole or not at all: beside its place first, then moved there.
Result<void> writePrivateFile(const std::filesystem::path& path, std::string_view text);

}  // namespace tessera::transport
