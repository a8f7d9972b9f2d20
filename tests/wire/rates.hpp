// What a recorded camera path takes as messages.
#pragma once

#include <string>
#include <vector>

#include "engine/stream/feed.hpp"

namespace tessera::test {

/// A camera path of an engine, as a stream sees it.
struct Recording {
  struct Frame {
    std::vector<wire::VisibleElement> elements;
    std::vector<wire::ObjectTransform> objects;
    wire::Camera camera;
  };
  wire::GeometrySource source;
  std::vector<Frame> frames;
};

/// Bytes of one kind of content: as plain arrays, sent, and by the other codecs (see other_codecs.hpp).
struct Rate {
  double plain = 0.0;
  double sent = 0.0;
  double meshoptimizer = 0.0;
  double octree = 0.0;
  [[nodiscard]] double ratio() const { return sent > 0.0 ? plain / sent : 0.0; }
};

struct Rates {
  Rate vertices;   // 12 bytes a vertex; sent: refinements and deformations too
  Rate vertexIds;  // 4 bytes a vertex; sent: none
  Rate triangles;  // 12 bytes a triangle
  Rate places;     // 4 bytes and 4 for each word, an element that is new or moved
  Rate freed;      // 4 bytes an element
  Rate objects;    // 100 bytes
  Rate first;      // message, whole
  Rate rest;       // of the messages, whole
  std::size_t frames = 0;
  std::uint64_t freshVertices = 0, refinedVertices = 0, freshTriangles = 0, freshElements = 0,
                movedPlaces = 0;
  double largestError = 0.0;  // pixels, of the corners of visible triangles in view
  double encodeMs = 0.0;      // a frame, median
  double decodeMs = 0.0;
  [[nodiscard]] double together() const { return (first.plain + rest.plain) / (first.sent + rest.sent); }
};

/// Encodes, applies to a mirror, and compares every vertex with the source by projection in double.
/// `keepFrames`: see wire::DeltaOptions.
Rates ratesOf(const Recording& recording, std::uint32_t keepFrames);
std::string table(const Rates& rates);

}  // namespace tessera::test
