// Reading GPU buffers back without a stall: copies into mapped memory, and a fence each that says when it is
// there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/gl/objects.hpp"

namespace tessera::gl {

/// A ring of copies of one kind of buffer. Move only; a context must be current to make, use or drop one.
class Readback {
 public:
  Readback() = default;
  /// `slots` copies of `bytes` each, [1, 16].
  Readback(std::size_t bytes, std::size_t slots);
  Readback(Readback&& other) noexcept;
  Readback& operator=(Readback&& other) noexcept;
  Readback(const Readback&) = delete;
  Readback& operator=(const Readback&) = delete;
  ~Readback();

  /// Queues a copy of the first `bytes` of `source`, over the oldest one. Shader writes to it need
  /// GL_BUFFER_UPDATE_BARRIER_BIT before.
  void request(const Buffer& source);
  /// The newest copy that the GPU has finished, valid until `slots - 1` more requests; null before the first.
  /// Never waits.
  [[nodiscard]] const void* latest();

 private:
  struct Slot {
    GLsync fence = nullptr;  // null once it was seen to have passed
    std::uint64_t number = 0;
  };
  void drop();
  Buffer buffer_;
  const std::byte* mapped_ = nullptr;
  std::size_t bytes_ = 0;
  std::vector<Slot> slots_;
  std::uint64_t requested_ = 0;
};

}  // namespace tessera::gl
