// A visible set made by a test instead of an id buffer.
#pragma once

#include <span>
#include <vector>

#include "engine/gl/objects.hpp"
#include "glsl/shared/bindings.h"

namespace tessera::test {

class VisibleFeed {
 public:
  explicit VisibleFeed(std::uint32_t elements)
      : elements_(elements),
        list_(4 * (std::size_t{elements} + 1)),
        marks_(4 * std::size_t{elements}),
        dispatch_(12) {}

  /// A new frame, in which these are visible: uploads the list and binds it.
  void see(std::span<const std::uint32_t> visible) {
    ++frame_;
    std::vector<std::uint32_t> list = {static_cast<std::uint32_t>(visible.size())};
    list.insert(list.end(), visible.begin(), visible.end());
    std::vector<std::uint32_t> marks = marks_.readAll<std::uint32_t>(elements_);
    for (const std::uint32_t element : visible) marks[element] = frame_;
    list_.write(std::span<const std::uint32_t>(list));
    marks_.write(std::span<const std::uint32_t>(marks));
    constexpr std::size_t kGroup = 64;  // see visible_finish.comp
    const std::vector<std::uint32_t> groups = {
        static_cast<std::uint32_t>((visible.size() + kGroup - 1) / kGroup), 1, 1};
    dispatch_.write(std::span<const std::uint32_t>(groups));
    list_.bindStorage(BIND_VISIBLE);
    marks_.bindStorage(BIND_VISIBLE_MARK);
  }
  [[nodiscard]] const gl::Buffer& dispatch() const { return dispatch_; }
  [[nodiscard]] std::uint32_t frame() const { return frame_; }

 private:
  std::uint32_t elements_;
  std::uint32_t frame_ = 0;
  gl::Buffer list_;
  gl::Buffer marks_;
  gl::Buffer dispatch_;
};

}  // namespace tessera::test
