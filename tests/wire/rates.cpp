#include "tests/wire/rates.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "codec/wire/visible_mirror.hpp"
#include "tests/wire/other_codecs.hpp"

namespace tessera::test {

namespace {

double since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// In pixels, by the camera of the frame; w is the distance along its axis.
glm::dvec3 pixelOf(const wire::Camera& camera, const glm::dvec3& world) {
  const glm::dvec4& q = camera.orientation;
  const glm::dvec3 axis(q.x, q.y, q.z);
  const glm::dvec3 at = world - camera.eye;
  // Turned back by the quaternion.
  const glm::dvec3 twice = 2.0 * glm::cross(-axis, at);
  const glm::dvec3 eye = at + q.w * twice + glm::cross(-axis, twice);
  const double depth = -eye.z;
  return {(eye.x / depth - camera.slopes.x) / (camera.slopes.y - camera.slopes.x) * camera.width,
          (eye.y / depth - camera.slopes.z) / (camera.slopes.w - camera.slopes.z) * camera.height, depth};
}

// Elements are found by their words: no two have the same place. Compared are corners and points inside of
// each triangle, where they are in the picture.
double largestErrorOf(const Recording& recording, const Recording::Frame& frame,
                      const wire::VisibleMirror& mirror) {
  using Words = std::array<std::uint32_t, wire::kMostWords>;
  const bool rect = mirror.method() == wire::Method::Rect;
  std::map<Words, std::uint32_t> idOf;
  for (const wire::VisibleElement& element : frame.elements) {
    Words words = element.words;
    if (rect) words[1] &= 511u;
    // The engine keeps the place of a half that has gone.
    const bool over = !rect && (words[0] & 3u) == glsl::kTessOver;
    if (over && (words[1] & 4095u) == 0) words[3] = 0;
    if (over && ((words[1] >> 12) & 4095u) == 0) words[4] = 0;
    idOf[words] = element.id;
  }
  EXPECT_EQ(idOf.size(), frame.elements.size());
  constexpr std::array<std::array<double, 3>, 6> kPoints = {
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0.2, 0.1, 0.7}, {0.34, 0.33, 0.33}}};
  double largest = 0.0;
  for (const glsl::StreamedTriangle& triangle : mirror.triangles()) {
    if (triangle.owner == glsl::kNoOwner) continue;
    const std::uint32_t slot = glsl::ownerElement(triangle.owner);
    Words words{};
    if (rect) {
      words = {mirror.patches()[slot].origin, mirror.patches()[slot].level};
    } else {
      const glsl::StreamedTess& t = mirror.tess()[slot];
      words = {t.kind, t.size, t.form, t.place0, t.place1, t.piece};
    }
    const auto found = idOf.find(words);
    if (found == idOf.end()) {
      ADD_FAILURE() << "an element of the viewer's is not in the frame";
      return 1e9;
    }
    const wire::SourceElement& element = recording.source.elements[found->second];
    std::array<glm::dvec3, 3> exact;
    std::array<glm::dvec3, 3> sent;
    const std::array<std::uint32_t, 3> corners = {triangle.v0, triangle.v1, triangle.v2};
    for (std::uint32_t c = 0; c < 3; ++c) {
      const wire::SourceVertex& from =
          recording.source.vertices[element.vertex[glsl::ownerCorner(triangle.owner, c)]];
      const glsl::StreamedVertex& to = mirror.vertices()[corners[c]];
      exact[c] = frame.objects[from.object].world * glm::dvec4(from.position, 1.0);
      sent[c] = mirror.objects()[to.object].world * glm::dvec4(to.x, to.y, to.z, 1.0);
    }
    for (const auto& weights : kPoints) {
      glm::dvec3 a(0.0);
      glm::dvec3 b(0.0);
      for (std::size_t c = 0; c < 3; ++c) {
        a += weights[c] * exact[c];
        b += weights[c] * sent[c];
      }
      const glm::dvec3 from = pixelOf(frame.camera, a);
      const glm::dvec3 to = pixelOf(frame.camera, b);
      if (from.z < frame.camera.zNear || from.x < 0.0 || from.y < 0.0 || from.x > frame.camera.width ||
          from.y > frame.camera.height)
        continue;
      largest = std::max(largest, std::hypot(from.x - to.x, from.y - to.y));
    }
  }
  return largest;
}

void line(std::string& text, const char* what, const Rate& rate, std::size_t frames) {
  const auto ratio = [&](double sent) {
    return sent > 0.0 ? fmt::format("{:.2f}", rate.plain / sent) : std::string("-");
  };
  text += fmt::format("  {:<20}{:>11.0f}{:>11.0f}{:>9.0f}{:>8}{:>15}{:>16}\n", what, rate.plain, rate.sent,
                      rate.sent / static_cast<double>(std::max<std::size_t>(frames, 1)), ratio(rate.sent),
                      ratio(rate.meshoptimizer), ratio(rate.octree));
}

// What messages say, by plain means: elements and vertices that a frame has and the one before had not.
class PlainStream {
 public:
  explicit PlainStream(const Recording& recording) : recording_(recording) {}

  PlainMessage next(const Recording::Frame& frame) {
    const wire::GeometrySource& source = recording_.source;
    const wire::PixelBound bound = wire::boundOf(frame.camera, 0.1, 0.0);
    PlainMessage message;
    message.stride = 1 + wire::wordsOf(source.method);
    std::map<std::uint32_t, std::array<std::uint32_t, wire::kMostWords>> places;
    std::map<std::uint32_t, std::uint32_t> vertices;
    std::map<std::uint32_t, int> levels;
    for (const wire::VisibleElement& element : frame.elements) {
      places[element.id] = element.words;
      if (element.parent != wire::kNone) continue;
      const wire::SourceElement& from = source.elements[element.id];
      for (std::size_t part = 0; part < from.triangles; ++part) {
        std::array<glm::dvec3, 3> at;
        const std::array<std::uint32_t, 3> corners = {from.vertex[0], from.vertex[part + 1],
                                                      from.vertex[part + 2]};
        double stretch = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
          const wire::SourceVertex& v = source.vertices[corners[c]];
          at[c] = frame.objects[v.object].world * glm::dvec4(v.position, 1.0) - frame.camera.eye;
          stretch = std::max(stretch, wire::stretchOf(frame.objects[v.object].world));
        }
        const int level = bound.level(wire::distanceToTriangle(at[0], at[1], at[2]), stretch) - 1;
        for (const std::uint32_t corner : corners) {
          const auto [entry, added] = levels.emplace(corner, level);
          if (!added) entry->second = std::min(entry->second, level);
        }
      }
    }
    for (const auto& [id, words] : places) {
      const auto had = places_.find(id);
      if (had != places_.end() && had->second == words) continue;
      message.places.push_back(id);
      for (std::size_t i = 0; i + 1 < message.stride; ++i) message.places.push_back(words[i]);
      if (had != places_.end() || id >= source.elements.size()) continue;
      const wire::SourceElement& from = source.elements[id];
      const auto numberOf = [&](std::uint32_t vertex) {
        if (const auto old = vertices_.find(vertex); old != vertices_.end()) return old->second;
        const auto [entry, added] = vertices.emplace(vertex, count_);
        if (!added) return entry->second;
        const int level = wire::levelFor(source.vertices[vertex].position, levels[vertex]);
        message.vertices.push_back(wire::stepsOf(source.vertices[vertex].position, level));
        message.levels.push_back(level);
        message.numbers.push_back(count_);
        return count_++;
      };
      for (std::size_t part = 0; part < from.triangles; ++part)
        for (const std::uint32_t vertex : {from.vertex[0], from.vertex[part + 1], from.vertex[part + 2]})
          message.triangles.push_back(numberOf(vertex));
    }
    for (const auto& [id, words] : places_)
      if (!places.contains(id)) message.freed.push_back(id);
    // Vertices go with their last element.
    for (auto at = vertices_.begin(); at != vertices_.end();)
      at = levels.contains(at->first) ? std::next(at) : vertices_.erase(at);
    vertices_.merge(vertices);
    places_ = std::move(places);
    return message;
  }

 private:
  const Recording& recording_;
  std::map<std::uint32_t, std::array<std::uint32_t, wire::kMostWords>> places_;
  std::map<std::uint32_t, std::uint32_t> vertices_;  // numbers of those that the viewer has
  std::uint32_t count_ = 0;
};

}  // namespace

Rates ratesOf(const Recording& recording, std::uint32_t keepFrames) {
  Rates rates;
  rates.frames = recording.frames.size();
  wire::VisibleDelta delta(recording.source, {.keepFrames = keepFrames});
  PlainStream others(recording);
  wire::VisibleMirror mirror(recording.source.method, {32767, 65535});
  std::vector<double> encode;
  std::vector<double> decode;
  const double word = 4.0 + 4.0 * static_cast<double>(wire::wordsOf(recording.source.method));
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const Recording::Frame& frame = recording.frames[i];
    const wire::VisibleFrame visible{
        frame.elements, frame.objects, {}, wire::boundOf(frame.camera, 0.1, 0.0), frame.camera.eye};
    auto start = std::chrono::steady_clock::now();
    const auto message = delta.next(visible);
    encode.push_back(since(start));
    start = std::chrono::steady_clock::now();
    const auto applied = mirror.apply(message);
    decode.push_back(since(start));
    if (!applied) {
      ADD_FAILURE() << applied.error().message;
      return rates;
    }
    const wire::DeltaStatistics& s = delta.statistics();
    const double places = s.freshElements + s.movedPlaces;
    const double plain = 16.0 * (s.freshVertices + s.deformedVertices) + 12.0 * s.freshTriangles +
                         word * places + 4.0 * s.freedElements + 100.0 * s.objects;
    rates.vertices.plain += 12.0 * (s.freshVertices + s.deformedVertices);
    rates.vertexIds.plain += 4.0 * (s.freshVertices + s.deformedVertices);
    rates.triangles.plain += 12.0 * s.freshTriangles;
    rates.places.plain += word * places;
    rates.freed.plain += 4.0 * s.freedElements;
    rates.objects.plain += 100.0 * s.objects;
    rates.vertices.sent += s.vertexBits / 8.0;
    rates.triangles.sent += s.triangleBits / 8.0;
    rates.places.sent += s.placeBits / 8.0;
    rates.freed.sent += s.freedBits / 8.0;
    rates.objects.sent += s.objectBits / 8.0;
    const PlainMessage content = others.next(frame);
    for (double Rate::*const codec : {&Rate::meshoptimizer, &Rate::octree}) {
      const PlainBits bits = codec == &Rate::octree ? octreeGolombBits(content) : meshoptimizerBits(content);
      rates.vertices.*codec += bits.vertices / 8.0;
      rates.vertexIds.*codec += bits.numbers / 8.0;
      rates.triangles.*codec += bits.triangles / 8.0;
      rates.places.*codec += bits.places / 8.0;
      rates.freed.*codec += bits.freed / 8.0;
      Rate& whole = i == 0 ? rates.first : rates.rest;
      whole.*codec += (bits.vertices + bits.numbers + bits.triangles + bits.places + bits.freed) / 8.0;
    }
    Rate& part = i == 0 ? rates.first : rates.rest;
    part.plain += plain;
    part.sent += static_cast<double>(message.size());
    rates.freshVertices += s.freshVertices;
    rates.refinedVertices += s.refinedVertices;
    rates.freshTriangles += s.freshTriangles;
    rates.freshElements += s.freshElements;
    rates.movedPlaces += s.movedPlaces;
    rates.largestError = std::max(rates.largestError, largestErrorOf(recording, frame, mirror));
  }
  rates.encodeMs = median(encode);
  rates.decodeMs = median(decode);
  return rates;
}

std::string table(const Rates& rates) {
  std::string text = fmt::format("  {:<20}{:>11}{:>11}{:>9}{:>8}{:>15}{:>16}\n", "", "plain", "sent",
                                 "a frame", "ratio", "meshoptimizer", "octree, Golomb");
  line(text, "vertex coordinates", rates.vertices, rates.frames);
  line(text, "vertex numbers", rates.vertexIds, rates.frames);
  line(text, "triangles", rates.triangles, rates.frames);
  line(text, "atlas coordinates", rates.places, rates.frames);
  line(text, "freed", rates.freed, rates.frames);
  line(text, "objects", rates.objects, rates.frames);
  Rate whole = rates.first;
  for (double Rate::*const of : {&Rate::plain, &Rate::sent, &Rate::meshoptimizer, &Rate::octree})
    whole.*of += rates.rest.*of;
  line(text, "together", whole, rates.frames);
  line(text, "first message", rates.first, 1);
  line(text, "all others", rates.rest, rates.frames - 1);
  text += fmt::format(
      "  largest error {:.4f} pixels; {} vertices ({:.1f} bits each), {} refined, {} "
      "triangles ({:.1f} "
      "bits), {} elements new, {} moved ({:.1f} bits a place); encode {:.1f} ms, decode {:.1f} ms a frame\n",
      rates.largestError, rates.freshVertices,
      8.0 * rates.vertices.sent / static_cast<double>(std::max<std::uint64_t>(rates.freshVertices, 1)),
      rates.refinedVertices, rates.freshTriangles,
      8.0 * rates.triangles.sent / static_cast<double>(std::max<std::uint64_t>(rates.freshTriangles, 1)),
      rates.freshElements, rates.movedPlaces,
      8.0 * rates.places.sent /
          static_cast<double>(std::max<std::uint64_t>(rates.freshElements + rates.movedPlaces, 1)),
      rates.encodeMs, rates.decodeMs);
  return text;
}

}  // namespace tessera::test
