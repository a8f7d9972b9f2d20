#include "engine/gl/readback.hpp"

#include <cassert>

namespace tessera::gl {

Readback::Readback(std::size_t bytes, std::size_t slots)
    : buffer_(bytes * slots, GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT),
      bytes_(bytes),
      slots_(slots) {
  assert(slots >= 1 && slots <= 16);
  mapped_ = static_cast<const std::byte*>(
      api().MapNamedBufferRange(buffer_.get(), 0, static_cast<GLsizeiptr>(bytes * slots),
                                GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT));
}

Readback::Readback(Readback&& other) noexcept { *this = std::move(other); }

Readback& Readback::operator=(Readback&& other) noexcept {
  if (this == &other) return *this;
  drop();
  buffer_ = std::move(other.buffer_);
  mapped_ = std::exchange(other.mapped_, nullptr);
  bytes_ = other.bytes_;
  slots_ = std::exchange(other.slots_, {});
  requested_ = std::exchange(other.requested_, 0);
  return *this;
}

Readback::~Readback() { drop(); }

void Readback::drop() {
  for (const Slot& slot : slots_)
    if (slot.fence != nullptr) api().DeleteSync(slot.fence);
  slots_.clear();
}

void Readback::request(const Buffer& source) {
  Slot& slot = slots_[requested_ % slots_.size()];
  if (slot.fence != nullptr) api().DeleteSync(slot.fence);
  api().CopyNamedBufferSubData(source.get(), buffer_.get(), 0,
                               static_cast<GLintptr>(requested_ % slots_.size() * bytes_),
                               static_cast<GLsizeiptr>(bytes_));
  slot.number = ++requested_;
  slot.fence = api().FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
}

const void* Readback::latest() {
  const Slot* newest = nullptr;
  for (Slot& slot : slots_) {
    if (slot.number == 0) continue;
    if (slot.fence != nullptr) {
      const GLenum status = api().ClientWaitSync(slot.fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0);
      if (status != GL_ALREADY_SIGNALED && status != GL_CONDITION_SATISFIED) continue;
      api().DeleteSync(slot.fence);
      slot.fence = nullptr;
    }
    if (newest == nullptr || slot.number > newest->number) newest = &slot;
  }
  if (newest == nullptr || mapped_ == nullptr) return nullptr;
  return mapped_ + (newest->number - 1) % slots_.size() * bytes_;
}

}  // namespace tessera::gl
