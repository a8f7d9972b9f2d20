// The byte stream of H.264 (ITU-T H.264, 08/2021, annex B): units between start codes, and the bytes that
// keep start codes out of a unit's payload.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

/// nal_unit_type, table 7-1.
enum class NalType : std::uint8_t { Slice = 1, IdrSlice = 5, Sei = 6, SequenceSet = 7, PictureSet = 8 };

/// A unit without its start code: one byte of header, then its payload. Never empty.
struct Nal {
  std::span<const std::uint8_t> bytes;
  [[nodiscard]] NalType type() const { return static_cast<NalType>(bytes[0] & 31U); }
};

/// The units of a stream in order; borrowed from it. Bytes before the first start code belong to none. Zeroes
/// that trail a unit are not part of it.
std::vector<Nal> nalsOf(std::span<const std::uint8_t> stream);
/// The first of them alone, without a search through the rest; `end` is where its bytes end in the stream.
/// Nothing where the stream does not begin with a start code (00 00 01 or 00 00 00 01) and a byte.
bool firstNal(std::span<const std::uint8_t> stream, Nal& nal, std::size_t& end);

/// The same units, each behind the long start code 00 00 00 01 and without trailing zeroes. A transport that
/// carries units alone (RTP) gives a stream back in this form: what is checked byte for byte must have it
/// before.
std::vector<std::uint8_t> withLongStartCodes(std::span<const std::uint8_t> stream);

/// A payload with 03 put in where two zeroes are followed by 0 to 3 (sec. 7.4.1), and the payload of such
/// bytes.
std::vector<std::uint8_t> escape(std::span<const std::uint8_t> payload);
std::vector<std::uint8_t> unescape(std::span<const std::uint8_t> bytes);

}  // namespace tessera
