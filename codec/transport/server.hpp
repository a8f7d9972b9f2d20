// The server's end: several viewers, each with a TCP channel for messages and a UDP path for video. It runs
// on a thread of its own; no call waits for the network.
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
#include "codec/transport/viewer_video.hpp"

namespace tessera::transport {

struct ServerOptions {
  Address listen{"127.0.0.1", 7400};
  /// What a viewer must be given too; empty: none, plain TCP and RTP, on loopback only. See pairing.hpp for
  /// its length.
  std::string token;
  /// Where the certificate and the pairings are kept; needed with a token.
  std::filesystem::path folder;
  /// Whether a viewer that was never paired may be, by its token.
  bool pairNew = true;
  Versions versions;
  std::size_t viewers = 8;                                               // at once
  Clock::duration frameInterval = std::chrono::nanoseconds(33'333'333);  // > 0, what packets are spread over
  std::size_t packetBytes = 1200;                                        // of a video datagram, [256, 65000]
  Limits limits;
  /// One line at a time, from the server's thread.
  std::function<void(const std::string&)> log;
  TreatAsRemote treatAsRemote;  // for tests
};

using ViewerId = std::uint32_t;  // counts up from 1, never used twice

struct ViewerJoined {
  ViewerId viewer = 0;
  std::string address;      // "IP:PORT"
  bool secure = false;      // TLS and SRTP
  std::string fingerprint;  // of its certificate, to show; empty on a plain channel
  std::uint16_t version = 0;
};
/// Its path for video is open: what is sent from here on may arrive. The first frame should be an I-frame.
struct ViewerVideoOpen {
  ViewerId viewer = 0;
};
struct ViewerMessage {
  ViewerId viewer = 0;
  Bytes bytes;
};
struct ViewerLeft {
  ViewerId viewer = 0;
  std::string reason;
};
using ServerEvent = std::variant<ViewerJoined, ViewerVideoOpen, ViewerMessage, ViewerLeft>;

struct ViewerStatus {
  ViewerId viewer = 0;
  std::size_t pendingBytes = 0;  // wait to be sent on TCP
  double roundTripMs = 0.0;
  SendStatistics video;
};

class Server {
 public:
  /// Fails for an address that cannot be listened on, a remote one without a token, a token that is none, and
  /// what the folder holds being unusable.
  static Result<std::unique_ptr<Server>> start(ServerOptions options);
  /// Whether start() would fail now, for a program that has much to load before it listens: in the same
  /// words. Makes the certificate, where that is needed and not there.
  static Result<void> check(ServerOptions options);
  /// Tells the viewers, and waits for that at most 300 ms.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Where it listens, with the port it got.
  [[nodiscard]] const Address& address() const;
  /// Of its certificate, to show; empty without a token.
  [[nodiscard]] const std::string& fingerprint() const;

  /// What happened since the last call, in order.
  std::vector<ServerEvent> poll();
  /// A message for one viewer, at most limits.messageBytes. Fails where it is longer, where the viewer is
  /// gone, and where too much waits for it already: then it is cut off.
  Result<void> send(ViewerId viewer, std::span<const std::uint8_t> message);
  /// An access unit for one viewer, shared since several may get the same. Frame numbers rise. What is sent
  /// before the viewer's path is open is dropped. Fails where the viewer is gone.
  Result<void> sendVideo(ViewerId viewer, std::uint32_t frame, std::shared_ptr<const Bytes> accessUnit);
  /// Ends one viewer's connection, and tells it why.
  void dismiss(ViewerId viewer, const std::string& why);
  [[nodiscard]] std::vector<ViewerStatus> viewers() const;

 private:
  class State;
  explicit Server(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

}  // namespace tessera::transport
