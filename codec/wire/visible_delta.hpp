// The server's end of a geometry stream: from what is visible in a frame to the message that tells a viewer
// what is new.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codec/wire/geometry.hpp"
#include "codec/wire/pixel_bound.hpp"

namespace tessera::wire {

/// What is visible in a frame.
struct VisibleFrame {
  std::span<const VisibleElement> elements;  // in any order, each id once
  std::span<const ObjectTransform> objects;  // by object number; as many as the vertices name
  std::span<const std::uint32_t> deformed =
      {};  // vertices of the source whose position changed since the last frame
  PixelBound bound;
  glm::dvec3 eye{0.0};  // that `bound` is for
};

struct DeltaOptions {
  /// Levels that vertices are sent finer than their bound asks for, [0, 8]: with 1 they are sent again when
  /// the eye has come to half the distance.
  int headroom = 1;
  /// How long a viewer remembers what has gone out of sight, so that only its place is sent when it comes
  /// back; 0: not at all. Elements at silhouettes, and those smaller than a pixel, come and go all the time.
  std::uint32_t keepFrames = 60;
  /// Elements remembered at most.
  std::uint32_t keepMost = 1u << 17;
};

/// What a message holds, and how many bits of it each part takes.
struct DeltaStatistics {
  std::uint32_t freshElements = 0;
  std::uint32_t freshTriangles = 0;
  std::uint32_t freshVertices = 0;
  std::uint32_t movedPlaces = 0;
  std::uint32_t refinedVertices = 0;   // sent again for a finer grid
  std::uint32_t deformedVertices = 0;  // for another position
  std::uint32_t freedElements = 0;
  std::uint32_t hiddenElements = 0;  // gone, but remembered
  std::uint32_t shownElements = 0;   // of moved places: those that were remembered
  std::uint32_t objects = 0;
  double vertexBits = 0.0;    // fresh, refined and deformed positions
  double triangleBits = 0.0;  // corners and styles
  double placeBits = 0.0;     // fresh and moved
  double freedBits = 0.0;     // and hidden
  double objectBits = 0.0;
  std::size_t bytes = 0;  // of the message
};

/// One a viewer: it knows what that viewer has. The first message of a new one holds everything.
class VisibleDelta {
 public:
  /// `source` must outlive this.
  explicit VisibleDelta(const GeometrySource& source, const DeltaOptions& options = {});
  ~VisibleDelta();
  VisibleDelta(VisibleDelta&&) noexcept;
  VisibleDelta& operator=(VisibleDelta&&) noexcept;

  /// The geometry message of the next frame. An id out of the source's range or given twice, a piece without
  /// its triangle, and a vertex without its object are the caller's bugs.
  std::vector<std::uint8_t> next(const VisibleFrame& frame);
  [[nodiscard]] const DeltaStatistics& statistics() const;

 private:
  struct State;
  std::unique_ptr<State> s_;
};

}  // namespace tessera::wire
