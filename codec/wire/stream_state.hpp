// What the two ends of a stream know alike after each message: which numbers are in use, and for what.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "codec/wire/geometry_models.hpp"
#include "codec/wire/slots.hpp"

namespace tessera::wire {

struct StreamedVertexState {
  glm::ivec3 steps{0};  // position in steps of 2^level
  int level = 0;
  std::uint32_t object = 0;
  std::uint32_t elements = 0;  // that use it
  glm::ivec2 mask{0};          // mask coordinates in steps of 1 / kMaskGrid
};

struct StreamedElementState {
  std::array<std::uint32_t, kMostWords> words{};
  std::array<std::uint32_t, 5> vertex{};
  std::array<std::uint32_t, 3> triangle{};
  std::uint32_t style = 0;
  std::uint32_t parent = kNone;  // number of the element that this is a piece of
  std::uint32_t pieces = 0;      // elements that are pieces of this one
  std::uint8_t triangles = 0;    // 0 of a piece
  bool mirrored = false;
  bool hidden = false;  // out of sight, but remembered
  [[nodiscard]] std::size_t corners() const { return triangles == 0 ? 0 : std::size_t{triangles} + 2; }
};

struct StreamState {
  GeometryModels models;
  SlotPool vertexSlots;
  SlotPool triangleSlots;
  SlotPool elementSlots;
  std::vector<StreamedVertexState> vertices;
  std::vector<StreamedElementState> elements;

  std::uint32_t takeVertex() {
    const std::uint32_t slot = vertexSlots.take();
    if (slot == vertices.size()) vertices.emplace_back();
    vertices[slot] = {};
    return slot;
  }
  /// With numbers for its triangles.
  std::uint32_t takeElement(std::uint8_t triangles) {
    const std::uint32_t slot = elementSlots.take();
    if (slot == elements.size()) elements.emplace_back();
    elements[slot] = {};
    elements[slot].triangles = triangles;
    for (std::uint8_t i = 0; i < triangles; ++i) elements[slot].triangle[i] = triangleSlots.take();
    return slot;
  }
  /// Calls freed(vertex) for those of its vertices that no element uses any more.
  template <class Freed>
  void giveElement(std::uint32_t slot, Freed&& freed) {
    StreamedElementState& element = elements[slot];
    for (std::uint8_t i = 0; i < element.triangles; ++i) triangleSlots.give(element.triangle[i]);
    for (std::size_t i = 0; i < element.corners(); ++i) {
      const std::uint32_t vertex = element.vertex[i];
      if (--vertices[vertex].elements > 0) continue;
      vertexSlots.give(vertex);
      freed(vertex);
    }
    if (element.parent != kNone) --elements[element.parent].pieces;
    elementSlots.give(slot);
  }
  [[nodiscard]] glm::dvec3 positionOf(std::uint32_t vertex) const {
    const StreamedVertexState& v = vertices[vertex];
    return {std::ldexp(double(v.steps.x), v.level), std::ldexp(double(v.steps.y), v.level),
            std::ldexp(double(v.steps.z), v.level)};
  }
};

}  // namespace tessera::wire
