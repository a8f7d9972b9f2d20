#include "codec/wire/visible_mirror.hpp"

#include <cmath>

#include "codec/wire/geometry_coding.hpp"
#include "glsl/shared/tess_atlas.h"
#include "glsl/shared/tess_split.h"

namespace tessera::wire {

namespace {

// What stands in a slot that no element has.
glsl::StreamedTriangle freeTriangle() { return {0, 0, 0, glsl::kNoOwner}; }

}  // namespace

struct VisibleMirror::State {
  Method method;
  AtlasSize atlas;
  bool lost = false;
  StreamState stream;
  SlotPool pieceBlocks;
  std::vector<std::uint32_t> pieceBlock;  // of elements; kNone where they have no pieces
  std::vector<ObjectTransform> objects;
  std::vector<bool> objectKnown;
  std::vector<glsl::StreamedVertex> vertices;
  std::vector<glm::vec2> mask;
  std::vector<glsl::StreamedTriangle> triangles;
  std::vector<glsl::StreamedPatch> patches;
  std::vector<glsl::StreamedTess> tess;
  std::vector<std::uint32_t> pieces;
  DirtyRanges dirty;

  // What the coder read beyond the message's end is none of it.
  static Result<void> enough(const Decoding& io) {
    if (io.coder.overrun()) return fail("geometry: the message ends early");
    return {};
  }

  Result<void> decodeObjects(Decoding& io, std::uint32_t count) {
    std::uint32_t last = kNone;
    for (std::uint32_t i = 0; i < count; ++i) {
      std::uint32_t number = 0;
      codeRising(io, stream.models.objectGap, last, number);
      if (number >= kMostObjects || (last != kNone && number <= last))
        return fail("geometry: object {} of {}: number {} is past {}", i, count, number, kMostObjects - 1);
      last = number;
      ObjectTransform transform;
      for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) {
          codeDouble(io, transform.world[column][row]);
          if (!std::isfinite(transform.world[column][row]))
            return fail("geometry: object {}: its transform has {} in column {}, row {}", number,
                        transform.world[column][row], column, row);
        }
      if (auto good = enough(io); !good) return good;
      if (number >= objects.size()) {
        objects.resize(number + 1);
        objectKnown.resize(number + 1, false);
      }
      objects[number] = transform;
      objectKnown[number] = true;
      dirty.objects.add(number);
    }
    return {};
  }

  void writeVertex(std::uint32_t slot) {
    if (slot >= vertices.size()) {
      vertices.resize(slot + 1);
      mask.resize(slot + 1);
    }
    const StreamedVertexState& v = stream.vertices[slot];
    const glm::vec3 at = positionOf(v.steps, v.level);
    vertices[slot] = {at.x, at.y, at.z, v.object};
    mask[slot] = glm::vec2(v.mask) / kMaskGrid;
    dirty.vertices.add(slot);
  }

  void writeTriangle(std::uint32_t slot, const glsl::StreamedTriangle& triangle) {
    if (slot >= triangles.size()) triangles.resize(slot + 1, freeTriangle());
    triangles[slot] = triangle;
    dirty.triangles.add(slot);
  }

  void writeTriangles(std::uint32_t slot, const StreamedElementState& element) {
    for (std::uint32_t part = 0; part < element.triangles; ++part) {
      glsl::StreamedTriangle triangle;
      triangle.owner = glsl::packOwner(slot, part, element.triangles == 3, element.mirrored);
      triangle.v0 = element.vertex[glsl::ownerCorner(triangle.owner, 0)];
      triangle.v1 = element.vertex[glsl::ownerCorner(triangle.owner, 1)];
      triangle.v2 = element.vertex[glsl::ownerCorner(triangle.owner, 2)];
      writeTriangle(element.triangle[part], triangle);
    }
  }
  void hideTriangles(const StreamedElementState& element) {
    for (std::uint32_t part = 0; part < element.triangles; ++part)
      writeTriangle(element.triangle[part], freeTriangle());
  }

  Result<void> checkPlace(std::uint32_t slot, const StreamedElementState& element) const {
    const auto& words = element.words;
    const auto inside = [&](std::uint32_t x, std::uint32_t y, std::uint32_t width,
                            std::uint32_t height) -> Result<void> {
      if (x + width <= atlas.width && y + height <= atlas.height) return {};
      return fail("geometry: element {}: its block of {} x {} at {}, {} is outside of the atlas of {} x {}",
                  slot, width, height, x, y, atlas.width, atlas.height);
    };
    if (method == Method::Rect)
      return inside(words[0] & 0xffffu, words[0] >> 16, 1u << glsl::levelWidth(words[1]),
                    1u << glsl::levelHeight(words[1]));
    const std::uint32_t kind = glsl::kindOf(words[0]);
    if (kind == glsl::kTessL && glsl::levelOfKind(words[0]) > glsl::kLargestLevel)
      return fail("geometry: element {}: level {} of an L is past {}", slot, glsl::levelOfKind(words[0]),
                  glsl::kLargestLevel);
    for (const std::size_t word : {std::size_t{3}, std::size_t{4}}) {
      // What its kind does not have is 0, and a half that is not there may say so.
      if (words[word] == glsl::kNoPlace) continue;
      if (auto good = inside(glsl::placeX(words[word]), glsl::placeY(words[word]), 1, 1); !good) return good;
    }
    return {};
  }

  // The entry that shaders read.
  Result<void> writeElement(std::uint32_t slot, const StreamedElementState& element) {
    if (auto good = checkPlace(slot, element); !good) return good;
    const auto& words = element.words;
    dirty.elements.add(slot);
    if (method == Method::Rect) {
      if (slot >= patches.size()) patches.resize(slot + 1);
      patches[slot] = {words[0], words[1], element.style, 0};
      return {};
    }
    if (slot >= tess.size()) {
      tess.resize(slot + 1);
      pieceBlock.resize(slot + 1, kNone);
    }
    const bool piece = element.parent != kNone;
    const std::uint32_t n = words[5] & 255u;
    if (piece ? n < 2 || n > glsl::kSplitMost || (words[5] >> 8) >= n * n
              : words[5] == 1 || words[5] > glsl::kSplitMost)
      return fail("geometry: element {}: {} as its {}", slot, words[5],
                  piece ? "piece" : "pieces along an edge");
    if (!piece && n != 0 && pieceBlock[slot] == kNone) {
      const std::uint32_t block = pieceBlocks.take();
      pieceBlock[slot] = block;
      const std::size_t end = (std::size_t{block} + 1) * glsl::kSplitBlock;
      if (pieces.size() < end) pieces.resize(end, kNone);
      dirty.pieces.add(static_cast<std::uint32_t>(end) - glsl::kSplitBlock);
      dirty.pieces.add(static_cast<std::uint32_t>(end) - 1);
    }
    const std::uint32_t block = pieceBlock[slot];
    tess[slot] = {words[0],
                  words[1],
                  words[2],
                  words[3],
                  words[4],
                  words[5],
                  piece ? stream.elements[element.parent].triangle[0] : element.triangle[0],
                  block == kNone ? 0 : block * glsl::kSplitBlock,
                  element.style,
                  0};
    return {};
  }

  // Of the table of pieces: where a piece is, kNone where its triangle has no block.
  std::uint32_t pieceEntry(const StreamedElementState& piece) const {
    const std::uint32_t block = pieceBlock[piece.parent];
    return block == kNone ? kNone : block * glsl::kSplitBlock + (piece.words[5] >> 8);
  }
  Result<void> enterPiece(std::uint32_t slot, const StreamedElementState& piece) {
    const std::uint32_t entry = pieceEntry(piece);
    if (entry == kNone)
      return fail("geometry: element {}: a piece of element {}, which is not split", slot, piece.parent);
    pieces[entry] = slot;
    dirty.pieces.add(entry);
    return {};
  }
  void leavePiece(std::uint32_t slot, const StreamedElementState& piece) {
    const std::uint32_t entry = pieceEntry(piece);
    if (entry == kNone || pieces[entry] != slot) return;
    pieces[entry] = kNone;
    dirty.pieces.add(entry);
  }

  Result<void> decodeCorner(Decoding& io, StreamedElementState& element, std::uint32_t slot,
                            std::size_t index, unsigned& history) {
    GeometryModels& models = stream.models;
    GeometryModels::Corner& corner = models.corners[index];
    bool fresh = false;
    io.bit(corner.fresh[history & 3u], fresh);
    history = 2 * history + (fresh ? 1 : 0);
    if (fresh) {
      if (stream.vertexSlots.used() >= kMostVertices)
        return fail("geometry: more than {} vertices", kMostVertices);
      const std::uint32_t vertex = element.vertex[index] = stream.takeVertex();
      const std::string wrong =
          codeFreshVertex(io, stream, element, index, (element.style & glsl::kStyleMasked) != 0);
      if (!wrong.empty()) return fail("geometry: element {}, corner {}: {}", slot, index, wrong);
      const std::uint32_t object = stream.vertices[vertex].object;
      if (object >= objects.size() || !objectKnown[object])
        return fail("geometry: element {}, corner {}: object {} was never sent", slot, index, object);
      writeVertex(vertex);
      models.recent.use(vertex, RecentVertices::kNotFound);
    } else {
      bool recent = false;
      io.bit(corner.recent, recent);
      std::uint32_t place = RecentVertices::kNotFound;
      std::int64_t vertex = 0;
      if (recent) {
        io.symbol(corner.place, place);
        vertex = models.recent.at(place);
      } else {
        codeNear(io, corner.step, models.explicitVertex, vertex);
      }
      if (vertex < 0 || vertex >= kNone || !stream.vertexSlots.live(static_cast<std::uint32_t>(vertex)))
        return fail("geometry: element {}, corner {}: vertex {} is none of the {} there are", slot, index,
                    vertex, stream.vertexSlots.used());
      element.vertex[index] = static_cast<std::uint32_t>(vertex);
      if (!recent) models.explicitVertex = element.vertex[index];
      models.recent.use(element.vertex[index], place);
    }
    ++stream.vertices[element.vertex[index]].elements;
    return {};
  }

  Result<void> decodeFresh(Decoding& io) {
    GeometryModels& models = stream.models;
    if (stream.elementSlots.used() >= kMostElements)
      return fail("geometry: more than {} elements", kMostElements);
    bool piece = false;
    io.bit(models.piece, piece);
    // Numbers are taken in the order in which the server took them: element, triangles, vertices.
    std::uint32_t slot = kNone;
    StreamedElementState element;
    if (piece) {
      std::int64_t parent = 0;
      codeNear(io, models.parentStep, models.parent, parent);
      if (method != Method::Tess)
        return fail("geometry: a piece of element {} in a stream of patches", parent);
      if (parent < 0 || parent >= kNone || !stream.elementSlots.live(static_cast<std::uint32_t>(parent)) ||
          stream.elements[static_cast<std::uint32_t>(parent)].parent != kNone)
        return fail("geometry: a piece of element {}, which is no triangle", parent);
      models.parent = static_cast<std::uint32_t>(parent);
      slot = stream.takeElement(0);
      element.parent = models.parent;
      element.style = stream.elements[models.parent].style;
      ++stream.elements[models.parent].pieces;
    } else {
      bool same = false;
      io.bit(models.sameStyle, same);
      element.style = models.style;
      if (!same) io.plain(element.style, 32);
      models.style = element.style;
      std::uint32_t count = 0;
      io.symbol(models.triangles, count);
      if (count == 0 || (method == Method::Tess && count != 1))
        return fail("geometry: an element of {} triangles", count);
      io.bit(models.mirrored, element.mirrored);
      slot = stream.takeElement(static_cast<std::uint8_t>(count));
      element.triangles = static_cast<std::uint8_t>(count);
      element.triangle = stream.elements[slot].triangle;
      unsigned history = 0;
      for (std::size_t i = 0; i < element.corners(); ++i)
        if (auto good = decodeCorner(io, element, slot, i, history); !good) return good;
    }
    codePlace(io, method, models, piece, nullptr, element.words);
    if (auto good = enough(io); !good) return good;
    stream.elements[slot] = element;
    if (auto good = writeElement(slot, element); !good) return good;
    writeTriangles(slot, element);
    if (piece) return enterPiece(slot, element);
    return {};
  }

  // The next of rising numbers, of which `live` says what may be named.
  template <class Live>
  Result<std::uint32_t> decodeNumber(Decoding& io, NumberModel& model, std::uint32_t last, const char* what,
                                     Live&& live) {
    std::uint32_t number = 0;
    codeRising(io, model, last, number);
    if (auto good = enough(io); !good) return tl::unexpected(good.error());
    if ((last != kNone && number <= last) || !live(number))
      return fail("geometry: {} {}, which is not there", what, number);
    return number;
  }

  Result<void> decodeMoved(Decoding& io, std::uint32_t count) {
    std::uint32_t last = kNone;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto slot = decodeNumber(io, stream.models.movedGap, last, "a place of element",
                                     [&](std::uint32_t number) { return stream.elementSlots.live(number); });
      if (!slot) return tl::unexpected(slot.error());
      last = *slot;
      StreamedElementState& element = stream.elements[*slot];
      if (element.parent != kNone) leavePiece(*slot, element);
      const auto own = element.words;
      codePlace(io, method, stream.models, element.parent != kNone, &own, element.words);
      if (auto good = writeElement(*slot, element); !good) return good;
      if (element.hidden) writeTriangles(*slot, element);
      element.hidden = false;
      if (element.parent == kNone) continue;
      if (auto good = enterPiece(*slot, element); !good) return good;
    }
    return {};
  }

  Result<void> decodeChanged(Decoding& io, std::uint32_t count) {
    std::uint32_t last = kNone;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto slot = decodeNumber(io, stream.models.changedGap, last, "a change of vertex",
                                     [&](std::uint32_t number) { return stream.vertexSlots.live(number); });
      if (!slot) return tl::unexpected(slot.error());
      last = *slot;
      StreamedVertexState next = stream.vertices[*slot];
      const std::string wrong = codeChangedVertex(io, stream, *slot, next);
      if (!wrong.empty()) return fail("geometry: change {} of {}: {}", i, count, wrong);
      stream.vertices[*slot] = next;
      writeVertex(*slot);
    }
    return {};
  }

  Result<void> decodeFreed(Decoding& io, std::uint32_t count) {
    std::vector<std::uint32_t> freed;
    std::uint32_t last = kNone;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto slot = decodeNumber(io, stream.models.freedGap, last, "freeing of element",
                                     [&](std::uint32_t number) { return stream.elementSlots.live(number); });
      if (!slot) return tl::unexpected(slot.error());
      last = *slot;
      freed.push_back(*slot);
    }
    for (const std::uint32_t slot : freed) {
      const StreamedElementState element = stream.elements[slot];
      if (element.parent != kNone) leavePiece(slot, element);
      hideTriangles(element);
      stream.giveElement(slot, [](std::uint32_t) {});
    }
    // Once all pieces of what is freed have left the table.
    for (const std::uint32_t slot : freed) {
      if (stream.elements[slot].pieces > 0)
        return fail("geometry: element {} is freed, but {} of its pieces are not", slot,
                    stream.elements[slot].pieces);
      if (slot < pieceBlock.size() && pieceBlock[slot] != kNone) {
        pieceBlocks.give(pieceBlock[slot]);
        pieceBlock[slot] = kNone;
      }
    }
    return {};
  }

  Result<void> decodeHidden(Decoding& io, std::uint32_t count) {
    std::uint32_t last = kNone;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto slot = decodeNumber(io, stream.models.hiddenGap, last, "hiding of element",
                                     [&](std::uint32_t number) { return stream.elementSlots.live(number); });
      if (!slot) return tl::unexpected(slot.error());
      last = *slot;
      StreamedElementState& element = stream.elements[*slot];
      if (element.hidden || element.parent != kNone || element.pieces > 0)
        return fail("geometry: hiding of element {}, which {}", *slot,
                    element.hidden            ? "is hidden"
                    : element.parent != kNone ? "is a piece"
                                              : "has pieces");
      hideTriangles(element);
      element.hidden = true;
    }
    return {};
  }

  Result<void> decode(Decoding& io) {
    std::array<std::uint32_t, 6> counts{};
    for (std::size_t i = 0; i < counts.size(); ++i) io.number(stream.models.counts[i], counts[i]);
    if (auto good = enough(io); !good) return good;
    const std::array<std::uint32_t, 6> limits = {kMostObjects,  kMostElements, kMostElements,
                                                 kMostVertices, kMostElements, kMostElements};
    constexpr std::array<const char*, 6> kNames = {"objects",          "fresh elements", "moved places",
                                                   "changed vertices", "freed elements", "hidden elements"};
    for (std::size_t i = 0; i < counts.size(); ++i)
      if (counts[i] > limits[i])
        return fail("geometry: {} {} are more than {}", counts[i], kNames[i], limits[i]);
    if (auto good = decodeObjects(io, counts[0]); !good) return good;
    if (auto good = decodeMoved(io, counts[2]); !good) return good;
    for (std::uint32_t i = 0; i < counts[1]; ++i)
      if (auto good = decodeFresh(io); !good) return good;
    if (auto good = decodeChanged(io, counts[3]); !good) return good;
    if (auto good = decodeFreed(io, counts[4]); !good) return good;
    if (auto good = decodeHidden(io, counts[5]); !good) return good;
    std::uint32_t mark = 0;
    io.plain(mark, kEndBits);
    if (auto good = enough(io); !good) return good;
    if (mark != kEndMark || !io.coder.complete())
      return fail("geometry: the message does not end where it should");
    return {};
  }
};

VisibleMirror::VisibleMirror(Method method, AtlasSize atlas) : s_(std::make_unique<State>()) {
  s_->method = method;
  s_->atlas = atlas;
}
VisibleMirror::~VisibleMirror() = default;
VisibleMirror::VisibleMirror(VisibleMirror&&) noexcept = default;
VisibleMirror& VisibleMirror::operator=(VisibleMirror&&) noexcept = default;

Result<DirtyRanges> VisibleMirror::apply(std::span<const std::uint8_t> message) {
  State& s = *s_;
  if (s.lost) return fail("geometry: the stream was lost by an earlier error");
  s.dirty = {};
  Decoding io(message);
  if (auto good = s.decode(io); !good) {
    s.lost = true;
    return tl::unexpected(good.error());
  }
  return s.dirty;
}

Method VisibleMirror::method() const { return s_->method; }
std::span<const glsl::StreamedVertex> VisibleMirror::vertices() const { return s_->vertices; }
std::span<const glm::vec2> VisibleMirror::maskCoordinates() const { return s_->mask; }
std::span<const glsl::StreamedTriangle> VisibleMirror::triangles() const { return s_->triangles; }
std::span<const glsl::StreamedPatch> VisibleMirror::patches() const { return s_->patches; }
std::span<const glsl::StreamedTess> VisibleMirror::tess() const { return s_->tess; }
std::span<const std::uint32_t> VisibleMirror::pieces() const { return s_->pieces; }
std::span<const ObjectTransform> VisibleMirror::objects() const { return s_->objects; }
std::uint32_t VisibleMirror::liveVertices() const { return s_->stream.vertexSlots.used(); }
std::uint32_t VisibleMirror::liveTriangles() const { return s_->stream.triangleSlots.used(); }
std::uint32_t VisibleMirror::liveElements() const { return s_->stream.elementSlots.used(); }

}  // namespace tessera::wire
