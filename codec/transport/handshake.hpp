// What both sides say before they are connected (see record.hpp), without a socket: records in, records out.
#pragma once

#include <optional>
#include <string>

#include "codec/transport/pairing.hpp"
#include "codec/transport/record.hpp"

namespace tessera::transport {

/// What one more record led to.
struct HandshakeStep {
  Bytes send;                      // records for the peer, may be empty
  bool done = false;               // connected
  std::optional<Refusal> refused;  // this side's, and part of `send`, or the peer's
  bool byPeer = false;             // refused, by the peer
};

/// What a secure channel stands on; none on a plain one.
struct SecureTerms {
  PairingKey key;
  Binding binding;
};

class ServerHandshake {
 public:
  /// ready: what to tell a viewer at the end; its srtpKey is set exactly where there are terms.
  ServerHandshake(const Versions& spoken, std::optional<SecureTerms> terms, const Ready& ready);
  /// The viewer's next record. After done or refused: a protocol error.
  HandshakeStep receive(const Record& record);
  /// The version to speak; 0 before it is agreed.
  [[nodiscard]] std::uint16_t version() const { return version_; }

 private:
  HandshakeStep hello(const Record& record);
  HandshakeStep proof(const Record& record);
  HandshakeStep refuse(RefusalReason reason, std::string why);

  enum class Wants { Hello, Proof, Nothing };
  Versions spoken_;
  std::optional<SecureTerms> terms_;
  Ready ready_;
  Wants wants_ = Wants::Hello;
  Nonce own_{}, viewers_{};
  std::uint16_t version_ = 0;
};

class ClientHandshake {
 public:
  ClientHandshake(const Versions& spoken, std::optional<SecureTerms> terms);
  /// The first record to send.
  [[nodiscard]] Bytes begin() const;
  /// The server's next record.
  HandshakeStep receive(const Record& record);
  /// After done.
  [[nodiscard]] const Ready& ready() const { return ready_; }
  [[nodiscard]] std::uint16_t version() const { return version_; }

 private:
  HandshakeStep welcome(const Record& record);
  HandshakeStep proof(const Record& record);
  HandshakeStep ready(const Record& record);
  HandshakeStep refuse(RefusalReason reason, std::string why);

  enum class Wants { Welcome, Proof, Ready, Nothing };
  Versions spoken_;
  std::optional<SecureTerms> terms_;
  Ready ready_;
  Wants wants_ = Wants::Welcome;
  Nonce own_{}, servers_{};
  std::uint16_t version_ = 0;
};

}  // namespace tessera::transport
