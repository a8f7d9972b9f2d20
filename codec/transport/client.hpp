// The viewer's end: a TCP channel for messages and a UDP path for video to one server, reconnected when it is
// lost. It runs on a thread of its own; no call waits for the network.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "codec/transport/address.hpp"
#include "codec/transport/limits.hpp"
#include "codec/transport/record.hpp"
#include "codec/transport/rtp_receive.hpp"

namespace tessera::transport {

struct ClientOptions {
  Address server{"127.0.0.1", 7400};
  std::string token;             // the server's; empty: none, on loopback only
  std::filesystem::path folder;  // of the certificate and the pairings; needed with a token
  /// Whether a server that was never paired may be, by its token.
  bool pairNew = true;
  Versions versions;
  Limits limits;
  ReceiveLimits receive;
  std::size_t videoInbox = 64;  // frames that may wait to be polled; past that the oldest is dropped
  bool reconnect = true;
  std::chrono::milliseconds firstBackoff{100};  // doubled with each try, till one holds for longestBackoff
  std::chrono::milliseconds longestBackoff{5000};
  std::chrono::milliseconds hello{500};  // between two video hellos
  /// One line at a time, from the client's thread.
  std::function<void(const std::string&)> log;
  TreatAsRemote treatAsRemote;  // for tests
};

struct Connected {
  bool secure = false;      // TLS and SRTP
  std::string fingerprint;  // of the server's certificate, to show; empty on a plain channel
  bool paired = false;      // just now, for the first time
  std::uint16_t version = 0;
};
struct Disconnected {
  std::string reason;
  bool retrying = false;  // false: this was the last try
};
struct ServerMessage {
  Bytes bytes;
};
/// A frame, whole or not. Where it is not complete, or frames before it are lost, what follows cannot be
/// decoded until an I-frame: ask for one on the message channel.
struct VideoFrame {
  ReceivedFrame frame;
};
using ClientEvent = std::variant<Connected, Disconnected, ServerMessage, VideoFrame>;

struct ClientStatus {
  bool connected = false;
  std::size_t pendingBytes = 0;  // wait to be sent
  double roundTripMs = 0.0;
  /// Of the present connection, or the last one. Adaptive bitrate would report these to the server.
  VideoStatistics video;
};

class Client {
 public:
  /// Starts to connect. Fails for a token that is none and for what the folder holds being unusable; whatever
  /// the network does is an event.
  static Result<std::unique_ptr<Client>> start(ClientOptions options);
  /// Tells the server, and waits for that at most 300 ms.
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// What happened since the last call, in order.
  std::vector<ClientEvent> poll();
  /// A message for the server, at most limits.messageBytes. Fails where it is longer, while not connected,
  /// and where too much waits already: then the connection ends.
  Result<void> send(std::span<const std::uint8_t> message);
  [[nodiscard]] ClientStatus status() const;

 private:
  class State;
  explicit Client(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

}  // namespace tessera::transport
