// What a run asked of the atlas memory, frame by frame: which patch instances were visible, and how large
// each was on the screen. Recorded once, so that allocators can be compared over the same requests without
// rendering.
//
// File, little-endian: "TSREQSTR", u32 version = 1, u32 width, u32 height, u32 patch instances, f64 frames a
// second, u32 frames, u32 length of the scene's name, the name in UTF-8; then for each frame u32 visible
// patches n, u32 compressed bytes, f32 milliseconds of the frame, f32 milliseconds of its memory phases, and
// one Zstandard frame with checksum. It unpacks to 12 n bytes: the bytes of three u32 arrays of n, as twelve
// planes, lowest byte first. The arrays are the ids, each less the one before it, and log2 area and log2
// aspect, each as the bits of its float less those in the last frame that saw this patch (0 before the
// first), zigzag (sign in bit 0).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/result.hpp"
#include "glsl/shared/levels.h"

namespace tessera {

struct RequestHeader {
  std::string scene;        // at most kLongestName bytes
  std::uint32_t width = 0;  // of the picture, pixels, [1, 16384]
  std::uint32_t height = 0;
  std::uint32_t patchInstances = 0;  // ids are below this; at most kMostPatches
  double fps = 0.0;                  // of the camera path, above 0
  static constexpr std::uint32_t kLongestName = 4096;
  static constexpr std::uint32_t kMostPatches = 65535 * 64;  // what RectMemory takes
  bool operator==(const RequestHeader&) const = default;
};

/// One frame's requests.
struct RequestFrame {
  std::vector<std::uint32_t> patches;        // visible patch instances, rising
  std::vector<glsl::PatchMeasure> measures;  // of each of them, before any bias
  float frameMs = 0.0f;                      // of rendering the whole frame; 0 where it was not measured
  float memoryMs = 0.0f;                     // of that, what the memory phases took
};

class RequestStream {
 public:
  RequestStream();
  explicit RequestStream(RequestHeader header);
  RequestStream(RequestStream&&) noexcept;
  RequestStream& operator=(RequestStream&&) noexcept;
  ~RequestStream();

  /// Fails with one line that names the file, the frame and the value, unless every frame can be read. Takes
  /// memory for the file's own bytes, for one frame and for 8 bytes a patch instance.
  static Result<RequestStream> load(const std::filesystem::path& file);
  /// The same of bytes in memory; `name` stands for the file in messages.
  static Result<RequestStream> parse(const std::string& name, const std::vector<std::uint8_t>& bytes);
  Result<void> save(const std::filesystem::path& file) const;
  [[nodiscard]] std::vector<std::uint8_t> bytes() const;

  /// Appends a frame; its patches must rise and lie below the header's patchInstances, and its measures lie
  /// in the ranges of PatchMeasure. Fails otherwise and appends nothing.
  Result<void> add(const RequestFrame& frame);

  [[nodiscard]] const RequestHeader& header() const { return header_; }
  [[nodiscard]] std::size_t frames() const { return frames_.size(); }
  /// The most patches that any frame sees.
  [[nodiscard]] std::uint32_t mostVisible() const;

  /// Reads the frames in order. The stream must outlive it and stay as it is.
  class Reader {
   public:
    explicit Reader(const RequestStream& stream);
    Reader(Reader&&) noexcept;
    ~Reader();
    /// Unpacks the next frame over `frame`, whose memory is reused. Fails past the last one, and on what
    /// load() refuses.
    Result<void> next(RequestFrame& frame);

   private:
    struct State;
    std::unique_ptr<State> s_;
  };

 private:
  struct Entry {
    std::size_t offset = 0;  // in packed_
    std::uint32_t bytes = 0;
    std::uint32_t count = 0;
    float frameMs = 0.0f;
    float memoryMs = 0.0f;
  };
  struct Writer;

  RequestHeader header_;
  std::string name_ = "request stream";
  std::vector<Entry> frames_;
  std::vector<std::uint8_t> packed_;
  std::unique_ptr<Writer> writer_;  // made by the first add()
};

}  // namespace tessera
