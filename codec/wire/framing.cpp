#include "codec/wire/framing.hpp"

#include <algorithm>

#include "codec/wire/bytes.hpp"

namespace tessera::wire {

namespace {

struct Header {
  std::uint32_t bytes = 0;
  Kind kind = Kind::Hello;
};

Result<Header> readHeader(std::span<const std::uint8_t> bytes) {
  ByteReader in(bytes);
  Header header;
  header.bytes = in.u32();
  header.kind = static_cast<Kind>(in.u8());
  if (!known(header.kind)) return fail("message of kind {}: there is none", static_cast<int>(header.kind));
  for (int i = 0; i < 3; ++i)
    if (const int value = in.u8(); value != 0)
      return fail("{}: {} as a byte of its header that is to be zero", nameOf(header.kind), value);
  if (header.bytes > mostBytes(header.kind))
    return fail("{}: its {} bytes are more than {}", nameOf(header.kind), header.bytes,
                mostBytes(header.kind));
  return header;
}

}  // namespace

void MessageParser::feed(std::span<const std::uint8_t> bytes) {
  if (lost_) return;
  // What was read is dropped once it is the larger part, so that a byte is moved a bounded number of times.
  if (at_ > bytes_.size() / 2) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ = 0;
  }
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

Result<std::optional<Message>> MessageParser::next() {
  if (lost_) return tl::unexpected(*lost_);
  const auto lose = [&](const Error& error) {
    lost_ = error;
    bytes_ = {};
    at_ = 0;
    return tl::unexpected(error);
  };
  const auto waiting = std::span<const std::uint8_t>(bytes_).subspan(at_);
  if (waiting.size() < kHeaderBytes) return std::optional<Message>();
  const auto header = readHeader(waiting);
  if (!header) return lose(header.error());
  if (peer_ && !sends(*peer_, header->kind))
    return lose(
        {fmt::format("{}: from a {}", nameOf(header->kind), *peer_ == Role::Server ? "server" : "viewer")});
  if (peer_ && first_ && header->kind != Kind::Hello && header->kind != Kind::Refusal)
    return lose({fmt::format("{}: before a hello", nameOf(header->kind))});
  const auto body = waiting.subspan(kHeaderBytes);
  if (body.size() < header->bytes) return std::optional<Message>();
  auto message = decode(header->kind, body.first(header->bytes));
  if (!message) return lose(message.error());
  at_ += kHeaderBytes + header->bytes;
  first_ = false;
  return std::optional<Message>(std::move(*message));
}

std::size_t MessageParser::lacking() const {
  const auto waiting = std::span<const std::uint8_t>(bytes_).subspan(at_);
  if (waiting.size() < kHeaderBytes) return kHeaderBytes - waiting.size();
  const std::size_t whole = kHeaderBytes + std::size_t{ByteReader(waiting).u32()};
  return whole - std::min(whole, waiting.size());
}

Result<void> SendQueue::push(const Message& message) {
  auto bytes = encode(message);
  if (!bytes) return tl::unexpected(bytes.error());
  if (pending_ + bytes->size() > limit_)
    return fail("{}: {} bytes wait to be sent, and {} more are past {}", nameOf(kindOf(message)), pending_,
                bytes->size(), limit_);
  pending_ += bytes->size();
  messages_.push_back(std::move(*bytes));
  return {};
}

std::span<const std::uint8_t> SendQueue::front() const {
  if (messages_.empty()) return {};
  return std::span<const std::uint8_t>(messages_.front()).subspan(at_);
}

void SendQueue::sent(std::size_t count) {
  pending_ -= count;
  at_ += count;
  if (!messages_.empty() && at_ >= messages_.front().size()) {
    messages_.pop_front();
    at_ = 0;
  }
}

}  // namespace tessera::wire
