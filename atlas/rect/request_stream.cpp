#include "atlas/rect/request_stream.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <string_view>
#include <zstd.h>

#include "engine/core/file.hpp"

namespace tessera {

namespace {

static_assert(std::endian::native == std::endian::little, "the file's numbers are copied as they are");

constexpr std::string_view kMagic = "TSREQSTR";
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kLargestSide = 16384;
constexpr std::size_t kHeaderBytes = 40;  // without the scene's name
constexpr std::size_t kEntryBytes = 16;   // without the packed frame
constexpr std::size_t kBytesAPatch = 12;
constexpr int kCompression = 6;
constexpr float kLargestLogArea = 100.0f;
constexpr float kLargestLogAspect = 20.0f;

std::uint32_t zigzag(std::uint32_t difference) { return (difference << 1U) ^ (0U - (difference >> 31U)); }
std::uint32_t unzigzag(std::uint32_t value) { return (value >> 1U) ^ (0U - (value & 1U)); }

/// The bits of a measure.
struct MeasureBits {
  std::uint32_t area = 0;
  std::uint32_t aspect = 0;
};

/// An array of u32 as four planes of bytes, at `planes`.
class Planes {
 public:
  Planes(std::uint8_t* bytes, std::size_t count) : bytes_(bytes), count_(count) {}
  void put(std::size_t i, std::uint32_t value) {
    for (std::size_t b = 0; b < 4; ++b) bytes_[b * count_ + i] = static_cast<std::uint8_t>(value >> (8 * b));
  }
  [[nodiscard]] std::uint32_t get(std::size_t i) const {
    std::uint32_t value = 0;
    for (std::size_t b = 0; b < 4; ++b) value |= std::uint32_t{bytes_[b * count_ + i]} << (8 * b);
    return value;
  }

 private:
  std::uint8_t* bytes_;
  std::size_t count_;
};

struct FrameRoom {
  std::vector<std::uint8_t> raw;
  std::vector<MeasureBits> last;  // of each patch instance
  explicit FrameRoom(std::uint32_t patchInstances) : last(patchInstances) {}
  /// The three arrays of a frame of `count` patches.
  std::array<Planes, 3> arrays(std::size_t count) {
    raw.resize(kBytesAPatch * count);
    return {Planes(raw.data(), count), Planes(raw.data() + 4 * count, count),
            Planes(raw.data() + 8 * count, count)};
  }
};

Result<void> checkHeader(const std::string& name, const RequestHeader& header) {
  if (header.scene.size() > RequestHeader::kLongestName)
    return fail("{}: a scene name of {} bytes is longer than {}", name, header.scene.size(),
                RequestHeader::kLongestName);
  for (const std::uint32_t side : {header.width, header.height})
    if (side < 1 || side > kLargestSide)
      return fail("{}: pictures of {} x {} pixels are not within 1 to {} a side", name, header.width,
                  header.height, kLargestSide);
  if (header.patchInstances > RequestHeader::kMostPatches)
    return fail("{}: {} patch instances are more than {}", name, header.patchInstances,
                RequestHeader::kMostPatches);
  if (!std::isfinite(header.fps) || header.fps <= 0.0)
    return fail("{}: {} frames a second", name, header.fps);
  return {};
}

Result<void> checkPatch(const std::string& name, std::size_t frame, std::size_t i, std::uint32_t patch,
                        std::uint32_t patchInstances, const glsl::PatchMeasure& measure) {
  if (patch >= patchInstances)
    return fail("{}: frame {}: visible patch {} is instance {} of {}", name, frame, i, patch, patchInstances);
  // Written so that NaN fails.
  if (!(std::abs(measure.logArea) <= kLargestLogArea))
    return fail("{}: frame {}: instance {} has log2 area {}, not in [-{}, {}]", name, frame, patch,
                measure.logArea, kLargestLogArea, kLargestLogArea);
  if (!(std::abs(measure.logAspect) <= kLargestLogAspect))
    return fail("{}: frame {}: instance {} has log2 aspect {}, not in [-{}, {}]", name, frame, patch,
                measure.logAspect, kLargestLogAspect, kLargestLogAspect);
  return {};
}

Result<void> checkTimes(const std::string& name, std::size_t frame, float frameMs, float memoryMs) {
  for (const float ms : {frameMs, memoryMs})
    if (!std::isfinite(ms) || ms < 0.0f) return fail("{}: frame {}: a time of {} ms", name, frame, ms);
  return {};
}

/// Reads numbers off the front of bytes; a read past the end gives nothing.
class Front {
 public:
  explicit Front(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  template <class T>
  bool take(T& value) {
    const auto from = takeBytes(sizeof(T));
    if (from.size() != sizeof(T)) return false;
    std::memcpy(&value, from.data(), sizeof(T));
    return true;
  }
  /// The next `count` bytes, or none when there are not as many.
  std::span<const std::uint8_t> takeBytes(std::size_t count) {
    if (count > bytes_.size()) return {};
    const auto taken = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return taken;
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// Writes numbers one behind the other into bytes that have room for them.
class Back {
 public:
  explicit Back(std::uint8_t* at) : at_(at) {}
  void put(const void* bytes, std::size_t count) {
    if (count > 0) std::memcpy(at_, bytes, count);
    at_ += count;
  }
  template <class T>
  void put(const T& value) {
    put(&value, sizeof(T));
  }

 private:
  std::uint8_t* at_;
};

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

}  // namespace

struct RequestStream::Writer {
  FrameRoom room;
  std::unique_ptr<ZSTD_CCtx, FreeContext> zstd{ZSTD_createCCtx()};
  explicit Writer(std::uint32_t patchInstances) : room(patchInstances) {
    ZSTD_CCtx_setParameter(zstd.get(), ZSTD_c_compressionLevel, kCompression);
    ZSTD_CCtx_setParameter(zstd.get(), ZSTD_c_checksumFlag, 1);
  }
};

struct RequestStream::Reader::State {
  const RequestStream& stream;
  FrameRoom room;
  std::size_t next = 0;
  std::unique_ptr<ZSTD_DCtx, FreeContext> zstd{ZSTD_createDCtx()};
  explicit State(const RequestStream& of) : stream(of), room(of.header_.patchInstances) {}
};

RequestStream::RequestStream() = default;
RequestStream::RequestStream(RequestHeader header) : header_(std::move(header)) {}
RequestStream::RequestStream(RequestStream&&) noexcept = default;
RequestStream& RequestStream::operator=(RequestStream&&) noexcept = default;
RequestStream::~RequestStream() = default;

std::uint32_t RequestStream::mostVisible() const {
  std::uint32_t most = 0;
  for (const Entry& entry : frames_) most = std::max(most, entry.count);
  return most;
}

Result<void> RequestStream::add(const RequestFrame& frame) {
  const std::size_t number = frames_.size();
  const std::size_t count = frame.patches.size();
  if (auto good = checkHeader(name_, header_); !good) return good;
  if (frame.measures.size() != count)
    return fail("{}: frame {}: {} measures of {} patches", name_, number, frame.measures.size(), count);
  if (auto good = checkTimes(name_, number, frame.frameMs, frame.memoryMs); !good) return good;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && frame.patches[i] <= frame.patches[i - 1])
      return fail("{}: frame {}: instance {} after {}", name_, number, frame.patches[i],
                  frame.patches[i - 1]);
    if (auto good = checkPatch(name_, number, i, frame.patches[i], header_.patchInstances, frame.measures[i]);
        !good)
      return good;
  }
  if (!writer_ && number > 0) return fail("{}: was loaded, and a loaded stream does not grow", name_);
  if (!writer_) writer_ = std::make_unique<Writer>(header_.patchInstances);
  auto [ids, areas, aspects] = writer_->room.arrays(count);
  std::uint32_t before = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t patch = frame.patches[i];
    ids.put(i, patch - before);
    before = patch;
    MeasureBits& last = writer_->room.last[patch];
    const auto bits = std::bit_cast<MeasureBits>(frame.measures[i]);
    areas.put(i, zigzag(bits.area - last.area));
    aspects.put(i, zigzag(bits.aspect - last.aspect));
    last = bits;
  }
  const auto& raw = writer_->room.raw;
  const std::size_t offset = packed_.size();
  const std::size_t bound = ZSTD_compressBound(raw.size());
  packed_.resize(offset + bound);
  const std::size_t bytes =
      ZSTD_compress2(writer_->zstd.get(), packed_.data() + offset, bound, raw.data(), raw.size());
  const bool failed = ZSTD_isError(bytes) != 0;
  packed_.resize(failed ? offset : offset + bytes);
  if (failed) return fail("{}: frame {}: cannot be compressed ({})", name_, number, ZSTD_getErrorName(bytes));
  frames_.push_back({offset, static_cast<std::uint32_t>(bytes), static_cast<std::uint32_t>(count),
                     frame.frameMs, frame.memoryMs});
  return {};
}

std::vector<std::uint8_t> RequestStream::bytes() const {
  std::vector<std::uint8_t> out(kHeaderBytes + header_.scene.size() + kEntryBytes * frames_.size() +
                                packed_.size());
  Back back(out.data());
  back.put(kMagic.data(), kMagic.size());
  back.put(kVersion);
  back.put(header_.width);
  back.put(header_.height);
  back.put(header_.patchInstances);
  back.put(header_.fps);
  back.put(static_cast<std::uint32_t>(frames_.size()));
  back.put(static_cast<std::uint32_t>(header_.scene.size()));
  back.put(header_.scene.data(), header_.scene.size());
  for (const Entry& entry : frames_) {
    back.put(entry.count);
    back.put(entry.bytes);
    back.put(entry.frameMs);
    back.put(entry.memoryMs);
    back.put(packed_.data() + entry.offset, entry.bytes);
  }
  return out;
}

Result<void> RequestStream::save(const std::filesystem::path& file) const {
  return writeFile(file, std::span<const std::uint8_t>(bytes()));
}

Result<RequestStream> RequestStream::load(const std::filesystem::path& file) {
  auto bytes = readFile(file);
  if (!bytes) return tl::unexpected(bytes.error());
  return parse(file.string(), *bytes);
}

Result<RequestStream> RequestStream::parse(const std::string& name, const std::vector<std::uint8_t>& bytes) {
  Front front(bytes);
  const auto magic = front.takeBytes(kMagic.size());
  if (magic.empty() || std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0)
    return fail("{}: not a request stream", name);
  std::uint32_t version = 0;
  if (!front.take(version)) return fail("{}: ends within its header", name);
  if (version != kVersion) return fail("{}: version {}, this reads version {}", name, version, kVersion);
  RequestStream stream;
  RequestHeader& header = stream.header_;
  stream.name_ = name;
  std::uint32_t frames = 0;
  std::uint32_t nameLength = 0;
  if (!front.take(header.width) || !front.take(header.height) || !front.take(header.patchInstances) ||
      !front.take(header.fps) || !front.take(frames) || !front.take(nameLength))
    return fail("{}: ends within its header", name);
  if (nameLength > RequestHeader::kLongestName || nameLength > front.left())
    return fail("{}: a scene name of {} bytes is longer than {} or than the file", name, nameLength,
                RequestHeader::kLongestName);
  const auto scene = front.takeBytes(nameLength);
  header.scene.assign(scene.begin(), scene.end());
  if (auto good = checkHeader(name, header); !good) return tl::unexpected(good.error());
  if (frames > front.left() / kEntryBytes)
    return fail("{}: {} frames do not fit into the {} bytes after the header", name, frames, front.left());
  stream.frames_.reserve(frames);
  stream.packed_.reserve(front.left() - kEntryBytes * frames);
  for (std::uint32_t f = 0; f < frames; ++f) {
    Entry entry;
    if (!front.take(entry.count) || !front.take(entry.bytes) || !front.take(entry.frameMs) ||
        !front.take(entry.memoryMs))
      return fail("{}: frame {} of {}: the file ends here", name, f, frames);
    if (entry.count > header.patchInstances)
      return fail("{}: frame {}: {} visible patches of {}", name, f, entry.count, header.patchInstances);
    if (auto good = checkTimes(name, f, entry.frameMs, entry.memoryMs); !good)
      return tl::unexpected(good.error());
    if (entry.bytes > front.left())
      return fail("{}: frame {}: {} bytes, and only {} are left in the file", name, f, entry.bytes,
                  front.left());
    entry.offset = stream.packed_.size();
    const auto packed = front.takeBytes(entry.bytes);
    stream.packed_.insert(stream.packed_.end(), packed.begin(), packed.end());
    stream.frames_.push_back(entry);
  }
  if (front.left() > 0) return fail("{}: {} bytes after the last frame", name, front.left());
  Reader reader(stream);
  RequestFrame frame;
  for (std::uint32_t f = 0; f < frames; ++f)
    if (auto read = reader.next(frame); !read) return tl::unexpected(read.error());
  return stream;
}

RequestStream::Reader::Reader(const RequestStream& stream) : s_(std::make_unique<State>(stream)) {}
RequestStream::Reader::Reader(Reader&&) noexcept = default;
RequestStream::Reader::~Reader() = default;

Result<void> RequestStream::Reader::next(RequestFrame& frame) {
  State& s = *s_;
  const RequestStream& stream = s.stream;
  const std::string& name = stream.name_;
  const std::size_t number = s.next;
  if (number >= stream.frames_.size()) return fail("{}: has {} frames", name, stream.frames_.size());
  ++s.next;
  const Entry& entry = stream.frames_[number];
  const std::uint8_t* packed = stream.packed_.data() + entry.offset;
  const std::size_t count = entry.count;
  auto [ids, areas, aspects] = s.room.arrays(count);
  const std::size_t wanted = s.room.raw.size();
  const unsigned long long said = ZSTD_getFrameContentSize(packed, entry.bytes);
  if (said != wanted)
    return fail("{}: frame {}: its {} bytes do not hold {} patches", name, number, entry.bytes, count);
  // Where nothing is wanted zstd still checks the frame, but not against a null destination.
  std::uint8_t nothing = 0;
  const std::size_t got = ZSTD_decompressDCtx(s.zstd.get(), wanted > 0 ? s.room.raw.data() : &nothing, wanted,
                                              packed, entry.bytes);
  if (ZSTD_isError(got) != 0)
    return fail("{}: frame {}: {} bytes cannot be unpacked ({})", name, number, entry.bytes,
                ZSTD_getErrorName(got));
  if (got != wanted) return fail("{}: frame {}: unpacks to {} bytes, not {}", name, number, got, wanted);
  frame.patches.resize(count);
  frame.measures.resize(count);
  frame.frameMs = entry.frameMs;
  frame.memoryMs = entry.memoryMs;
  std::uint64_t patch = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t step = ids.get(i);
    if (i > 0 && step == 0) return fail("{}: frame {}: instance {} twice", name, number, patch);
    patch += step;
    if (patch >= s.room.last.size())
      return fail("{}: frame {}: visible patch {} is instance {} of {}", name, number, i, patch,
                  s.room.last.size());
    MeasureBits& last = s.room.last[patch];
    last.area += unzigzag(areas.get(i));
    last.aspect += unzigzag(aspects.get(i));
    frame.patches[i] = static_cast<std::uint32_t>(patch);
    frame.measures[i] = std::bit_cast<glsl::PatchMeasure>(last);
    if (auto good =
            checkPatch(name, number, i, frame.patches[i], stream.header_.patchInstances, frame.measures[i]);
        !good)
      return good;
  }
  return {};
}

}  // namespace tessera
