// Reading GPU buffers back without a stall: copies into mapped memory, and a fence each that says when it is
// there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/gl/objects.hpp"

namespace tessera::gl {

/// A ring of copies of one kind of buffer. Move only; a context must be current to make, use or drop one.
class Readback {
 public:
  Readback() = default;
  /// `slots` copies of `bytes` each, [2, 16]: the newest that arrived, and those under way.
  Readback(std::size_t bytes, std::size_t slots);
  Readback(Readback&& other) noexcept;
  Readback& operator=(Readback&& other) noexcept;
  Readback(const Readback&) = delete;
  Readback& operator=(const Readback&) = delete;
  ~Readback();

  /// Queues a copy of the first `bytes` of `source`. Does nothing while every slot holds a copy under way, or
  /// the newest that has arrived: however far the GPU is behind, copies arrive. Shader writes to `source`
  /// need GL_BUFFER_UPDATE_BARRIER_BIT before.
  void request(const Buffer& source);
  /// The newest copy that has arrived, valid until the next request; null before the first has. Never waits.
  [[nodiscard]] const void* latest();

 private:
  struct Slot {
    GLsync fence = nullptr;    // null once it was seen to have passed
    std::uint64_t number = 0;  // of the request, from 1; 0 before the first
  };
  void drop();
  void look(GLbitfield flags);
  Buffer buffer_;
  const std::byte* mapped_ = nullptr;
  std::size_t bytes_ = 0;
  std::vector<Slot> slots_;
  std::uint64_t requested_ = 0;
  std::optional<std::size_t> newest_;  // slot of the newest copy that has arrived
};

}  // namespace tessera::gl
