#include "atlas/rect/patches.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace tessera {
namespace {

using glm::dvec3;
using glsl::PatchGeometry;

constexpr std::uint32_t kFree = 0xffffffffu;

// A pair is visible wherever either half is, and is then shaded whole: past this angle between the normals
// too many shaded texels would belong to a half that faces away.
constexpr double kMinFoldCosine = 0.2588;  // 75 degrees
// Concave quads stretch more near the concave corner than the block area says; they are to be chosen last.
constexpr double kConcavePenalty = 1.25;
// A group may need this much more than its members alone (as a share of their sum) and is still formed: a
// patch less also spares a record, a draw entry and the rounding of a block to powers of two. Tuned on six
// scenes: from 0 to 0.25 triangles alone fall from 7.1 to 4.2 % on sponza for 0.6 % more block area; past
// that single large fans get costly.
constexpr double kMaxLoss = 0.25;
constexpr float kMinPairWeight = static_cast<float>(1.0 - kMaxLoss);
// Augmenting paths are searched up to this many pairs deep, and a search gives up after this many steps.
constexpr int kPathPairs = 5;
constexpr int kPathSteps = 400;
constexpr int kPathRounds = 3;
// An edge shared by many triangles gives each of them at most this many candidates.
constexpr std::size_t kEdgeCandidates = 4;
// Fans are tried over this many neighbours of a triangle; a manifold has three.
constexpr std::size_t kFanLinks = 8;

// The part of a block's map in one triangle: derivatives of position by the block's coordinates in 0..1, and
// which share of the block the triangle covers.
struct MapPart {
  dvec3 du;
  dvec3 dv;
  double share;
};

double mapBlockArea(std::span<const MapPart> parts) {
  double w2 = 0.0;
  double h2 = 0.0;
  for (const MapPart& part : parts) {
    w2 += part.share * glm::dot(part.du, part.du);
    h2 += part.share * glm::dot(part.dv, part.dv);
  }
  if (!(w2 > 0.0 && h2 > 0.0)) return 0.0;
  const double wh = std::sqrt(w2) * std::sqrt(h2);
  double worst = 0.0;  // largest squared stretch of a texel of a w x h block
  for (const MapPart& part : parts) {
    const double a = glm::dot(part.du, part.du) / w2;
    const double b = glm::dot(part.du, part.dv) / wh;
    const double c = glm::dot(part.dv, part.dv) / h2;
    worst = std::max(worst, 0.5 * (a + c + std::sqrt((a - c) * (a - c) + 4.0 * b * b)));
  }
  return wh * worst;
}

double singleArea(const dvec3& v0, const dvec3& v1, const dvec3& v2) {
  const std::array parts{MapPart{v1 - v0, v2 - v1, 1.0}};
  return mapBlockArea(parts);
}

double pairArea(const dvec3& v0, const dvec3& v1, const dvec3& v2, const dvec3& v3) {
  const std::array parts{MapPart{v1 - v0, v2 - v1, 0.5}, MapPart{v2 - v3, v3 - v0, 0.5}};
  return mapBlockArea(parts);
}

double tripleArea(const dvec3& v0, const dvec3& v1, const dvec3& v2, const dvec3& v3, const dvec3& v4) {
  const std::array parts{MapPart{2.0 * (v1 - v0), v2 - v1, 0.25}, MapPart{v2 - v3, 0.5 * (v2 + v3) - v0, 0.5},
                         MapPart{2.0 * (v0 - v4), v3 - v4, 0.25}};
  return mapBlockArea(parts);
}

// Two triangles that could become a pair, or part of a triple if the weight is below kMinPairWeight: the
// shared edge is edge `edgeA` of a and `edgeB` of b.
struct Candidate {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint8_t edgeA = 0;
  std::uint8_t edgeB = 0;
  float weight = 0.0f;  // 1 + share of block area that pairing saves: more pairs first, then better ones
};

struct Triangle {
  dvec3 normal{0.0};      // unit, zero if the triangle has no area
  double block = 0.0;     // block area when alone, with the best corner at v1
  std::uint8_t turn = 0;  // corner that becomes v0 then
};

class Builder {
 public:
  Builder(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices)
      : positions_(positions), indices_(indices), count_(static_cast<std::uint32_t>(indices.size() / 3)) {}

  PatchSet run(const PatchOptions& options) {
    measureTriangles();
    mate_.assign(count_, kFree);
    if (options.pair) {
      findCandidates();
      linkCandidates();
      matchGreedily();
      for (int round = 0; round < kPathRounds && augmentAll(); ++round) {
      }
    }
    third_.assign(count_, kFree);
    if (options.pair && options.triple) attachThirds();
    return emit();
  }

 private:
  [[nodiscard]] std::uint32_t vertex(std::uint32_t triangle, std::uint32_t corner) const {
    return indices_[std::size_t{3} * triangle + corner % 3u];
  }
  [[nodiscard]] dvec3 position(std::uint32_t index) const { return dvec3(positions_[index]); }
  [[nodiscard]] dvec3 corner(std::uint32_t triangle, std::uint32_t c) const {
    return position(vertex(triangle, c));
  }

  void measureTriangles() {
    triangles_.resize(count_);
    for (std::uint32_t t = 0; t < count_; ++t) {
      const std::array p{corner(t, 0), corner(t, 1), corner(t, 2)};
      Triangle& triangle = triangles_[t];
      const dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
      const double length = glm::length(n);
      if (length > 0.0) triangle.normal = n / length;
      double bestLead = 0.0;
      for (std::uint8_t turn = 0; turn < 3; ++turn) {
        const dvec3 v0 = p[turn];
        const dvec3 v1 = p[(turn + 1) % 3];
        const dvec3 v2 = p[(turn + 2) % 3];
        const double area = singleArea(v0, v1, v2);
        const double lead = glm::length(v1 - v0) - glm::length(v2 - v1);
        const double tie = 1e-6 * triangle.block;
        if (turn == 0 || area < triangle.block - tie || (area <= triangle.block + tie && lead > bestLead)) {
          triangle.block = area;
          triangle.turn = turn;
          bestLead = lead;
        }
      }
    }
  }

  // The four corners of a candidate: v0-v2 is the shared edge, (v0, v1, v2) is triangle a.
  [[nodiscard]] std::array<std::uint32_t, 4> corners(const Candidate& c) const {
    return {vertex(c.a, c.edgeA + 1u), vertex(c.a, c.edgeA + 2u), vertex(c.a, c.edgeA),
            vertex(c.b, c.edgeB + 2u)};
  }

  // Whether the quad, unfolded around its diagonal v0-v2, has a corner of more than 180 degrees at an end of
  // it.
  static bool concave(const dvec3& v0, const dvec3& v1, const dvec3& v2, const dvec3& v3) {
    const auto reflex = [](const dvec3& diagonal, const dvec3& a, const dvec3& b) {
      return glm::length(glm::cross(a, diagonal)) * glm::dot(diagonal, b) +
                 glm::dot(a, diagonal) * glm::length(glm::cross(diagonal, b)) <
             0.0;
    };
    return reflex(v2 - v0, v1 - v0, v3 - v0) || reflex(v0 - v2, v1 - v2, v3 - v2);
  }

  // A patch of faces that lean apart is shaded whole as soon as one of them shows. Seen from all sides alike,
  // two faces at an angle f are in view together for 1 + f/pi as long as one alone.
  static double foldFactor(double cosine) {
    return 1.0 + std::acos(std::clamp(cosine, -1.0, 1.0)) * std::numbers::inv_pi;
  }

  // Share of block area that a group saves over its parts alone; not above -kMaxLoss or not a number: no
  // group.
  static double saving(double together, double apart) { return 1.0 - together / apart; }

  bool weigh(Candidate& c) const {
    const Triangle& a = triangles_[c.a];
    const Triangle& b = triangles_[c.b];
    const double cosine = glm::dot(a.normal, b.normal);
    if (!(cosine >= kMinFoldCosine))
      return false;  // also refuses triangles without area: they are never seen
    const std::array<std::uint32_t, 4> v = corners(c);
    const std::array p{position(v[0]), position(v[1]), position(v[2]), position(v[3])};
    double together = pairArea(p[0], p[1], p[2], p[3]) * foldFactor(cosine);
    if (concave(p[0], p[1], p[2], p[3])) together *= kConcavePenalty;
    c.weight = static_cast<float>(1.0 + saving(together, a.block + b.block));
    return std::isfinite(c.weight);
  }

  void findCandidates() {
    struct HalfEdge {
      std::uint64_t key;   // lower vertex, higher vertex
      std::uint32_t edge;  // 4 * triangle + number of the edge
      bool up;             // runs from the lower to the higher vertex
    };
    std::vector<HalfEdge> edges;
    edges.reserve(indices_.size());
    for (std::uint32_t t = 0; t < count_; ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t from = vertex(t, e);
        const std::uint32_t to = vertex(t, e + 1);
        if (from == to) continue;
        const std::uint64_t key = std::uint64_t{std::min(from, to)} << 32 | std::max(from, to);
        edges.push_back({key, 4 * t + e, from < to});
      }
    }
    std::sort(edges.begin(), edges.end(), [](const HalfEdge& x, const HalfEdge& y) {
      if (x.key != y.key) return x.key < y.key;
      if (x.up != y.up) return x.up;
      return x.edge < y.edge;
    });
    for (std::size_t first = 0; first < edges.size();) {
      std::size_t last = first;
      std::size_t middle = first;
      for (; last < edges.size() && edges[last].key == edges[first].key; ++last)
        middle += edges[last].up ? 1 : 0;
      const std::size_t ups = middle - first;
      const std::size_t downs = last - middle;
      const std::size_t tries = std::min(downs, kEdgeCandidates);
      for (std::size_t i = 0; i < ups; ++i) {
        for (std::size_t k = 0; k < tries; ++k) {
          const std::uint32_t x = edges[first + i].edge;
          const std::uint32_t y = edges[middle + (i + k) % downs].edge;
          Candidate c{x / 4, y / 4, static_cast<std::uint8_t>(x % 4), static_cast<std::uint8_t>(y % 4), 0.0f};
          if (c.a == c.b) continue;
          if (c.a > c.b) {
            std::swap(c.a, c.b);
            std::swap(c.edgeA, c.edgeB);
          }
          if (weigh(c)) candidates_.push_back(c);
        }
      }
      first = last;
    }
  }

  void linkCandidates() {
    linkStart_.assign(std::size_t{count_} + 1, 0);
    for (const Candidate& c : candidates_) {
      ++linkStart_[c.a];
      ++linkStart_[c.b];
    }
    std::exclusive_scan(linkStart_.begin(), linkStart_.end(), linkStart_.begin(), 0u);
    links_.resize(2 * candidates_.size());
    std::vector<std::uint32_t> next(linkStart_.begin(), linkStart_.end() - 1);
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
      links_[next[candidates_[i].a]++] = i;
      links_[next[candidates_[i].b]++] = i;
    }
  }

  [[nodiscard]] std::span<const std::uint32_t> links(std::uint32_t triangle) const {
    return std::span(links_).subspan(linkStart_[triangle], linkStart_[triangle + 1] - linkStart_[triangle]);
  }
  [[nodiscard]] std::uint32_t other(std::uint32_t candidate, std::uint32_t triangle) const {
    const Candidate& c = candidates_[candidate];
    return c.a == triangle ? c.b : c.a;
  }

  void match(std::uint32_t candidate) {
    mate_[candidates_[candidate].a] = candidate;
    mate_[candidates_[candidate].b] = candidate;
  }

  void matchGreedily() {
    std::vector<std::uint32_t> byWeight;
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
      if (candidates_[i].weight > kMinPairWeight) byWeight.push_back(i);
    }
    std::sort(byWeight.begin(), byWeight.end(), [this](std::uint32_t x, std::uint32_t y) {
      const Candidate& a = candidates_[x];
      const Candidate& b = candidates_[y];
      return a.weight != b.weight ? a.weight > b.weight : x < y;
    });
    for (const std::uint32_t i : byWeight) {
      if (mate_[candidates_[i].a] == kFree && mate_[candidates_[i].b] == kFree) match(i);
    }
  }

  // Alternating paths from a free triangle: take a neighbour from its mate, look for another partner for the
  // mate, and so on. `best` becomes the path of most gain, as the candidates to match; their old mates are
  // freed.
  struct Search {
    std::vector<std::uint32_t> path;
    std::vector<std::uint32_t> best;
    float gain = 1e-4f;  // a path has to gain more than rounding
    int steps = kPathSteps;
  };

  void search(std::uint32_t free, int depth, float gained, Search& s) {
    onPath_[free] = true;
    for (const std::uint32_t link : links(free)) {
      if (--s.steps < 0) break;
      const std::uint32_t next = other(link, free);
      if (onPath_[next] || candidates_[link].weight <= kMinPairWeight) continue;
      const std::uint32_t oldLink = mate_[next];
      const float before = oldLink == kFree ? 0.0f : candidates_[oldLink].weight;
      const float total = gained + candidates_[link].weight - before;
      s.path.push_back(link);
      if (total > s.gain) {
        s.gain = total;
        s.best = s.path;
      }
      if (oldLink != kFree && depth > 1) {
        onPath_[next] = true;
        search(other(oldLink, next), depth - 1, total, s);
        onPath_[next] = false;
      }
      s.path.pop_back();
    }
    onPath_[free] = false;
  }

  bool augmentAll() {
    onPath_.assign(count_, false);
    bool changed = false;
    for (std::uint32_t t = 0; t < count_; ++t) {
      if (mate_[t] != kFree || links(t).empty()) continue;
      Search s;
      search(t, kPathPairs, 0.0f, s);
      for (const std::uint32_t link : s.best) {
        for (const std::uint32_t end : {candidates_[link].a, candidates_[link].b}) {
          if (mate_[end] != kFree) mate_[other(mate_[end], end)] = kFree;
        }
        match(link);
        changed = true;
      }
    }
    return changed;
  }

  // Three triangles around a common vertex v.front(), in the order of a triple's layout.
  struct Fan {
    std::array<std::uint32_t, 5> v;
    std::array<std::uint32_t, 3> triangles;
  };

  [[nodiscard]] std::uint8_t edgeIn(const Candidate& c, std::uint32_t triangle) const {
    return c.a == triangle ? c.edgeA : c.edgeB;
  }

  // The fan of `middle` and its neighbours by two links, which must lie on different edges.
  [[nodiscard]] Fan fan(std::uint32_t middle, std::uint32_t linkA, std::uint32_t linkB) const {
    // With the middle triangle as (v0, v2, v3) the first triangle lies across v0-v2 and the last across
    // v3-v0: the first edge is the one that follows the last.
    const bool aFirst = (edgeIn(candidates_[linkA], middle) + 2) % 3 == edgeIn(candidates_[linkB], middle);
    const std::uint32_t firstLink = aFirst ? linkA : linkB;
    const std::uint32_t lastLink = aFirst ? linkB : linkA;
    const std::uint32_t first = other(firstLink, middle);
    const std::uint32_t last = other(lastLink, middle);
    const std::uint8_t edge = edgeIn(candidates_[firstLink], middle);
    return {{vertex(middle, edge), vertex(first, edgeIn(candidates_[firstLink], first) + 2u),
             vertex(middle, edge + 1u), vertex(middle, edge + 2u),
             vertex(last, edgeIn(candidates_[lastLink], last) + 2u)},
            {first, middle, last}};
  }

  [[nodiscard]] double fanBlockArea(const Fan& f) const {
    double cosine = 1.0;
    for (const auto& [x, y] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 2}}) {
      cosine = std::min(cosine, glm::dot(triangles_[f.triangles[static_cast<std::size_t>(x)]].normal,
                                         triangles_[f.triangles[static_cast<std::size_t>(y)]].normal));
    }
    if (!(cosine >= kMinFoldCosine)) return -1.0;
    return foldFactor(cosine) * tripleArea(position(f.v[0]), position(f.v[1]), position(f.v[2]),
                                           position(f.v[3]), position(f.v[4]));
  }

  struct Offer {
    Fan fan;
    double gain = 0.0;
  };

  // Adds the fan to the offers if it is worth it against its parts, which need blocks of `apart` in all.
  void offerFan(std::uint32_t middle, std::uint32_t linkA, std::uint32_t linkB, double apart,
                std::vector<Offer>& offers) const {
    // Three on one edge are no fan, and around two vertices of one edge the outer two may be one triangle.
    if (edgeIn(candidates_[linkA], middle) == edgeIn(candidates_[linkB], middle)) return;
    if (other(linkA, middle) == other(linkB, middle)) return;
    const Fan f = fan(middle, linkA, linkB);
    const double together = fanBlockArea(f);
    if (together < 0.0) return;
    const double gain = saving(together, apart);
    if (gain > -kMaxLoss) offers.push_back({f, gain});
  }

  // Free triangles join a neighbouring pair, or two free neighbours that make no pair.
  void attachThirds() {
    std::vector<Offer> offers;
    for (std::uint32_t t = 0; t < count_; ++t) {
      if (mate_[t] != kFree) continue;
      for (std::size_t i = 0; i < std::min(links(t).size(), kFanLinks); ++i) {
        const std::uint32_t link = links(t)[i];
        const std::uint32_t neighbour = other(link, t);
        const double both = triangles_[t].block + triangles_[neighbour].block;
        if (mate_[neighbour] != kFree) {
          const Candidate& pair = candidates_[mate_[neighbour]];
          const double pairBlock = (2.0 - static_cast<double>(pair.weight)) *
                                   (triangles_[pair.a].block + triangles_[pair.b].block);
          offerFan(neighbour, link, mate_[neighbour], pairBlock + triangles_[t].block, offers);
          continue;
        }
        for (std::size_t j = 0; j < i; ++j) {
          const std::uint32_t third = other(links(t)[j], t);
          if (mate_[third] == kFree) offerFan(t, link, links(t)[j], both + triangles_[third].block, offers);
        }
      }
    }
    std::stable_sort(offers.begin(), offers.end(),
                     [](const Offer& x, const Offer& y) { return x.gain > y.gain; });
    for (const Offer& offer : offers) {
      const auto& members = offer.fan.triangles;
      if (std::any_of(members.begin(), members.end(), [&](std::uint32_t t) { return third_[t] != kFree; }))
        continue;
      for (const std::uint32_t t : members) third_[t] = static_cast<std::uint32_t>(fans_.size());
      fans_.push_back(offer.fan);
    }
  }

  PatchSet emit() const {
    PatchSet set;
    set.patches.reserve(count_);
    set.order.reserve(count_);
    for (std::uint32_t t = 0; t < count_; ++t) {
      if (mate_[t] == kFree || third_[t] != kFree) continue;
      const Candidate& c = candidates_[mate_[t]];
      if (c.a != t) continue;
      const std::array<std::uint32_t, 4> v = corners(c);
      set.patches.push_back({v[0], v[1], v[2], v[3], v[0], 2});
      set.order.insert(set.order.end(), {c.a, c.b});
      ++set.pairs;
    }
    for (std::uint32_t t = 0; t < count_; ++t) {
      if (third_[t] == kFree) continue;
      const Fan& f = fans_[third_[t]];
      if (*std::min_element(f.triangles.begin(), f.triangles.end()) != t) continue;
      set.patches.push_back({f.v[0], f.v[1], f.v[2], f.v[3], f.v[4], 3});
      set.order.insert(set.order.end(), f.triangles.begin(), f.triangles.end());
      ++set.triples;
    }
    for (std::uint32_t t = 0; t < count_; ++t) {
      if (mate_[t] != kFree || third_[t] != kFree) continue;
      const std::uint32_t turn = triangles_[t].turn;
      const std::uint32_t v0 = vertex(t, turn);
      const std::uint32_t v1 = vertex(t, turn + 1u);
      set.patches.push_back({v0, v1, vertex(t, turn + 2u), v1, v0, 1});
      set.order.push_back(t);
      ++set.singles;
    }
    return set;
  }

  std::span<const glm::vec3> positions_;
  std::span<const std::uint32_t> indices_;
  std::uint32_t count_;
  std::vector<Triangle> triangles_;
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> linkStart_;  // first entry of links_ of each triangle
  std::vector<std::uint32_t> links_;      // candidates that a triangle is part of
  std::vector<std::uint32_t> mate_;       // candidate that a triangle is matched by
  std::vector<std::uint32_t> third_;      // fan that a triangle is in
  std::vector<Fan> fans_;
  std::vector<bool> onPath_;
};

}  // namespace

PatchSet buildPatches(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                      const PatchOptions& options) {
  assert(indices.size() % 3 == 0);
  return Builder(positions, indices).run(options);
}

double patchBlockArea(std::span<const glm::vec3> positions, const PatchGeometry& patch) {
  const auto p = [&](std::uint32_t v) { return dvec3(positions[v]); };
  if (patch.triangles == 1) return singleArea(p(patch.v0), p(patch.v1), p(patch.v2));
  if (patch.triangles == 2) return pairArea(p(patch.v0), p(patch.v1), p(patch.v2), p(patch.v3));
  return tripleArea(p(patch.v0), p(patch.v1), p(patch.v2), p(patch.v3), p(patch.v4));
}

}  // namespace tessera
