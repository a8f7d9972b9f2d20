// What the engine asks of a way to fill an atlas: place the visible set, be shaded into by whoever owns the
// materials, and be drawn from for any view. The stages are apart, so that each runs at its own rate.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "atlas/visible_set.hpp"
#include "engine/gl/program.hpp"

namespace tessera {

enum class AtlasFormat : std::uint8_t {
  Srgb8,      // display-encoded 8 bits a channel: what a video codec takes
  Rgba16f,    // linear half floats: nothing is lost, and a value that is not finite can be found
  Rgb10a2,    // linear 10 bits a channel: dark colours have fewer steps than encoded 8 bits
  R11g11b10f  // linear floats with 6, 6 and 5 bits of mantissa: half of Rgba16f's memory
};

/// The texture that a gatherer fills.
struct AtlasTexture {
  gl::Texture texture;
  gl::Texture encoded;                 // a view of its encoded values, where the format has them
  gl::Framebuffer framebuffer;         // of texture
  gl::Framebuffer encodedFramebuffer;  // of encoded: what is written is encoded already
  AtlasFormat format = AtlasFormat::Srgb8;

  /// Cleared to zero. Fails when a side is past this context's limit.
  static Result<AtlasTexture> create(int width, int height, AtlasFormat format);
  /// The texture as display samples it: encoded values where the format has them, so that a fetch is a copy.
  [[nodiscard]] const gl::Texture& display() const { return encoded ? encoded : texture; }
};

/// Samples of one kind: how their texels were chosen.
struct GatherKind {
  std::string name;                     // what a report calls it
  std::array<std::uint8_t, 3> color{};  // in pictures of the atlas, display-encoded
  std::uint64_t samples = 0;            // texels shaded
};

/// How densely samples fill the places that were cut for them.
struct GatherPacking {
  std::string name;
  std::uint64_t samples = 0;  // texels shaded
  std::uint64_t texels = 0;   // of the places of what is visible
};

/// What the last allocate() asked for and where it went. What a gatherer does not know is absent, or 0.
struct GatherStatistics {
  std::uint64_t samples = 0;      // texels to shade
  std::vector<GatherKind> kinds;  // each sample is of one of them
  std::vector<GatherPacking> packings;
  std::uint64_t visible = 0;             // elements of the visible set
  std::optional<std::uint64_t> slanted;  // of them, triangles sampled as slanted ones
  std::uint64_t liveTexels = 0;    // of the atlas: in places that hold an element, single texels not counted
  std::uint64_t usedTexels = 0;    // of the atlas: not free for places of any size; single texels included
  std::uint64_t displayBytes = 0;  // that display reads of what is visible, corners included
  std::uint64_t decodeBytes = 0;   // of them, those that say where its texels lie
  std::uint64_t failures = 0;      // elements that found no memory
  std::uint64_t resets = 0;        // since creation
  double bias = 0.0;               // constant and pressure bias together, log2 of area
};

class Gatherer {
 public:
  Gatherer() = default;
  Gatherer(Gatherer&&) = default;
  Gatherer& operator=(Gatherer&&) = default;
  Gatherer(const Gatherer&) = delete;
  Gatherer& operator=(const Gatherer&) = delete;
  virtual ~Gatherer() = default;

  /// A new visible set begins. What follows until allocate() is for the next frame: display still shows the
  /// last.
  virtual void beginViews() {}
  /// What one view sees, or each layer of `ids` (see VisibleSet::add); the views are in the uniform buffer
  /// BIND_VIEWS. `pixelToRay`: one a view, see pixelToRay() in engine/frame/view.hpp.
  virtual void addViews(const gl::Texture& /*ids*/, std::span<const glm::mat3> /*pixelToRay*/) {}
  /// Level of each visible element; the views are in the uniform buffer BIND_VIEWS. `measure` is another
  /// permutation of the measuring pass, or null for the plain one.
  virtual void selectLevels(const VisibleSet& visible, std::uint32_t viewCount,
                            const gl::Program* measure) = 0;
  /// Afterwards every visible element has a place, be it a texel.
  virtual void allocate(const VisibleSet& visible) = 0;
  /// Writes what shading and display draw.
  virtual void emit(const VisibleSet& visible) = 0;

  /// Binds vertices and buffers that gather and display read.
  virtual void bind() const = 0;
  /// Before the first batch is shaded: binds what is written.
  virtual void beginShading() const;
  /// Shades what is visible of a batch, with its gather program in use.
  virtual void shadeBatch(const gl::Program& program, std::uint32_t batch) const = 0;
  /// After the last batch.
  virtual void endShading() const {}
  /// Draws consecutive batches for display, with a display program in use. `list`: which part of what is
  /// visible; each has a program of its own, and most gatherers have one list, 0.
  virtual void drawBatches(std::uint32_t first, std::uint32_t count, std::uint32_t list) const = 0;

  /// Whether its gather program draws over the texture, and takes LOCATION_SIZE.
  [[nodiscard]] virtual bool rasters() const { return true; }
  /// Whether its gather program writes encoded values where the format has them; else the framebuffer
  /// encodes.
  [[nodiscard]] virtual bool encodes() const { return false; }
  [[nodiscard]] virtual const AtlasTexture& atlas() const = 0;
  /// Texels of the atlas that the last allocate() wants shaded; blocking readback.
  [[nodiscard]] virtual std::uint64_t readSamples() const = 0;
  [[nodiscard]] virtual std::size_t bytes() const = 0;
  /// For reports: these wait for the GPU, and walk over all that is visible.
  [[nodiscard]] virtual GatherStatistics readStatistics() const;
  /// Of each texel of the atlas, rows from the top: 0 where nothing visible has it, else 1 + the index of its
  /// sample's kind in readStatistics().kinds. Empty where the gatherer cannot tell.
  [[nodiscard]] virtual std::vector<std::uint8_t> readKinds() const { return {}; }
};

}  // namespace tessera
