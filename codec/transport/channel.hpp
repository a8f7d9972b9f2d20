// One TCP connection, plain or TLS, that carries records both ways: queues, pings, timeouts. Lives on one
// thread, the one that runs its io_context; only what says so may be called from another. For the .cpp files
// of this folder.
#pragma once

#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/steady_timer.hpp>
#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "codec/transport/limits.hpp"
#include "codec/transport/record.hpp"
#include "codec/transport/tls.hpp"

namespace tessera::transport {

class Channel : public std::enable_shared_from_this<Channel> {
 public:
  struct Callbacks {
    std::function<void()> opened;             // TLS is done, or there is none: records may go
    std::function<void(Record)> received;     // all but pings and pongs
    std::function<void(std::string)> closed;  // once, with why; the last call
  };

  Channel(asio::ip::tcp::socket socket, const Limits& limits);

  /// Starts. tls: null for plain TCP; else it outlives the channel.
  void open(asio::ssl::context* tls, Side side, Callbacks callbacks);
  /// The handshake is done: messages are taken and pings go out.
  void establish();
  /// A record for the peer. From any thread. Fails, and cuts the peer off, where more than the limit would
  /// wait.
  Result<void> send(Bytes record);
  /// Ends at once.
  void close(std::string reason);
  /// Sends a last record, then ends; at once where it does not leave within a second.
  void closeAfter(Bytes farewell, std::string reason);
  void pauseReading() { paused_ = true; }
  void resumeReading();

  /// From any thread.
  [[nodiscard]] std::size_t pendingBytes() const { return pending_; }
  [[nodiscard]] double roundTripMs() const { return roundTripMs_; }  // 0 before the first answer
  /// The TLS connection; null on a plain one.
  [[nodiscard]] SSL* tls() { return tls_ ? tls_->native_handle() : nullptr; }
  [[nodiscard]] const std::string& peer() const { return peer_; }  // "IP:PORT"
  [[nodiscard]] const std::string& peerIp() const { return peerIp_; }

 private:
  using Clock = std::chrono::steady_clock;

  void lookForTls(asio::ssl::context& tls);
  void startTls(asio::ssl::context& tls, Side side);
  void ready();
  void read();
  void digest();
  void write();
  void tick();
  void enqueue(Bytes record);
  asio::ip::tcp::socket& socket() { return tls_ ? tls_->next_layer() : *plain_; }

  Limits limits_;
  Callbacks callbacks_;
  std::optional<asio::ip::tcp::socket> plain_;
  std::optional<asio::ssl::stream<asio::ip::tcp::socket>> tls_;
  asio::any_io_executor executor_;
  asio::steady_timer timer_;     // the handshake's deadline, then pings
  asio::steady_timer farewell_;  // of closeAfter
  std::string peer_, peerIp_;
  RecordParser parser_;
  Bytes buffer_;
  std::deque<Bytes> queue_;
  std::atomic<std::size_t> pending_ = 0;
  std::atomic<double> roundTripMs_ = 0.0;
  Clock::time_point lastCame_ = Clock::now();
  bool reading_ = false;
  bool writing_ = false;
  bool paused_ = false;
  bool closed_ = false;
  std::optional<std::string> closing_;  // why, while the farewell leaves
};

}  // namespace tessera::transport
