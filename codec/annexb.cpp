#include "codec/annexb.hpp"

#include <cstring>

namespace tessera {

namespace {

/// Place of the next 00 00 01 from `from` on; the stream's size where there is none.
std::size_t nextStart(std::span<const std::uint8_t> stream, std::size_t from) {
  for (std::size_t i = from + 2; i < stream.size();) {
    const auto* found =
        static_cast<const std::uint8_t*>(std::memchr(stream.data() + i, 1, stream.size() - i));
    if (found == nullptr) break;
    const auto at = static_cast<std::size_t>(found - stream.data());
    if (stream[at - 1] == 0 && stream[at - 2] == 0) return at - 2;
    i = at + 1;
  }
  return stream.size();
}

std::size_t withoutZeroes(std::span<const std::uint8_t> stream, std::size_t begin, std::size_t end) {
  while (end > begin && stream[end - 1] == 0) --end;
  return end;
}

}  // namespace

std::vector<Nal> nalsOf(std::span<const std::uint8_t> stream) {
  std::vector<Nal> nals;
  for (std::size_t start = nextStart(stream, 0); start < stream.size();) {
    const std::size_t begin = start + 3;
    const std::size_t next = nextStart(stream, begin);
    const std::size_t end = withoutZeroes(stream, begin, next);
    if (end > begin) nals.push_back({stream.subspan(begin, end - begin)});
    start = next;
  }
  return nals;
}

bool firstNal(std::span<const std::uint8_t> stream, Nal& nal, std::size_t& end) {
  if (stream.size() < 4) return false;
  const std::size_t zeroes = stream[2] == 0 ? 3 : 2;
  for (std::size_t i = 0; i < zeroes; ++i)
    if (stream[i] != 0) return false;
  if (stream[zeroes] != 1) return false;
  const std::size_t begin = zeroes + 1;
  end = withoutZeroes(stream, begin, nextStart(stream, begin));
  if (end == begin) return false;
  nal.bytes = stream.subspan(begin, end - begin);
  return true;
}

std::vector<std::uint8_t> withLongStartCodes(std::span<const std::uint8_t> stream) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(stream.size() + 16);
  for (const Nal& nal : nalsOf(stream)) {
    bytes.insert(bytes.end(), {0, 0, 0, 1});
    bytes.insert(bytes.end(), nal.bytes.begin(), nal.bytes.end());
  }
  return bytes;
}

std::vector<std::uint8_t> escape(std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(payload.size() + payload.size() / 2);
  std::size_t zeroes = 0;
  for (const std::uint8_t byte : payload) {
    if (zeroes >= 2 && byte <= 3) {
      bytes.push_back(3);
      zeroes = 0;
    }
    bytes.push_back(byte);
    zeroes = byte == 0 ? zeroes + 1 : 0;
  }
  return bytes;
}

std::vector<std::uint8_t> unescape(std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> payload;
  payload.reserve(bytes.size());
  std::size_t zeroes = 0;
  for (const std::uint8_t byte : bytes) {
    if (zeroes >= 2 && byte == 3) {
      zeroes = 0;
      continue;
    }
    payload.push_back(byte);
    zeroes = byte == 0 ? zeroes + 1 : 0;
  }
  return payload;
}

}  // namespace tessera
