// A world of random patches or triangles, and random walks of what is visible in it.
#pragma once

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "codec/wire/visible_delta.hpp"
#include "glsl/shared/tess_atlas.h"
#include "glsl/shared/tess_split.h"

namespace tessera::test {

using namespace wire;

struct RandomWorld {
  std::mt19937 random;
  GeometrySource source;
  std::vector<ObjectTransform> objects;
  std::map<std::uint32_t, VisibleElement> visible;
  std::vector<std::uint32_t> deformed;
  PixelBound bound;
  glm::dvec3 eye{0.0};

  static constexpr std::uint32_t kAtlasWidth = 2048;
  static constexpr std::uint32_t kAtlasHeight = 1024;

  std::uint32_t below(std::uint32_t count) {
    return std::uniform_int_distribution<std::uint32_t>(0, count - 1)(random);
  }
  float within(float least, float most) { return std::uniform_real_distribution<float>(least, most)(random); }
  bool chance(double share) { return std::uniform_real_distribution<double>(0.0, 1.0)(random) < share; }

  RandomWorld(Method method, unsigned seed, std::uint32_t elements = 400) : random(seed) {
    source.method = method;
    objects.resize(5);
    const std::uint32_t vertices = elements / 2 + 6;
    for (std::uint32_t i = 0; i < vertices; ++i) {
      SourceVertex v;
      v.position = {within(-9, 9), within(-3, 3), within(-9, 9)};
      if (i % 50 == 7) v.position *= 1e5f;  // coordinates that floats hold coarsely
      if (i % 61 == 5) v.position = glm::vec3(0.0f);
      v.object = i * static_cast<std::uint32_t>(objects.size()) / vertices;
      v.mask = {within(-2, 2), within(-2, 2)};
      source.vertices.push_back(v);
    }
    for (std::uint32_t i = 0; i < elements; ++i) {
      SourceElement e;
      e.triangles = static_cast<std::uint8_t>(method == Method::Rect ? 1 + below(3) : 1);
      if (i % 37 == 3) e.triangles = 0;
      const std::uint32_t near = below(vertices - 6);
      for (auto& vertex : e.vertex) vertex = chance(0.1) ? below(vertices) : near + below(6);
      e.mirrored = chance(0.2);
      e.style = (i / 40) % 3 == 0   ? 0
                : (i / 40) % 3 == 1 ? glsl::kStyleMasked | 3u << 16u
                                    : glsl::kStyleTransparent | 99u << 8u;
      source.elements.push_back(e);
    }
    bound.reach = 0.1;
  }

  std::array<std::uint32_t, kMostWords> somePlace() {
    std::array<std::uint32_t, kMostWords> words{};
    if (source.method == Method::Rect) {
      const std::uint32_t w = below(7);
      const std::uint32_t h = below(w + 1);
      const std::uint32_t grid = chance(0.9) ? 0 : 1;  // now and then off its own grid
      words[0] = ((below((kAtlasWidth >> w) - 1) << w) + grid) |
                 ((below((kAtlasHeight >> h) - 1) << h) + grid) << 16u;
      words[1] = glsl::packLevel(w, h, chance(0.3));
      return words;
    }
    const auto place = [&] { return glsl::packPlace(below(kAtlasWidth), below(kAtlasHeight), below(2)); };
    switch (below(3)) {
      case 0:
        words[0] = glsl::kTessSingle;
        break;
      case 1:
        words[0] = glsl::kindOfL(1 + below(64));
        break;
      default: {
        const glsl::TessShape shape =
            glsl::shapeOfOver({below(3), below(60), below(4) * below(60), below(40), below(65536)});
        words = {shape.kind, shape.size, shape.form, 0, place(), 0};
      }
    }
    words[3] = place();
    return words;
  }

  /// Everything moves on by a frame.
  void step() {
    eye += glm::dvec3(within(-0.4f, 0.4f), within(-0.1f, 0.1f), within(-0.4f, 0.4f));
    if (chance(0.3)) {
      const std::uint32_t moved = 1 + below(static_cast<std::uint32_t>(objects.size()) - 1);
      objects[moved].world[3] += glm::dvec3(within(-1, 1), 0.0, within(-1, 1));
      objects[moved].world[0] *= within(0.9f, 1.1f);
    }
    deformed.clear();
    if (chance(0.4))
      for (int i = 0; i < 9; ++i) {
        const std::uint32_t vertex = below(static_cast<std::uint32_t>(source.vertices.size()));
        if (std::find(deformed.begin(), deformed.end(), vertex) != deformed.end()) continue;
        source.vertices[vertex].position += glm::vec3(within(-0.1f, 0.1f));
        deformed.push_back(vertex);
      }
    // Some go, some come; now and then all of them, or none.
    const double leave = chance(0.03) ? 1.0 : 0.08;
    const double come = chance(0.05) ? 0.7 : 0.06;
    const double move = chance(0.05) ? 1.0 : 0.05;
    for (auto at = visible.begin(); at != visible.end();) {
      const bool orphan = at->second.parent != kNone &&
                          (!visible.contains(at->second.parent) || visible[at->second.parent].words[5] == 0);
      if (orphan || chance(leave)) {
        at = visible.erase(at);
        continue;
      }
      if (chance(move)) {
        const std::uint32_t kept = at->second.words[5];
        at->second.words = somePlace();
        if (source.method == Method::Tess) at->second.words[5] = kept;
      }
      ++at;
    }
    for (std::uint32_t id = 0; id < source.elements.size(); ++id)
      if (source.elements[id].triangles > 0 && !visible.contains(id) && chance(come))
        visible[id] = {id, somePlace(), kNone};
    if (source.method == Method::Tess) stepPieces();
  }

  VisibleFrame frame() {
    flat.clear();
    for (const auto& [id, element] : visible) flat.push_back(element);
    std::shuffle(flat.begin(), flat.end(), random);
    return {flat, objects, deformed, bound, eye};
  }
  std::vector<VisibleElement> flat;

 private:
  // Up to eight triangles have pieces; a piece's number may come to belong to another triangle, as blocks of
  // numbers do.
  void stepPieces() {
    const auto first = static_cast<std::uint32_t>(source.elements.size());
    std::vector<std::uint32_t> triangles;
    for (const auto& [id, element] : visible)
      if (id < first) triangles.push_back(id);
    for (std::uint32_t block = 0; block < 8 && triangles.size() > 40; ++block) {
      if (!chance(0.3)) continue;
      for (std::uint32_t i = 0; i < glsl::kSplitBlock; ++i)
        visible.erase(first + block * glsl::kSplitBlock + i);
      const std::uint32_t owner = triangles[block * 5 + below(5)];
      const std::uint32_t n = 2 + below(15);
      for (auto at = visible.lower_bound(first); at != visible.end();)
        at = at->second.parent == owner ? visible.erase(at) : std::next(at);
      visible[owner].words[5] = n;
      for (std::uint32_t i = 0; i < n * n; ++i) {
        if (!chance(0.4)) continue;
        VisibleElement piece{first + block * glsl::kSplitBlock + i, somePlace(), owner};
        piece.words[5] = glsl::packPiece(n, i);
        visible[piece.id] = piece;
      }
    }
    for (auto at = visible.lower_bound(first); at != visible.end();)
      at = visible.contains(at->second.parent) ? std::next(at) : visible.erase(at);
  }
};

}  // namespace tessera::test
