// The geometry message, element by element: written once for both directions, so that they cannot differ.
// Encoding reads the numbers that it is given, Decoding overwrites them. Order and meaning are in
// geometry_models.hpp.
#pragma once

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "codec/wire/pixel_bound.hpp"
#include "codec/wire/stream_state.hpp"

namespace tessera::wire {

class Encoding {
 public:
  static constexpr bool kDecodes = false;
  RangeEncoder coder;
  void bit(BitModel& model, bool& value) { coder.bit(value, model); }
  template <int Bits>
  void symbol(SymbolModel<Bits>& model, std::uint32_t& value) {
    model.encode(coder, value);
  }
  void number(NumberModel& model, std::uint32_t& value) { model.encode(coder, value); }
  void step(SignedModel& model, std::int64_t& value) { model.encode(coder, value); }
  void plain(std::uint32_t& value, int bits) { coder.plain(value, bits); }
};

class Decoding {
 public:
  static constexpr bool kDecodes = true;
  explicit Decoding(std::span<const std::uint8_t> bytes) : coder(bytes) {}
  RangeDecoder coder;
  void bit(BitModel& model, bool& value) { value = coder.bit(model); }
  template <int Bits>
  void symbol(SymbolModel<Bits>& model, std::uint32_t& value) {
    value = model.decode(coder);
  }
  void number(NumberModel& model, std::uint32_t& value) { value = model.decode(coder); }
  void step(SignedModel& model, std::int64_t& value) { value = model.decode(coder); }
  void plain(std::uint32_t& value, int bits) { value = coder.plain(bits); }
};

/// `value` as a step from `from`. Decoded values are what they are, be they out of any range.
template <class Io>
void codeNear(Io& io, SignedModel& model, std::int64_t from, std::int64_t& value) {
  std::int64_t step = value - from;
  io.step(model, step);
  value = from + step;
}

template <class Io>
void codeDouble(Io& io, double& value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  auto low = static_cast<std::uint32_t>(bits);
  auto high = static_cast<std::uint32_t>(bits >> 32);
  io.plain(low, 32);
  io.plain(high, 32);
  value = std::bit_cast<double>(std::uint64_t{high} << 32 | low);
}

/// A number above the last one, which may be kNone: nothing was before.
template <class Io>
void codeRising(Io& io, NumberModel& model, std::uint32_t last, std::uint32_t& value) {
  std::uint32_t gap = value - last - 1;
  io.number(model, gap);
  value = last + 1 + gap;
}

/// A patch's words. `own`: its own last words where it had a place before, else null.
template <class Io>
void codeRectPlace(Io& io, GeometryModels& models, const std::array<std::uint32_t, kMostWords>* own,
                   std::array<std::uint32_t, kMostWords>& words) {
  const std::size_t moved = own != nullptr ? 1 : 0;
  const std::uint32_t expected = (own != nullptr ? *own : models.words)[1];
  bool kept = words[1] == expected;
  io.bit(models.rectKept[moved], kept);
  if (kept)
    words[1] = expected;
  else
    io.symbol(models.rectLevel[moved], words[1]);
  const std::uint32_t level = words[1];
  std::uint32_t& last = models.rectOrigin[level];
  const std::array<std::uint32_t, 2> log2Size = {glsl::levelWidth(level), glsl::levelHeight(level)};
  std::uint32_t origin = 0;
  for (std::uint32_t axis = 0; axis < 2; ++axis) {
    const std::uint32_t size = log2Size[axis];
    const std::uint32_t at = (words[0] >> (16 * axis)) & 0xffffu;
    std::int64_t block = at >> size;
    codeNear(io, models.rectStep[moved][axis][size], ((last >> (16 * axis)) & 0xffffu) >> size, block);
    std::uint32_t inside = at & ((1u << size) - 1u);
    bool aligned = inside == 0;
    io.bit(models.rectAligned[axis], aligned);
    if (aligned)
      inside = 0;
    else
      io.plain(inside, static_cast<int>(size));
    origin |= (((static_cast<std::uint32_t>(block) << size) | inside) & 0xffffu) << (16 * axis);
  }
  words[0] = last = origin;
  models.words = words;
}

/// A size of a block in texels, below 2^bits; `own`: what it was, else null; `known`: a size that goes with
/// it.
template <class Io>
void codeTessSize(Io& io, TessModels::Size& models, int bits, const std::uint32_t* own, std::uint32_t known,
                  std::uint32_t& size) {
  std::uint32_t number = sizeClass(size);
  bool regular = sizeOfClass(number) == size;
  io.bit(models.regular, regular);
  if (!regular) {
    io.plain(size, bits);
    return;
  }
  if (own != nullptr) {
    std::int64_t value = number;
    codeNear(io, models.step, sizeClass(*own), value);
    number = static_cast<std::uint32_t>(value) & ((1u << kSizeClassBits) - 1u);
  } else {
    io.symbol(models.number[std::min(sizeClass(known) / 2, 31u)], number);
  }
  size = sizeOfClass(number) & ((1u << bits) - 1u);
}

template <class Io>
void codeTessSlot(Io& io, TessModels& models, const TessStock& stock, const std::uint32_t* own,
                  std::uint32_t& place) {
  if (own != nullptr) {
    bool kept = place == *own;
    io.bit(models.keptPlace[1], kept);
    if (kept) {
      place = *own;
      return;
    }
  }
  // A half that is not there.
  bool none = place == glsl::kNoPlace;
  io.bit(models.keptPlace[0], none);
  if (none) {
    place = glsl::kNoPlace;
    return;
  }
  std::uint32_t& last = models.place[stock.number];
  bool turned = glsl::placeTurned(place) != 0;
  const bool before = glsl::placeTurned(last) != 0;
  io.bit(models.turned[before ? 1 : 0], turned);
  std::int64_t x = glsl::placeX(place);
  std::int64_t y = glsl::placeY(place);
  const std::size_t same = turned == before ? 1 : 0;
  codeNear(io, models.step[0][stock.context][same], glsl::placeX(last), x);
  codeNear(io, models.step[1][stock.context][same], glsl::placeY(last), y);
  place = last = glsl::packPlace(static_cast<std::uint32_t>(x) & 0x7fffu,
                                 static_cast<std::uint32_t>(y) & 0xffffu, turned ? 1 : 0);
}

/// Of Oversampling: sizes, apex and foot. The foot is where the halves' columns say, but for their rounding.
template <class Io>
void codeTessShape(Io& io, TessModels& models, const glsl::OverShape* own, glsl::OverShape& shape) {
  codeTessSize(io, models.sizes[0], 12, own != nullptr ? &own->columns0 : nullptr, 0, shape.columns0);
  codeTessSize(io, models.sizes[1], 12, own != nullptr ? &own->columns1 : nullptr, shape.columns0,
               shape.columns1);
  codeTessSize(io, models.sizes[2], 16, own != nullptr ? &own->rows : nullptr,
               std::max(shape.columns0, shape.columns1), shape.rows);
  bool same = own != nullptr && shape.apex == own->apex;
  if (own != nullptr) io.bit(models.sameApex, same);
  if (same)
    shape.apex = own->apex;
  else
    io.symbol(models.apex, shape.apex);
  const std::uint32_t columns = shape.columns0 + shape.columns1;
  const std::uint32_t from = own != nullptr ? own->foot
                             : columns == 0 ? 0
                                            : 65535u * shape.columns0 / columns;
  std::int64_t foot = shape.foot;
  codeNear(io, models.foot[own != nullptr ? 1 : 0], from, foot);
  shape.foot = static_cast<std::uint32_t>(foot) & 0xffffu;
}

/// A triangle's words, or a piece's. What its kind does not have is 0.
template <class Io>
void codeTessPlace(Io& io, GeometryModels& models, bool piece,
                   const std::array<std::uint32_t, kMostWords>* own,
                   std::array<std::uint32_t, kMostWords>& words) {
  TessModels& tess = models.tess;
  const std::size_t moved = own != nullptr ? 1 : 0;
  const auto& before = own != nullptr ? *own : models.words;
  std::uint32_t kind = glsl::kindOf(words[0]);
  io.symbol(tess.kind[moved][glsl::kindOf(before[0])], kind);
  const bool alike = own != nullptr && kind == glsl::kindOf(before[0]);
  std::array<std::uint32_t, kMostWords> coded{};
  coded[0] = kind;
  const std::uint32_t* place0 = alike ? &before[3] : nullptr;
  const std::uint32_t* place1 = alike ? &before[4] : nullptr;
  coded[3] = words[3];
  coded[4] = words[4];
  if (kind == glsl::kTessL) {
    std::uint32_t level = glsl::levelOfKind(words[0]) & 255u;
    if (alike) {
      std::int64_t value = level;
      codeNear(io, tess.levelStep, glsl::levelOfKind(before[0]), value);
      level = static_cast<std::uint32_t>(value) & 255u;
    } else {
      io.symbol(tess.level, level);
    }
    coded[0] = glsl::kindOfL(level);
    codeTessSlot(io, tess, stockOfLevel(level), place0, coded[3]);
    coded[4] = 0;
  } else if (kind == glsl::kTessOver) {
    glsl::OverShape shape = glsl::overOfShape({words[0], words[1], words[2]});
    const glsl::OverShape was = glsl::overOfShape({before[0], before[1], before[2]});
    bool same = alike && words[1] == before[1] && words[2] == before[2];
    if (alike) io.bit(tess.sameShape[0], same);
    if (same)
      shape = was;
    else
      codeTessShape(io, tess, alike ? &was : nullptr, shape);
    const glsl::TessShape done = glsl::shapeOfOver(shape);
    coded[1] = done.size;
    coded[2] = done.form;
    coded[3] = shape.columns0 > 0 ? words[3] : 0;
    coded[4] = shape.columns1 > 0 ? words[4] : 0;
    if (shape.columns0 > 0)
      codeTessSlot(io, tess, stockOfBlock(shape.columns0, shape.rows), place0, coded[3]);
    if (shape.columns1 > 0)
      codeTessSlot(io, tess, stockOfBlock(shape.columns1, shape.rows), place1, coded[4]);
  } else {
    coded[4] = 0;
    if (kind == glsl::kTessSingle)
      codeTessSlot(io, tess, stockOfLevel(0), place0, coded[3]);
    else
      coded[3] = 0;
  }
  bool split = words[5] != 0;
  io.bit(tess.split, split);
  coded[5] = 0;
  if (split) {
    std::int64_t n = words[5] & 255u;
    codeNear(io, tess.pieceSize, before[5] & 255u, n);
    coded[5] = static_cast<std::uint32_t>(n) & 255u;
    if (piece) {
      std::int64_t index = words[5] >> 8;
      codeNear(io, tess.pieceStep, before[5] >> 8, index);
      coded[5] |= (static_cast<std::uint32_t>(index) & 0xffffffu) << 8;
    }
  }
  words = models.words = coded;
}

template <class Io>
void codePlace(Io& io, Method method, GeometryModels& models, bool piece,
               const std::array<std::uint32_t, kMostWords>* own,
               std::array<std::uint32_t, kMostWords>& words) {
  if (method == Method::Rect)
    codeRectPlace(io, models, own, words);
  else
    codeTessPlace(io, models, piece, own, words);
}

/// Steps from `expected`, in the grid of v.level. False where a decoded vertex is out of range.
template <class Io, class Models>
bool codeSteps(Io& io, Models&& modelOf, const glm::dvec3& expected, StreamedVertexState& v) {
  constexpr double kMost = kMostSteps;
  std::uint32_t before = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double near = std::clamp(std::ldexp(expected[axis], -v.level), -kMost, kMost);
    const std::int64_t from = std::lrint(near);
    std::int64_t value = v.steps[axis];
    codeNear(io, modelOf(axis, before), from, value);
    if (value <= -kMostSteps || value >= kMostSteps) return false;
    v.steps[axis] = static_cast<int>(value);
    before = std::max(before, static_cast<std::uint32_t>(
                                  std::bit_width(static_cast<std::uint64_t>(std::abs(value - from)))));
  }
  return true;
}

/// Where a fresh vertex is expected that is corner `index` of an element: across the parallelogram of those
/// before it.
inline glm::dvec3 expectedPosition(const StreamState& state, const StreamedElementState& element,
                                   std::size_t index) {
  const auto at = [&](std::size_t corner) { return state.positionOf(element.vertex[corner]); };
  if (index == 0) return state.models.vertexPosition;
  if (index == 1) return at(0);
  if (index == 2) return at(1);
  return at(0) + at(index - 1) - at(index - 2);
}

/// A vertex that was never sent. `state.vertices[slot]` is read, or written. Empty when all is well.
template <class Io>
std::string codeFreshVertex(Io& io, StreamState& state, StreamedElementState& element, std::size_t index,
                            bool masked) {
  GeometryModels& models = state.models;
  StreamedVertexState& v = state.vertices[element.vertex[index]];
  bool same = v.object == models.object;
  io.bit(models.sameObject, same);
  if (same)
    v.object = models.object;
  else
    io.plain(v.object, 16);
  models.object = v.object;
  std::int64_t level = v.level;
  codeNear(io, models.level, models.vertexLevel, level);
  if (level < kFinestLevel || level > kCoarsestLevel) return fmt::format("a vertex at level {}", level);
  models.vertexLevel = v.level = static_cast<int>(level);
  const auto modelOf = [&](int axis, std::uint32_t before) -> SignedModel& {
    return models.steps[index][static_cast<std::size_t>(axis)][std::min(before / 4, 3u)];
  };
  if (!codeSteps(io, modelOf, expectedPosition(state, element, index), v))
    return fmt::format("a vertex past {} steps", kMostSteps);
  models.vertexPosition = state.positionOf(element.vertex[index]);
  if (!masked) return {};
  for (int axis = 0; axis < 2; ++axis) {
    std::int64_t value = v.mask[axis];
    codeNear(io, models.mask[static_cast<std::size_t>(axis)], models.maskSteps[axis], value);
    constexpr auto kMost = static_cast<std::int64_t>(kMaskGrid * kMostMaskCoordinate);
    if (value < -kMost || value > kMost) return fmt::format("a mask coordinate of {} steps", value);
    models.maskSteps[axis] = v.mask[axis] = static_cast<int>(value);
  }
  return {};
}

/// A vertex that the viewer has, at another place or level: `next` is read, or written, with what else it has
/// in it.
template <class Io>
std::string codeChangedVertex(Io& io, StreamState& state, std::uint32_t slot, StreamedVertexState& next) {
  const int was = state.vertices[slot].level;
  std::int64_t level = next.level;
  codeNear(io, state.models.changedLevel, was, level);
  if (level < kFinestLevel || level > kCoarsestLevel) return fmt::format("a vertex at level {}", level);
  next.level = static_cast<int>(level);
  const auto finer = static_cast<std::size_t>(std::clamp(was - next.level, 0, 7));
  const auto modelOf = [&](int axis, std::uint32_t) -> SignedModel& {
    return state.models.changedStep[static_cast<std::size_t>(axis)][finer];
  };
  if (!codeSteps(io, modelOf, state.positionOf(slot), next))
    return fmt::format("a vertex past {} steps", kMostSteps);
  return {};
}

}  // namespace tessera::wire
