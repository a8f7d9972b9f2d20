#include "codec/wire/visible_delta.hpp"

#include <algorithm>
#include <cassert>
#include <unordered_map>

#include "codec/wire/geometry_coding.hpp"

namespace tessera::wire {

namespace {

struct Live {
  std::uint32_t id;
  std::uint32_t slot;
};

// Without what the viewer has no use for: a server's own bits, what an earlier shape has left.
std::array<std::uint32_t, kMostWords> sentWords(Method method, const VisibleElement& element) {
  const auto& words = element.words;
  if (method == Method::Rect) return {words[0], words[1] & ((1u << kRectLevelBits) - 1u)};
  const std::uint32_t kind = glsl::kindOf(words[0]);
  if (kind == glsl::kTessNone) return {words[0] & glsl::kTessKind, 0, 0, 0, 0, words[5]};
  if (kind == glsl::kTessSingle) return {words[0] & glsl::kTessKind, 0, 0, words[3], 0, words[5]};
  if (kind == glsl::kTessL) return {words[0], 0, 0, words[3], 0, words[5]};
  const glsl::OverShape over = glsl::overOfShape({words[0], words[1], words[2]});
  const glsl::TessShape shape = glsl::shapeOfOver(over);
  return {
      shape.kind, shape.size, shape.form, over.columns0 > 0 ? words[3] : 0, over.columns1 > 0 ? words[4] : 0,
      words[5]};
}

glm::ivec2 maskSteps(const glm::vec2& at) {
  const auto steps = [](float value) {
    return static_cast<int>(
        std::lrint(std::clamp(value, -kMostMaskCoordinate, kMostMaskCoordinate) * kMaskGrid));
  };
  return {steps(at.x), steps(at.y)};
}

}  // namespace

struct VisibleDelta::State {
  const GeometrySource& source;
  DeltaOptions options;
  int headroom;
  StreamState stream;
  DeltaStatistics statistics;
  std::vector<Live> live;  // by id
  struct Kept {
    std::uint32_t slot;
    std::uint32_t since;  // frame in which it was not seen any more
  };
  std::unordered_map<std::uint32_t, Kept> kept;  // hidden elements, by id
  std::vector<std::uint32_t> vertexSlot;         // of the source's vertices, kNone where not sent
  std::vector<std::uint32_t> vertexOf;           // of the slots
  std::vector<int> wanted;                 // level, of the source's vertices that this frame's elements use
  std::vector<std::uint32_t> wantedFrame;  // in which that was
  std::uint32_t frame = 0;
  std::vector<ObjectTransform> sentObjects;
  std::vector<bool> objectSent;

  State(const GeometrySource& from, const DeltaOptions& how)
      : source(from),
        options(how),
        headroom(std::clamp(how.headroom, 0, 8)),
        vertexSlot(from.vertices.size(), kNone),
        wanted(from.vertices.size(), kCoarsestLevel),
        wantedFrame(from.vertices.size(), 0) {}

  const SourceElement* sourceOf(std::uint32_t id) const {
    return id < source.elements.size() ? &source.elements[id] : nullptr;
  }

  void want(std::uint32_t vertex, int level) {
    if (wantedFrame[vertex] != frame) {
      wantedFrame[vertex] = frame;
      wanted[vertex] = level;
    } else {
      wanted[vertex] = std::min(wanted[vertex], level);
    }
  }

  // Of a triangle's corners; above all levels where one was not sent.
  int coarsestSent(const SourceElement& element, const std::array<std::size_t, 3>& corners) const {
    int coarsest = kFinestLevel;
    for (const std::size_t corner : corners) {
      const std::uint32_t slot = vertexSlot[element.vertex[corner]];
      coarsest = std::max(coarsest, slot == kNone ? kCoarsestLevel + 1 : stream.vertices[slot].level);
    }
    return coarsest;
  }

  // What the bound asks of the vertices of every visible triangle: a point of a triangle may be nearer than
  // its corners, and moves as they do.
  void findLevels(const VisibleFrame& visible, std::span<const VisibleElement> elements) {
    std::vector<double> stretch(visible.objects.size());
    for (std::size_t i = 0; i < stretch.size(); ++i) stretch[i] = stretchOf(visible.objects[i].world);
    for (const VisibleElement& shown : elements) {
      const SourceElement* element = shown.parent == kNone ? sourceOf(shown.id) : nullptr;
      if (element == nullptr) continue;
      std::array<glm::dvec3, 5> corners;
      double largest = 0.0;
      for (std::size_t i = 0; i < element->triangles + 2u; ++i) {
        const SourceVertex& vertex = source.vertices[element->vertex[i]];
        assert(vertex.object < visible.objects.size());
        corners[i] = visible.objects[vertex.object].world * glm::dvec4(vertex.position, 1.0) - visible.eye;
        largest = std::max(largest, stretch[vertex.object]);
      }
      for (std::size_t part = 0; part < element->triangles; ++part) {
        const std::array<std::size_t, 3> of = {0, part + 1, part + 2};
        const glm::dvec3& a = corners[of[0]];
        const glm::dvec3& b = corners[of[1]];
        const glm::dvec3& c = corners[of[2]];
        // No point of it is nearer than this. Where that is far enough for what was sent, nothing follows
        // from the exact distance.
        const double spread = std::sqrt(std::max(glm::dot(b - a, b - a), glm::dot(c - a, c - a)));
        int level = visible.bound.level(glm::length(a) - spread, largest);
        if (level < coarsestSent(*element, of))
          level = visible.bound.level(distanceToTriangle(a, b, c), largest);
        for (const std::size_t corner : of) want(element->vertex[corner], level);
      }
    }
  }

  // As fine as wanted, and by the headroom finer.
  void quantise(std::uint32_t vertex, int level, StreamedVertexState& v) const {
    const SourceVertex& from = source.vertices[vertex];
    v.level = std::clamp(levelFor(from.position, level), kFinestLevel, kCoarsestLevel);
    v.steps = stepsOf(from.position, v.level);
  }

  void codeObjects(Encoding& io, const VisibleFrame& visible, const std::vector<std::uint32_t>& changed) {
    std::uint32_t last = kNone;
    for (std::uint32_t number : changed) {
      codeRising(io, stream.models.objectGap, last, number);
      last = number;
      ObjectTransform transform = visible.objects[number];
      for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) codeDouble(io, transform.world[column][row]);
      sentObjects[number] = transform;
      objectSent[number] = true;
    }
  }

  void codeCorner(Encoding& io, StreamedElementState& element, std::size_t index, std::uint32_t vertex,
                  unsigned& history) {
    GeometryModels& models = stream.models;
    GeometryModels::Corner& corner = models.corners[index];
    bool fresh = vertexSlot[vertex] == kNone;
    io.bit(corner.fresh[history & 3u], fresh);
    history = 2 * history + (fresh ? 1 : 0);
    if (fresh) {
      const std::uint32_t slot = stream.takeVertex();
      vertexSlot[vertex] = element.vertex[index] = slot;
      if (slot >= vertexOf.size()) vertexOf.resize(slot + 1);
      vertexOf[slot] = vertex;
      StreamedVertexState& v = stream.vertices[slot];
      v.object = source.vertices[vertex].object;
      v.mask = maskSteps(source.vertices[vertex].mask);
      quantise(vertex, wanted[vertex] - headroom, v);
      const double before = io.coder.cost();
      codeFreshVertex(io, stream, element, index, (element.style & glsl::kStyleMasked) != 0);
      statistics.vertexBits += io.coder.cost() - before;
      statistics.triangleBits -= io.coder.cost() - before;
      ++statistics.freshVertices;
      models.recent.use(slot, RecentVertices::kNotFound);
    } else {
      std::uint32_t slot = element.vertex[index] = vertexSlot[vertex];
      std::uint32_t place = models.recent.find(slot);
      bool recent = place != RecentVertices::kNotFound;
      io.bit(corner.recent, recent);
      if (recent) {
        io.symbol(corner.place, place);
      } else {
        std::int64_t value = slot;
        codeNear(io, corner.step, models.explicitVertex, value);
        models.explicitVertex = slot;
      }
      models.recent.use(slot, place);
    }
    ++stream.vertices[element.vertex[index]].elements;
  }

  std::uint32_t codeFresh(Encoding& io, const VisibleElement& shown) {
    GeometryModels& models = stream.models;
    const double before = io.coder.cost();
    bool piece = shown.parent != kNone;
    const SourceElement none;
    const SourceElement& from = piece ? none : source.elements[shown.id];
    const std::uint32_t slot = stream.takeElement(piece ? 0 : from.triangles);
    StreamedElementState element = stream.elements[slot];
    io.bit(models.piece, piece);
    if (piece) {
      element.parent = slotOf(shown.parent);
      element.style = stream.elements[element.parent].style;
      std::int64_t parent = element.parent;
      codeNear(io, models.parentStep, models.parent, parent);
      models.parent = element.parent;
      ++stream.elements[element.parent].pieces;
    } else {
      element.style = from.style;
      element.mirrored = from.mirrored;
      bool same = element.style == models.style;
      io.bit(models.sameStyle, same);
      if (!same) io.plain(element.style, 32);
      models.style = element.style;
      std::uint32_t triangles = from.triangles;
      io.symbol(models.triangles, triangles);
      io.bit(models.mirrored, element.mirrored);
      statistics.freshTriangles += triangles;
      unsigned history = 0;
      for (std::size_t i = 0; i < element.corners(); ++i) codeCorner(io, element, i, from.vertex[i], history);
    }
    const double placed = io.coder.cost();
    statistics.triangleBits += placed - before;
    element.words = sentWords(source.method, shown);
    codePlace(io, source.method, models, piece, nullptr, element.words);
    statistics.placeBits += io.coder.cost() - placed;
    stream.elements[slot] = element;
    return slot;
  }

  std::uint32_t slotOf(std::uint32_t id) const {
    const auto found = std::lower_bound(live.begin(), live.end(), id,
                                        [](const Live& a, std::uint32_t b) { return a.id < b; });
    assert(found != live.end() && found->id == id);
    return found->slot;
  }
};

VisibleDelta::VisibleDelta(const GeometrySource& source, const DeltaOptions& options)
    : s_(std::make_unique<State>(source, options)) {}
VisibleDelta::~VisibleDelta() = default;
VisibleDelta::VisibleDelta(VisibleDelta&&) noexcept = default;
VisibleDelta& VisibleDelta::operator=(VisibleDelta&&) noexcept = default;

const DeltaStatistics& VisibleDelta::statistics() const { return s_->statistics; }

std::vector<std::uint8_t> VisibleDelta::next(const VisibleFrame& visible) {
  State& s = *s_;
  GeometryModels& models = s.stream.models;
  s.statistics = {};
  ++s.frame;
  std::vector<VisibleElement> elements(visible.elements.begin(), visible.elements.end());
  std::sort(elements.begin(), elements.end(),
            [](const VisibleElement& a, const VisibleElement& b) { return a.id < b.id; });
  s.findLevels(visible, elements);

  // What is new, what stays, and what is gone. A piece whose triangle is another one, or was away, is new.
  std::vector<VisibleElement> fresh;
  std::vector<std::uint32_t> gone;
  std::vector<std::uint32_t> hidden;
  std::vector<std::pair<std::uint32_t, std::array<std::uint32_t, kMostWords>>> moved;
  std::vector<Live> kept;
  kept.reserve(elements.size());
  std::vector<bool> freeing(s.stream.elements.size(), false);
  {
    auto old = s.live.begin();
    const auto drop = [&](const Live& element) {
      freeing[element.slot] = true;
      const StreamedElementState& state = s.stream.elements[element.slot];
      // Of what is split, the pieces go anyway.
      const bool whole = state.parent == kNone && (s.source.method == Method::Rect || state.words[5] == 0);
      if (whole && s.options.keepFrames > 0 && s.kept.size() < s.options.keepMost) {
        hidden.push_back(element.slot);
        s.kept[element.id] = {element.slot, s.frame};
      } else {
        gone.push_back(element.slot);
      }
    };
    for (const VisibleElement& element : elements) {
      for (; old != s.live.end() && old->id < element.id; ++old) drop(*old);
      if (old == s.live.end() || old->id != element.id) {
        const auto known = s.kept.find(element.id);
        if (known == s.kept.end() || element.parent != kNone) {
          fresh.push_back(element);
          continue;
        }
        kept.push_back({element.id, known->second.slot});
        moved.emplace_back(known->second.slot, sentWords(s.source.method, element));
        s.kept.erase(known);
        ++s.statistics.shownElements;
        continue;
      }
      const Live was = *old++;
      const StreamedElementState& state = s.stream.elements[was.slot];
      // Triangles have lower ids than pieces: whether they stay is known.
      const bool samePlace =
          element.parent == kNone
              ? state.parent == kNone
              : state.parent != kNone && !freeing[state.parent] && [&] {
                  const auto parent =
                      std::lower_bound(kept.begin(), kept.end(), element.parent,
                                       [](const Live& a, std::uint32_t id) { return a.id < id; });
                  return parent != kept.end() && parent->id == element.parent && parent->slot == state.parent;
                }();
      if (!samePlace) {
        drop(was);
        fresh.push_back(element);
        continue;
      }
      kept.push_back(was);
      const auto words = sentWords(s.source.method, element);
      if (words != state.words) moved.emplace_back(was.slot, words);
    }
    for (; old != s.live.end(); ++old) drop(*old);
  }
  std::sort(moved.begin(), moved.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto at = s.kept.begin(); at != s.kept.end();) {
    const bool old = s.frame - at->second.since >= s.options.keepFrames;
    if (old) gone.push_back(at->second.slot);
    at = old ? s.kept.erase(at) : std::next(at);
  }
  std::sort(gone.begin(), gone.end());
  std::sort(hidden.begin(), hidden.end());

  // Vertices that the viewer has and that must change.
  std::vector<std::pair<std::uint32_t, int>> changed;  // slot, level
  std::vector<bool> listed(s.stream.vertices.size(), false);
  for (const VisibleElement& shown : elements) {
    const SourceElement* element = shown.parent == kNone ? s.sourceOf(shown.id) : nullptr;
    if (element == nullptr) continue;
    for (std::size_t i = 0; i < element->triangles + 2u; ++i) {
      const std::uint32_t vertex = element->vertex[i];
      const std::uint32_t slot = s.vertexSlot[vertex];
      if (slot == kNone || listed[slot]) continue;
      const int finest = levelFor(s.source.vertices[vertex].position, s.wanted[vertex]);
      if (s.stream.vertices[slot].level <= finest) continue;
      listed[slot] = true;
      changed.emplace_back(slot, s.wanted[vertex] - s.headroom);
      ++s.statistics.refinedVertices;
    }
  }
  for (const std::uint32_t vertex : visible.deformed) {
    const std::uint32_t slot = s.vertexSlot[vertex];
    if (slot == kNone || listed[slot]) continue;
    StreamedVertexState next;
    s.quantise(vertex, s.stream.vertices[slot].level, next);
    if (next.level == s.stream.vertices[slot].level && next.steps == s.stream.vertices[slot].steps) continue;
    listed[slot] = true;
    changed.emplace_back(slot, next.level);
    ++s.statistics.deformedVertices;
  }
  std::sort(changed.begin(), changed.end());

  // Objects that any vertex names are few: all that changed are sent.
  std::vector<std::uint32_t> objects;
  assert(visible.objects.size() <= kMostObjects);
  s.sentObjects.resize(std::max(s.sentObjects.size(), visible.objects.size()));
  s.objectSent.resize(s.sentObjects.size(), false);
  for (std::uint32_t i = 0; i < visible.objects.size(); ++i)
    if (!s.objectSent[i] || !(s.sentObjects[i] == visible.objects[i])) objects.push_back(i);

  Encoding io;
  const auto countOf = [&](std::size_t i, std::size_t size) {
    auto count = static_cast<std::uint32_t>(size);
    io.number(models.counts[i], count);
  };
  countOf(0, objects.size());
  countOf(1, fresh.size());
  countOf(2, moved.size());
  countOf(3, changed.size());
  countOf(4, gone.size());
  countOf(5, hidden.size());
  s.codeObjects(io, visible, objects);
  s.statistics.objectBits = io.coder.cost();

  double before = io.coder.cost();
  std::uint32_t last = kNone;
  for (auto& [slot, words] : moved) {
    codeRising(io, models.movedGap, last, slot);
    last = slot;
    codePlace(io, s.source.method, models, s.stream.elements[slot].parent != kNone,
              &s.stream.elements[slot].words, words);
    s.stream.elements[slot].words = words;
    s.stream.elements[slot].hidden = false;
  }
  s.statistics.placeBits += io.coder.cost() - before;

  // Pieces find their triangle among what is live, old or new: triangles come first.
  std::vector<Live> added;
  s.live = kept;
  bool merged = false;
  const auto merge = [&] {
    std::vector<Live> all(s.live.size() + added.size());
    std::merge(s.live.begin(), s.live.end(), added.begin(), added.end(), all.begin(),
               [](const Live& a, const Live& b) { return a.id < b.id; });
    s.live = std::move(all);
    added.clear();
  };
  for (const VisibleElement& element : fresh) {
    assert(element.parent != kNone ||
           (element.id < s.source.elements.size() && s.source.elements[element.id].triangles > 0));
    if (element.parent != kNone && !merged) {
      merge();
      merged = true;
    }
    added.push_back({element.id, s.codeFresh(io, element)});
  }
  merge();

  before = io.coder.cost();
  last = kNone;
  for (auto& [slot, level] : changed) {
    codeRising(io, models.changedGap, last, slot);
    last = slot;
    StreamedVertexState next = s.stream.vertices[slot];
    s.quantise(s.vertexOf[slot], level, next);
    codeChangedVertex(io, s.stream, slot, next);
    s.stream.vertices[slot] = next;
  }
  s.statistics.vertexBits += io.coder.cost() - before;

  before = io.coder.cost();
  last = kNone;
  for (std::uint32_t slot : gone) {
    codeRising(io, models.freedGap, last, slot);
    last = slot;
  }
  for (const std::uint32_t slot : gone)
    s.stream.giveElement(slot, [&](std::uint32_t vertex) { s.vertexSlot[s.vertexOf[vertex]] = kNone; });
  last = kNone;
  for (std::uint32_t slot : hidden) {
    codeRising(io, models.hiddenGap, last, slot);
    last = slot;
    s.stream.elements[slot].hidden = true;
  }
  s.statistics.freedBits = io.coder.cost() - before;
  std::uint32_t mark = kEndMark;
  io.plain(mark, kEndBits);

  s.statistics.freshElements = static_cast<std::uint32_t>(fresh.size());
  s.statistics.movedPlaces = static_cast<std::uint32_t>(moved.size());
  s.statistics.freedElements = static_cast<std::uint32_t>(gone.size());
  s.statistics.hiddenElements = static_cast<std::uint32_t>(hidden.size());
  s.statistics.objects = static_cast<std::uint32_t>(objects.size());
  std::vector<std::uint8_t> bytes = io.coder.finish();
  s.statistics.bytes = bytes.size();
  return bytes;
}

}  // namespace tessera::wire
