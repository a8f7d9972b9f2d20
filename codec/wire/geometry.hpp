// What a server knows of the geometry that it may send, what it says of a frame, and what a viewer draws
// from. Plain structs: neither side's library is needed to fill or read them. What the viewer's shaders read
// is in glsl/shared/streamed.h.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "glsl/shared/streamed.h"

namespace tessera::wire {

/// Which gatherer fills the atlas, and so what an element's words mean.
enum class Method : std::uint8_t {
  Rect = 1,  // an element is a patch of 1 to 3 triangles; words: origin, level
  Tess = 2   // an element is a triangle, or a piece of one; words: kind, size, form, place0, place1, piece
};
inline constexpr std::size_t kMostWords = 6;
constexpr std::size_t wordsOf(Method method) { return method == Method::Rect ? 2 : 6; }

inline constexpr std::uint32_t kNone = 0xffffffffu;

// Limits of a stream. A message beyond them is refused.
inline constexpr std::uint32_t kMostVertices = 1u << 22;
inline constexpr std::uint32_t kMostElements = 1u << 21;
inline constexpr std::uint32_t kMostObjects = 1u << 16;
/// Texels of a mask per unit of its coordinates, and the largest coordinate.
inline constexpr float kMaskGrid = 16384.0f;
inline constexpr float kMostMaskCoordinate = 4096.0f;

/// A vertex that may be sent. Vertices at one place of one object should be one: they are sent once, and
/// triangles around them cannot come apart. A vertex of masked triangles is one with its mask coordinates.
struct SourceVertex {
  glm::vec3 position{0.0f};  // in its object's space; each below 2^60
  std::uint32_t object = 0;  // below kMostObjects
  glm::vec2 mask{0.0f};      // texture coordinates of the mask; sent for vertices of masked elements only
};

/// A patch or a triangle that may become visible. Corners as PatchGeometry in glsl/shared/scene.h.
struct SourceElement {
  std::array<std::uint32_t, 5> vertex{};  // triangles + 2 of them are used
  std::uint8_t triangles = 0;             // 1 to 3 of a patch; 1 of a triangle; 0: there is no such element
  bool mirrored = false;                  // its triangles are clockwise in the world as they stand
  std::uint32_t style = 0;                // see kStyle... in glsl/shared/streamed.h
};

/// Element ids are places in `elements`; ids beyond those are pieces of split triangles (Method::Tess).
struct GeometrySource {
  Method method = Method::Rect;
  std::vector<SourceVertex> vertices;
  std::vector<SourceElement> elements;
};

/// An element that is visible in a frame, and its place in the atlas.
struct VisibleElement {
  std::uint32_t id = 0;
  std::array<std::uint32_t, kMostWords> words{};
  std::uint32_t parent = kNone;  // of a piece: the id of its triangle, which is visible too
};

/// Affine and finite, from the object's space to the world's.
struct ObjectTransform {
  glm::dmat4x3 world{1.0};
  bool operator==(const ObjectTransform&) const = default;
};

/// A camera as both sides name it.
struct Camera {
  glm::dvec3 eye{0.0};                         // world
  glm::dvec4 orientation{0.0, 0.0, 0.0, 1.0};  // unit quaternion, xyz and w; turns -z into the view direction
  glm::dvec4 slopes{-1.0, 1.0, -1.0, 1.0};     // left, right, bottom, top edge of the picture at distance 1
  double zNear = 0.05;                         // > 0; depth is reversed, without a far plane
  std::uint32_t width = 1280;                  // pixels
  std::uint32_t height = 720;
};
/// What a server draws for a viewer. Slopes are even to both sides and fit square pixels.
inline constexpr std::uint32_t kMostViewSide = 8192;
inline constexpr std::uint32_t kMostViewPixels = 1u << 24;
inline constexpr double kLeastSlope = 1e-3;
inline constexpr double kMostSlope = 11.0;  // 85 degrees off the axis

/// Entries of an array that changed: [first, last).
struct DirtyRange {
  std::uint32_t first = 0xffffffffu;
  std::uint32_t last = 0;
  void add(std::uint32_t entry) {
    if (entry < first) first = entry;
    if (entry >= last) last = entry + 1;
  }
  [[nodiscard]] bool empty() const { return first >= last; }
};

}  // namespace tessera::wire
