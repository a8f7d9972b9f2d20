// The host's own drawing: rectangles of colour. It sets its state once and trusts that nobody disturbs it.
#pragma once

#include <array>

#include "host.hpp"
#include "rectangle.hpp"

namespace embed {

using Color = std::array<float, 4>;  // as stored, [0, 1]; alpha is coverage

class Painter {
 public:
  static Result<Painter> create(const Host& host);
  Painter(Painter&& other) noexcept;
  Painter& operator=(Painter&&) = delete;
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;
  ~Painter();

  /// Blended over what is there, from `bottom` to `top`.
  void fill(const Rectangle& where, const Color& bottom, const Color& top) const;
  void fill(const Rectangle& where, const Color& color) const { fill(where, color, color); }
  /// A frame of `thickness` pixels along the inside of `where`.
  void frame(const Rectangle& where, int thickness, const Color& color) const;

 private:
  explicit Painter(const Host& host) : host_(&host) {}
  const Host* host_;
  GLuint program_ = 0;
  GLuint vertexArray_ = 0;
};

}  // namespace embed
