#include "engine/gl/readback.hpp"

#include <cassert>

namespace tessera::gl {

Readback::Readback(std::size_t bytes, std::size_t slots)
    : buffer_(bytes * slots, GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT),
      bytes_(bytes),
      slots_(slots) {
  assert(slots >= 2 && slots <= 16);
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
  newest_ = std::exchange(other.newest_, std::nullopt);
  return *this;
}

Readback::~Readback() { drop(); }

void Readback::drop() {
  for (const Slot& slot : slots_)
    if (slot.fence != nullptr) api().DeleteSync(slot.fence);
  slots_.clear();
}

void Readback::look(GLbitfield flags) {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    if (slot.fence == nullptr) continue;
    const GLenum status = api().ClientWaitSync(slot.fence, flags, 0);
    if (status != GL_ALREADY_SIGNALED && status != GL_CONDITION_SATISFIED) continue;
    api().DeleteSync(slot.fence);
    slot.fence = nullptr;
    if (!newest_ || slot.number > slots_[*newest_].number) newest_ = i;
  }
}

void Readback::request(const Buffer& source) {
  look(0);
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slots_[i].fence != nullptr || newest_ == i) continue;
    api().CopyNamedBufferSubData(source.get(), buffer_.get(), 0, static_cast<GLintptr>(i * bytes_),
                                 static_cast<GLsizeiptr>(bytes_));
    slots_[i] = {api().FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0), ++requested_};
    return;
  }
}

const void* Readback::latest() {
  look(GL_SYNC_FLUSH_COMMANDS_BIT);
  return newest_ && mapped_ != nullptr ? mapped_ + *newest_ * bytes_ : nullptr;
}

}  // namespace tessera::gl
