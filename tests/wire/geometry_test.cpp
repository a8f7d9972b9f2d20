// The two ends of a geometry stream against a model of what a viewer must have, kept by plain loops.
#include <map>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "codec/wire/visible_mirror.hpp"
#include "tests/wire/random_world.hpp"

namespace tessera::test {
namespace {

// A triangle as a viewer draws it: corners' places and objects to the bit, which corners they are, its place
// and style.
using Corner = std::tuple<float, float, float, std::uint32_t>;
using Drawn =
    std::tuple<std::array<Corner, 3>, std::uint32_t, std::array<std::uint32_t, kMostWords>, std::uint32_t>;
// A piece: corners of its triangle, its words.
using Piece = std::tuple<std::array<Corner, 3>, std::array<std::uint32_t, kMostWords>>;
struct Scene {
  std::multiset<Drawn> drawn;
  std::multiset<Piece> pieces;
  bool operator==(const Scene&) const = default;
};

/// What the viewer must have: levels by the rule, everything else as the frame has it.
class NaiveViewer {
 public:
  NaiveViewer(int headroom, std::uint32_t keepFrames) : headroom_(headroom), keepFrames_(keepFrames) {}

  void apply(const GeometrySource& source, const VisibleFrame& frame) {
    std::map<std::uint32_t, int> wanted;
    for (const VisibleElement& shown : frame.elements) {
      if (shown.parent != kNone) continue;
      const SourceElement& element = source.elements[shown.id];
      for (std::uint32_t part = 0; part < element.triangles; ++part) {
        std::array<glm::dvec3, 3> at;
        double stretch = 0.0;
        const std::array<std::uint32_t, 3> corners = {0, part + 1, part + 2};
        // A patch's triangles share an object's largest stretch.
        for (std::uint32_t i = 0; i < element.triangles + 2u; ++i)
          stretch =
              std::max(stretch, stretchOf(frame.objects[source.vertices[element.vertex[i]].object].world));
        for (std::size_t i = 0; i < 3; ++i) {
          const SourceVertex& v = source.vertices[element.vertex[corners[i]]];
          at[i] = frame.objects[v.object].world * glm::dvec4(v.position, 1.0) - frame.eye;
        }
        const int level = frame.bound.level(distanceToTriangle(at[0], at[1], at[2]), stretch);
        for (const std::uint32_t corner : corners) {
          const auto [entry, added] = wanted.emplace(element.vertex[corner], level);
          if (!added) entry->second = std::min(entry->second, level);
        }
      }
    }
    // What a viewer remembers: elements that were whole when they were seen last, for so many frames.
    ++frame_;
    for (const VisibleElement& shown : frame.elements)
      if (shown.parent == kNone)
        lastSeen_[shown.id] = {frame_, source.method == Method::Rect || shown.words[5] == 0};
    std::map<std::uint32_t, std::set<std::uint32_t>> users;
    for (auto at = lastSeen_.begin(); at != lastSeen_.end();) {
      const std::uint32_t away = frame_ - at->second.first;
      if (away > 0 && (!at->second.second || away > keepFrames_)) {
        at = lastSeen_.erase(at);
        continue;
      }
      const SourceElement& element = source.elements[at->first];
      for (std::uint32_t i = 0; i < element.triangles + 2u; ++i) users[element.vertex[i]].insert(at->first);
      ++at;
    }
    std::map<std::uint32_t, Corner> next;
    std::map<std::uint32_t, int> nextLevels;
    for (const auto& [vertex, elements] : users) {
      const SourceVertex& v = source.vertices[vertex];
      const auto had = levels_.find(vertex);
      const auto asked = wanted.find(vertex);
      int use = had != levels_.end() ? had->second : levelFor(v.position, asked->second - headroom_);
      if (asked != wanted.end() && use > levelFor(v.position, asked->second))
        use = levelFor(v.position, asked->second - headroom_);
      use = levelFor(v.position, use);
      const glm::vec3 at = positionOf(stepsOf(v.position, use), use);
      next[vertex] = {at.x, at.y, at.z, v.object};
      nextLevels[vertex] = use;
    }
    corners_ = std::move(next);
    levels_ = std::move(nextLevels);
    scene_ = {};
    std::map<std::uint32_t, std::array<Corner, 3>> triangles;
    for (const VisibleElement& shown : frame.elements) {
      if (shown.parent != kNone) continue;
      const SourceElement& e = source.elements[shown.id];
      for (std::uint32_t part = 0; part < e.triangles; ++part) {
        std::array<Corner, 3> at = {corners_[e.vertex[0]], corners_[e.vertex[part + 1]],
                                    corners_[e.vertex[part + 2]]};
        if (e.mirrored) std::swap(at[1], at[2]);
        auto words = shown.words;
        words = sent(source.method, words);
        scene_.drawn.emplace(at, part | (e.triangles == 3 ? 4u : 0u) | (e.mirrored ? 8u : 0u), words,
                             e.style);
        triangles[shown.id] = at;
      }
    }
    for (const VisibleElement& shown : frame.elements)
      if (shown.parent != kNone)
        scene_.pieces.emplace(triangles[shown.parent], sent(source.method, shown.words));
  }
  [[nodiscard]] const Scene& scene() const { return scene_; }

 private:
  // A patch's level without the server's bits; of a triangle what its kind has.
  static std::array<std::uint32_t, kMostWords> sent(Method method,
                                                    std::array<std::uint32_t, kMostWords> words) {
    if (method == Method::Rect) {
      words[1] &= 511u;
      return words;
    }
    const bool over = (words[0] & 3u) == glsl::kTessOver;
    if (!over) words[1] = words[2] = words[4] = 0;
    if (over && (words[1] & 4095u) == 0) words[3] = 0;
    if (over && ((words[1] >> 12) & 4095u) == 0) words[4] = 0;
    return words;
  }
  int headroom_;
  std::uint32_t keepFrames_;
  std::uint32_t frame_ = 0;
  std::map<std::uint32_t, std::pair<std::uint32_t, bool>> lastSeen_;  // frame, and whether it was whole
  std::map<std::uint32_t, int> levels_;
  std::map<std::uint32_t, Corner> corners_;
  Scene scene_;
};

/// What a viewer draws of the mirror's arrays.
Scene drawnOf(const VisibleMirror& mirror) {
  Scene scene;
  const auto cornerOf = [&](std::uint32_t vertex) -> Corner {
    const glsl::StreamedVertex& v = mirror.vertices()[vertex];
    return {v.x, v.y, v.z, v.object};
  };
  const auto wordsOf = [&](std::uint32_t element) -> std::array<std::uint32_t, kMostWords> {
    if (mirror.method() == Method::Rect)
      return {mirror.patches()[element].origin, mirror.patches()[element].level, 0, 0, 0, 0};
    const glsl::StreamedTess& t = mirror.tess()[element];
    return {t.kind, t.size, t.form, t.place0, t.place1, t.piece};
  };
  for (std::uint32_t number = 0; number < mirror.triangles().size(); ++number) {
    const glsl::StreamedTriangle& t = mirror.triangles()[number];
    if (t.owner == glsl::kNoOwner) continue;
    const std::uint32_t element = glsl::ownerElement(t.owner);
    const std::uint32_t style =
        mirror.method() == Method::Rect ? mirror.patches()[element].style : mirror.tess()[element].style;
    const std::array<Corner, 3> corners = {cornerOf(t.v0), cornerOf(t.v1), cornerOf(t.v2)};
    scene.drawn.emplace(corners, t.owner & 15u, wordsOf(element), style);
    if (mirror.method() != Method::Tess) continue;
    EXPECT_EQ(mirror.tess()[element].triangle, number);
    // As a shader finds them: a split triangle's block of the table.
    const std::uint32_t n = mirror.tess()[element].piece;
    for (std::uint32_t i = 0; i < n * n; ++i) {
      const std::uint32_t piece = mirror.pieces()[mirror.tess()[element].firstPiece + i];
      if (piece == kNone) continue;
      EXPECT_EQ(mirror.tess()[piece].piece, glsl::packPiece(n, i));
      EXPECT_EQ(mirror.tess()[piece].triangle, number);
      scene.pieces.emplace(corners, wordsOf(piece));
    }
  }
  return scene;
}

class GeometryStream : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, GeometryStream, testing::Values(Method::Rect, Method::Tess),
                         [](const auto& method) { return method.param == Method::Rect ? "Rect" : "Tess"; });

constexpr AtlasSize kAtlas{RandomWorld::kAtlasWidth, RandomWorld::kAtlasHeight};

TEST_P(GeometryStream, ViewersHaveWhatIsVisibleFrameByFrame) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    RandomWorld world(GetParam(), seed);
    const int headroom = static_cast<int>(seed % 3);
    const std::uint32_t keep = seed % 2 == 0 ? 0 : 9;
    NaiveViewer naive(headroom, keep);
    VisibleDelta delta(world.source, {headroom, keep, 1u << 20});
    VisibleMirror mirror(GetParam(), kAtlas);
    // Copies of the arrays that only take what is said to be dirty, as a viewer's buffers do.
    std::vector<glsl::StreamedVertex> vertices;
    std::vector<glsl::StreamedTriangle> triangles;
    std::uint64_t freed = 0, refined = 0, deformed = 0, moved = 0;
    for (int frame = 0; frame < 300; ++frame) {
      world.step();
      const VisibleFrame visible = world.frame();
      naive.apply(world.source, visible);
      const auto message = delta.next(visible);
      freed += delta.statistics().freedElements;
      refined += delta.statistics().refinedVertices;
      deformed += delta.statistics().deformedVertices;
      moved += delta.statistics().movedPlaces;
      const auto dirty = mirror.apply(message);
      ASSERT_TRUE(dirty) << dirty.error().message << " in frame " << frame;
      ASSERT_GE(mirror.liveElements(), world.visible.size());
      if (keep == 0) {
        ASSERT_EQ(mirror.liveElements(), world.visible.size());
      }
      ASSERT_EQ(drawnOf(mirror), naive.scene()) << "seed " << seed << ", frame " << frame;
      for (std::size_t i = 0; i < world.objects.size(); ++i) ASSERT_EQ(mirror.objects()[i], world.objects[i]);
      vertices.resize(mirror.vertices().size());
      triangles.resize(mirror.triangles().size());
      for (std::uint32_t i = dirty->vertices.first; i < dirty->vertices.last; ++i)
        vertices[i] = mirror.vertices()[i];
      for (std::uint32_t i = dirty->triangles.first; i < dirty->triangles.last; ++i)
        triangles[i] = mirror.triangles()[i];
      ASSERT_EQ(std::memcmp(vertices.data(), mirror.vertices().data(), vertices.size() * sizeof(vertices[0])),
                0);
      ASSERT_EQ(
          std::memcmp(triangles.data(), mirror.triangles().data(), triangles.size() * sizeof(triangles[0])),
          0);
      // A viewer that comes late gets all of it in its first message.
      if (frame % 60 != 59) continue;
      VisibleDelta late(world.source, {headroom, keep, 1u << 20});
      VisibleMirror other(GetParam(), kAtlas);
      NaiveViewer fresh(headroom, keep);
      fresh.apply(world.source, visible);
      ASSERT_TRUE(other.apply(late.next(visible)));
      ASSERT_EQ(drawnOf(other), fresh.scene()) << "late in frame " << frame;
    }
    EXPECT_GT(freed, 1500u);
    EXPECT_GT(refined, 100u);
    EXPECT_GT(deformed, 100u);
    EXPECT_GT(moved, 1000u);
    // Numbers are used again: arrays are no longer than the most that was ever live, and the elements of a
    // message.
    EXPECT_LT(mirror.triangles().size(), 2u * 3u * world.source.elements.size() + 8u * glsl::kSplitBlock);
  }
}

TEST_P(GeometryStream, NothingNewIsAFewBytes) {
  RandomWorld world(GetParam(), 9);
  world.step();
  VisibleDelta delta(world.source);
  delta.next(world.frame());
  world.deformed.clear();
  EXPECT_LE(delta.next(world.frame()).size(), 9u);
}

TEST_P(GeometryStream, AnEmptyViewIsAMessageToo) {
  RandomWorld world(GetParam(), 10);
  VisibleDelta delta(world.source, {.keepFrames = 0});
  VisibleMirror mirror(GetParam(), kAtlas);
  ASSERT_TRUE(mirror.apply(delta.next(world.frame())));
  EXPECT_EQ(mirror.liveElements(), 0u);
  world.step();
  ASSERT_TRUE(mirror.apply(delta.next(world.frame())));
  EXPECT_GT(mirror.liveElements(), 0u);
  world.visible.clear();
  ASSERT_TRUE(mirror.apply(delta.next(world.frame())));
  EXPECT_EQ(mirror.liveElements(), 0u);
  EXPECT_EQ(mirror.liveVertices(), 0u);
  EXPECT_EQ(mirror.liveTriangles(), 0u);
}

// What comes back in time costs its place alone, what was away for longer is sent again.
TEST_P(GeometryStream, RemembersWhatIsOutOfSightForAWhile) {
  RandomWorld world(GetParam(), 14);
  VisibleDelta delta(world.source, {.headroom = 8, .keepFrames = 5});
  VisibleMirror mirror(GetParam(), kAtlas);
  world.step();
  world.deformed.clear();
  for (auto& [id, element] : world.visible)
    if (GetParam() == Method::Tess) element.words[5] = 0;
  std::erase_if(world.visible, [](const auto& entry) { return entry.second.parent != kNone; });
  const auto seen = world.visible;
  const auto send = [&] {
    const auto applied = mirror.apply(delta.next(world.frame()));
    ASSERT_TRUE(applied) << applied.error().message;
  };
  send();
  const Scene whole = drawnOf(mirror);
  for (const int away : {1, 5, 6}) {
    world.visible.clear();
    for (int frame = 0; frame < away; ++frame) {
      send();
      EXPECT_TRUE(drawnOf(mirror).drawn.empty());
    }
    EXPECT_EQ(mirror.liveElements(), away < 6 ? seen.size() : 0u);
    world.visible = seen;
    send();
    EXPECT_EQ(delta.statistics().shownElements, away < 6 ? seen.size() : 0u);
    EXPECT_EQ(delta.statistics().freshElements, away < 6 ? 0u : seen.size());
    EXPECT_EQ(drawnOf(mirror), whole);
  }
}

/// Whatever is in the mirror can be drawn: no number leads out of an array.
void expectSafe(const VisibleMirror& mirror) {
  for (const glsl::StreamedTriangle& t : mirror.triangles()) {
    if (t.owner == glsl::kNoOwner) continue;
    ASSERT_LT(t.v0, mirror.vertices().size());
    ASSERT_LT(t.v1, mirror.vertices().size());
    ASSERT_LT(t.v2, mirror.vertices().size());
    ASSERT_LT(glsl::ownerElement(t.owner),
              mirror.method() == Method::Rect ? mirror.patches().size() : mirror.tess().size());
  }
  for (const glsl::StreamedVertex& v : mirror.vertices())
    ASSERT_TRUE(v.object < mirror.objects().size() || v.object == 0);
  for (const std::uint32_t piece : mirror.pieces())
    ASSERT_TRUE(piece == kNone || piece < mirror.tess().size());
  for (const glsl::StreamedTess& t : mirror.tess()) {
    ASSERT_LT(t.triangle, std::max<std::size_t>(mirror.triangles().size(), 1));
    if (t.firstPiece != 0) {
      ASSERT_LE(t.firstPiece + glsl::kSplitBlock, mirror.pieces().size());
    }
  }
}

TEST_P(GeometryStream, CutAndLengthenedMessagesAreErrors) {
  RandomWorld world(GetParam(), 11, 60);
  VisibleDelta delta(world.source);
  world.step();
  world.step();
  const auto message = delta.next(world.frame());
  for (std::size_t size = 0; size < message.size(); ++size) {
    VisibleMirror mirror(GetParam(), kAtlas);
    ASSERT_FALSE(mirror.apply(std::span(message).first(size)))
        << size << " of " << message.size() << " bytes";
    expectSafe(mirror);
    const auto again = mirror.apply(message);
    ASSERT_FALSE(again);
    EXPECT_NE(again.error().message.find("lost"), std::string::npos);
  }
  auto longer = message;
  longer.push_back(0);
  VisibleMirror mirror(GetParam(), kAtlas);
  const auto good = mirror.apply(longer);
  ASSERT_FALSE(good);
  EXPECT_NE(good.error().message.find("does not end"), std::string::npos) << good.error().message;
}

TEST_P(GeometryStream, CorruptMessagesAreErrorsOrSafeToDraw) {
  RandomWorld world(GetParam(), 12, 80);
  std::vector<std::vector<std::uint8_t>> messages;
  VisibleDelta delta(world.source);
  for (int i = 0; i < 12; ++i) {
    world.step();
    messages.push_back(delta.next(world.frame()));
  }
  int refused = 0;
  constexpr int kRuns = 3000;
  for (int run = 0; run < kRuns; ++run) {
    VisibleMirror mirror(GetParam(), kAtlas);
    const std::size_t bad = world.below(static_cast<std::uint32_t>(messages.size()));
    for (std::size_t i = 0; i < messages.size(); ++i) {
      auto bytes = messages[i];
      if (i == bad) {
        const std::uint32_t flips = 1 + world.below(3);
        for (std::uint32_t k = 0; k < flips; ++k)
          bytes[world.below(static_cast<std::uint32_t>(bytes.size()))] ^=
              static_cast<std::uint8_t>(1 + world.below(255));
      }
      const auto applied = mirror.apply(bytes);
      if (!applied) {
        ++refused;
        EXPECT_FALSE(applied.error().message.empty());
        break;
      }
    }
    expectSafe(mirror);
    if (testing::Test::HasFatalFailure()) return;
  }
  // Some changes are in the plain bits of positions, which any value fits.
  EXPECT_GT(refused, kRuns * 3 / 4);
}

TEST(GeometryMirror, MaskedElementsHaveMaskCoordinates) {
  GeometrySource source;
  for (int i = 0; i < 6; ++i)
    source.vertices.push_back(
        {{i, i % 2, -4}, 0, {0.1f * static_cast<float>(i), -2.5f * static_cast<float>(i)}});
  source.elements.push_back({{0, 1, 2}, 1, false, glsl::kStyleMasked | 7u << 16u});
  source.elements.push_back({{3, 4, 5}, 1, false, 0});
  const std::vector<VisibleElement> visible = {{0, {0u, 0u}, kNone}, {1, {1u, 0u}, kNone}};
  const std::vector<ObjectTransform> objects(1);
  VisibleDelta delta(source);
  VisibleMirror mirror(Method::Rect, kAtlas);
  ASSERT_TRUE(mirror.apply(delta.next({visible, objects, {}, {}, {}})));
  int masked = 0;
  for (const glsl::StreamedTriangle& t : mirror.triangles()) {
    const bool mask = (mirror.patches()[glsl::ownerElement(t.owner)].style & glsl::kStyleMasked) != 0;
    for (const std::uint32_t vertex : {t.v0, t.v1, t.v2}) {
      const glm::vec2 expected =
          mask ? source.vertices[static_cast<std::size_t>(std::lround(mirror.vertices()[vertex].x))].mask
               : glm::vec2(0.0f);
      EXPECT_LE(glm::length(mirror.maskCoordinates()[vertex] - expected), 0.75f / kMaskGrid);
    }
    masked += mask ? 1 : 0;
  }
  EXPECT_EQ(masked, 1);
}

TEST(GeometryMirror, SaysWhatIsWrong) {
  RandomWorld world(Method::Rect, 13);
  world.step();
  VisibleDelta delta(world.source);
  const auto message = delta.next(world.frame());
  VisibleMirror small(Method::Rect, {64, 64});
  const auto outside = small.apply(message);
  ASSERT_FALSE(outside);
  EXPECT_NE(outside.error().message.find("outside of the atlas of 64 x 64"), std::string::npos)
      << outside.error().message;
  VisibleMirror mirror(Method::Rect, kAtlas);
  const auto nothing = mirror.apply({});
  ASSERT_FALSE(nothing);
  EXPECT_NE(nothing.error().message.find("ends early"), std::string::npos) << nothing.error().message;
}

// Corners of patches and their places in the block, as PatchGeometry in glsl/shared/scene.h lists them.
TEST(StreamedGeometry, CornersLieWherePatchesHaveThem) {
  using glsl::uvec2;
  const auto side = [](bool triple, bool mirrored, std::uint32_t part, std::uint32_t corner) {
    return glsl::ownerSide(glsl::packOwner(5, part, triple, mirrored), corner);
  };
  EXPECT_EQ(side(false, false, 0, 0), uvec2(0, 0));
  EXPECT_EQ(side(false, false, 0, 1), uvec2(2, 0));
  EXPECT_EQ(side(false, false, 0, 2), uvec2(2, 2));
  EXPECT_EQ(side(false, false, 1, 1), uvec2(2, 2));
  EXPECT_EQ(side(false, false, 1, 2), uvec2(0, 2));
  EXPECT_EQ(side(false, true, 1, 1), uvec2(0, 2));
  EXPECT_EQ(side(false, true, 1, 2), uvec2(2, 2));
  EXPECT_EQ(side(true, false, 0, 0), uvec2(1, 0));
  EXPECT_EQ(side(true, false, 2, 1), uvec2(0, 2));
  EXPECT_EQ(side(true, false, 2, 2), uvec2(0, 0));
  EXPECT_EQ(side(true, true, 2, 1), uvec2(0, 0));
  // A block of 8 x 2 texels at (16, 6), transposed: the patch's x runs along the atlas's y. Half a texel
  // inside the edges.
  const glsl::StreamedPatch place{16u | 6u << 16u, glsl::packLevel(3, 1, true), 0, 0};
  EXPECT_EQ(glsl::streamedHalfTexel(place, glsl::packOwner(0, 0, false, false), 1), uvec2(33, 15));
  EXPECT_EQ(glsl::streamedHalfTexel(place, glsl::packOwner(0, 0, false, false), 2), uvec2(47, 15));
}

}  // namespace
}  // namespace tessera::test
