// The viewer's end of a geometry stream: what it was sent, as arrays that a viewer uploads and draws from.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codec/wire/geometry.hpp"
#include "engine/core/result.hpp"

namespace tessera::wire {

/// Texels of the atlas texture. Places outside of it are refused.
struct AtlasSize {
  std::uint32_t width = 0;   // [1, 32767]
  std::uint32_t height = 0;  // [1, 65535]
};

/// What apply() changed, for each array. An array only grows.
struct DirtyRanges {
  DirtyRange vertices;
  DirtyRange triangles;
  DirtyRange elements;
  DirtyRange pieces;
  DirtyRange objects;
};

/// One a connection. Arrays are dense but for free entries: a free triangle has no area and kNoOwner, of
/// other free entries nothing is said.
class VisibleMirror {
 public:
  VisibleMirror(Method method, AtlasSize atlas);
  ~VisibleMirror();
  VisibleMirror(VisibleMirror&&) noexcept;
  VisibleMirror& operator=(VisibleMirror&&) noexcept;

  /// Applies one geometry message, whole. Any bytes may be given: what is not a message, or names what is not
  /// there, is an error that says what and which. After an error the stream is lost; further calls fail, and
  /// the arrays stay safe to draw.
  Result<DirtyRanges> apply(std::span<const std::uint8_t> message);

  [[nodiscard]] Method method() const;
  [[nodiscard]] std::span<const glsl::StreamedVertex> vertices() const;
  /// As vertices(): texture coordinates of their mask; 0 of vertices that no masked element has.
  [[nodiscard]] std::span<const glm::vec2> maskCoordinates() const;
  [[nodiscard]] std::span<const glsl::StreamedTriangle> triangles() const;
  /// Of Method::Rect, else empty.
  [[nodiscard]] std::span<const glsl::StreamedPatch> patches() const;
  /// Of Method::Tess, else empty.
  [[nodiscard]] std::span<const glsl::StreamedTess> tess() const;
  /// Elements that are pieces, kSplitBlock for each split triangle by their index in it; kNone where there is
  /// none.
  [[nodiscard]] std::span<const std::uint32_t> pieces() const;
  [[nodiscard]] std::span<const ObjectTransform> objects() const;

  [[nodiscard]] std::uint32_t liveVertices() const;
  [[nodiscard]] std::uint32_t liveTriangles() const;
  [[nodiscard]] std::uint32_t liveElements() const;

 private:
  struct State;
  std::unique_ptr<State> s_;
};

}  // namespace tessera::wire
