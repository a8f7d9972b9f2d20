#include "codec/transport/channel.hpp"

#include <asio/buffer.hpp>
#include <asio/post.hpp>
#include <asio/write.hpp>

#include "codec/transport/address.hpp"

namespace tessera::transport {

namespace {

constexpr std::size_t kReadBytes = 1 << 16;
constexpr std::uint8_t kTlsHandshake = 0x16;  // first byte of a TLS connection (RFC 8446, sec. 5.1)

std::uint64_t microseconds(std::chrono::steady_clock::time_point time) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count());
}

}  // namespace

Channel::Channel(asio::ip::tcp::socket socket, const Limits& limits)
    : limits_(limits),
      plain_(std::move(socket)),
      executor_(plain_->get_executor()),
      timer_(executor_),
      farewell_(executor_),
      parser_(limits.messageBytes),
      buffer_(kReadBytes) {
  asio::error_code error;
  plain_->set_option(asio::ip::tcp::no_delay(true), error);
  if (const auto endpoint = plain_->remote_endpoint(error); !error) {
    peerIp_ = endpoint.address().to_string();
    peer_ = describe(Address{peerIp_, endpoint.port()});
  }
}

void Channel::open(asio::ssl::context* tls, Side side, Callbacks callbacks) {
  callbacks_ = std::move(callbacks);
  timer_.expires_after(limits_.handshake);
  timer_.async_wait([self = shared_from_this()](asio::error_code error) {
    if (!error) self->close(fmt::format("no handshake within {} ms", self->limits_.handshake.count()));
  });
  if (tls == nullptr) return ready();
  if (side == Side::Server) return lookForTls(*tls);
  startTls(*tls, side);
}

void Channel::lookForTls(asio::ssl::context& tls) {
  // A peer that speaks plain TCP is told so in its own language; TLS's alert would be noise to it.
  plain_->async_wait(asio::ip::tcp::socket::wait_read, [self = shared_from_this(),
                                                        &tls](asio::error_code error) {
    if (self->closed_) return;
    std::uint8_t first = 0;
    if (!error) self->plain_->receive(asio::buffer(&first, 1), asio::socket_base::message_peek, error);
    if (error) return self->close(fmt::format("connection lost before a byte came: {}", error.message()));
    if (first == kTlsHandshake) return self->startTls(tls, Side::Server);
    self->closeAfter(encode(Refusal{RefusalReason::Security,
                                    {},
                                    "plain TCP is refused: this server asks for TLS and a pairing token"}),
                     "plain TCP is refused: TLS and a pairing token are a must here");
  });
}

void Channel::startTls(asio::ssl::context& tls, Side side) {
  tls_.emplace(std::move(*plain_), tls);
  plain_.reset();
  const auto type = side == Side::Server ? asio::ssl::stream_base::server : asio::ssl::stream_base::client;
  tls_->async_handshake(type, [self = shared_from_this()](asio::error_code error) {
    if (self->closed_) return;
    if (error)
      return self->close(fmt::format(
          "TLS handshake refused: {}; TLS 1.3 with certificates on both sides is a must", error.message()));
    self->ready();
  });
}

void Channel::ready() {
  callbacks_.opened();
  if (!closed_) read();
}

void Channel::establish() {
  parser_.allowMessages();
  lastCame_ = Clock::now();
  timer_.cancel();
  tick();
}

void Channel::tick() {
  timer_.expires_after(limits_.ping);
  timer_.async_wait([self = shared_from_this()](asio::error_code error) {
    if (error || self->closed_ || self->closing_) return;
    const auto now = Clock::now();
    // While nothing is read, the silence is this side's own.
    if (self->paused_) self->lastCame_ = now;
    if (now - self->lastCame_ > self->limits_.silence)
      return self->close(fmt::format("nothing came for {} ms", self->limits_.silence.count()));
    if (self->send(encodePing(microseconds(now)))) self->tick();
  });
}

Result<void> Channel::send(Bytes record) {
  const std::size_t size = record.size();
  const std::size_t waiting = pending_.fetch_add(size) + size;
  if (waiting > limits_.pendingBytes) {
    pending_ -= size;
    const std::string reason =
        fmt::format("too slow: {} bytes wait to be sent, at most {} may", waiting, limits_.pendingBytes);
    asio::post(executor_, [self = shared_from_this(), reason] { self->close(reason); });
    return fail("{}: {}", peer_, reason);
  }
  asio::post(executor_, [self = shared_from_this(), record = std::move(record)]() mutable {
    self->enqueue(std::move(record));
  });
  return {};
}

void Channel::enqueue(Bytes record) {
  if (closed_ || closing_) {
    pending_ -= record.size();
    return;
  }
  queue_.push_back(std::move(record));
  write();
}

void Channel::write() {
  if (writing_ || closed_) return;
  if (queue_.empty()) {
    // The peer reads the farewell, then closes; closing first, with its bytes unread, would make TCP drop it.
    asio::error_code ignored;
    if (closing_) socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    return;
  }
  writing_ = true;
  const auto wrote = [self = shared_from_this()](asio::error_code error, std::size_t) {
    self->writing_ = false;
    if (self->closed_) return;
    if (error) return self->close(fmt::format("connection lost: {}", error.message()));
    self->pending_ -= self->queue_.front().size();
    self->queue_.pop_front();
    self->write();
  };
  if (tls_) {
    asio::async_write(*tls_, asio::buffer(queue_.front()), wrote);
  } else {
    asio::async_write(*plain_, asio::buffer(queue_.front()), wrote);
  }
}

void Channel::read() {
  if (reading_ || closed_ || (paused_ && !closing_)) return;
  reading_ = true;
  const auto came = [self = shared_from_this()](asio::error_code error, std::size_t count) {
    self->reading_ = false;
    if (self->closed_) return;
    // What comes behind a farewell is dropped.
    if (self->closing_) return error ? self->close(*self->closing_) : self->read();
    if (error)
      return self->close(error == asio::error::eof ? "the peer closed the connection"
                                                   : fmt::format("connection lost: {}", error.message()));
    self->lastCame_ = Clock::now();
    self->parser_.feed({self->buffer_.data(), count});
    self->digest();
    self->read();
  };
  if (tls_) {
    tls_->async_read_some(asio::buffer(buffer_), came);
  } else {
    plain_->async_read_some(asio::buffer(buffer_), came);
  }
}

void Channel::digest() {
  while (!paused_ && !closed_ && !closing_) {
    auto record = parser_.next();
    if (!record)
      return closeAfter(encode(Refusal{RefusalReason::Protocol, {}, record.error().message}),
                        fmt::format("cut off: {}", record.error().message));
    if (!*record) return;
    if ((*record)->kind != RecordKind::Ping && (*record)->kind != RecordKind::Pong) {
      callbacks_.received(std::move(**record));
      continue;
    }
    const auto number = readPing((*record)->body);
    if (!number) return close(fmt::format("cut off: {}", number.error().message));
    if ((*record)->kind == RecordKind::Ping) {
      (void)send(encodePong(*number));
    } else if (const std::uint64_t now = microseconds(Clock::now()); *number <= now) {
      roundTripMs_ = 1e-3 * static_cast<double>(now - *number);
    }
  }
}

void Channel::resumeReading() {
  if (!paused_) return;
  paused_ = false;
  digest();
  read();
}

void Channel::closeAfter(Bytes farewell, std::string reason) {
  if (closed_ || closing_) return;
  pending_ += farewell.size();
  queue_.push_back(std::move(farewell));
  closing_ = std::move(reason);
  farewell_.expires_after(std::chrono::seconds(1));
  farewell_.async_wait([self = shared_from_this()](asio::error_code error) {
    if (!error && !self->closed_) self->close(*self->closing_);
  });
  write();
  read();
}

void Channel::close(std::string reason) {
  if (closed_) return;
  closed_ = true;
  timer_.cancel();
  farewell_.cancel();
  asio::error_code ignored;
  socket().shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket().close(ignored);
  // The callbacks hold who made the channel; freed here, there is no cycle.
  const auto closed = std::move(callbacks_.closed);
  asio::post(executor_, [self = shared_from_this()] { self->callbacks_ = {}; });
  if (closed) closed(std::move(reason));
}

}  // namespace tessera::transport
