// Draws a shaded frame for any camera without a scene: by one draw call what is opaque, by one more, back to
// front, what is blended.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "codec/wire/geometry.hpp"
#include "engine/gl/program.hpp"
#include "engine/image/image.hpp"
#include "engine/lens/lens.hpp"
#include "engine/view/back_to_front.hpp"
#include "engine/view/shaded_frame.hpp"
#include "engine/yuv/unpacker.hpp"

namespace tessera::view {

struct DisplayOptions {
  glm::vec3 background{0.030f, 0.034f, 0.042f};  // linear; the engine's own
  std::optional<Lens> lens;                      // that each eye's picture is seen through
};

/// Move only; its context must be current. Where that is a host's, its state is left as it was.
class StreamedDisplay {
 public:
  /// Fails where check() of the lens does, or a program does not compile.
  static Result<StreamedDisplay> create(const gl::Context& context, const DisplayOptions& options = {});

  /// Uploads a frame: from here on draw() shows it. Fails as YuvUnpacker::unpack does, and where a program
  /// does not compile; what was shown before stays.
  Result<void> upload(const ShadedFrame& frame);

  /// The frame that was uploaded, as the camera sees it, into color(); the background alone before the first.
  void draw(const wire::Camera& camera);
  /// Two eyes side by side, each half as wide as the camera's picture.
  void drawStereo(const wire::Camera& camera, double eyeDistance);

  /// Display-encoded colours in SRGB8_ALPHA8; alpha 0 where nothing was drawn. Without a name before draw().
  [[nodiscard]] const gl::Texture& color() const { return shown().color; }
  /// Rows from the top; blocking. draw() must have been called.
  [[nodiscard]] Image read() const;
  /// Draws color() over a framebuffer's (0, 0, width, height), texel for pixel.
  void blit(unsigned framebuffer, int width, int height) const;

  /// Pixels of the last picture, before any lens, that no opaque triangle covers; waits for the GPU. Nothing
  /// before a picture.
  [[nodiscard]] std::optional<std::uint64_t> uncovered() const;

 private:
  struct Region {
    int x, width;
  };
  StreamedDisplay() = default;
  Result<void> prepare(const ShadedFrame& frame);
  void uploadMasks(const ShadedFrame& frame);
  void begin(const wire::Camera& camera);
  void bind(const gl::Program& program, const wire::Camera& camera, Region part);
  void drawOpaque(const wire::Camera& camera, Region part);
  void drawBackground();
  void drawBlended(const wire::Camera& camera, Region part);
  struct Part {
    wire::Camera camera;
    Region region;
  };
  void drawParts(const wire::Camera& whole, std::span<const Part> parts);
  void seeThroughLens(std::span<const Part> parts);
  struct Picture {
    gl::Texture color;     // SRGB8_ALPHA8
    gl::Texture encoded;   // its RGBA8 view
    gl::Framebuffer copy;  // of encoded: texels are copied as they are
    /// Whether it was made anew, and black.
    bool resize(int width, int height, const gl::Texture* depth = nullptr);
  };
  [[nodiscard]] const Picture& shown() const { return lens_ ? lensed_ : picture_; }

  const gl::Context* context_ = nullptr;
  DisplayOptions options_;
  std::unique_ptr<gl::ProgramCache> programs_;
  const gl::Program* program_ = nullptr;
  const gl::Program* blended_ = nullptr;
  const gl::Program* far_ = nullptr;
  std::optional<YuvUnpacker> atlas_;
  gl::VertexArray vertexArray_;
  gl::Buffer vertices_, triangles_, elements_, pieces_, objects_, maskAt_, masks_, alpha_;
  std::vector<wire::ObjectTransform> transforms_;
  std::shared_ptr<const std::vector<wire::MaskImage>> uploadedMasks_;
  std::size_t triangleCount_ = 0;
  BackToFront order_;
  gl::Buffer indices_;
  gl::VertexArray indexed_;
  glm::dvec3 shadedEye_{0.0};
  Picture picture_;
  gl::Texture depth_;
  gl::Framebuffer linearFramebuffer_;  // of picture_.color
  std::optional<LensPass> lens_;
  Picture lensed_;
  Picture eye_, lensedEye_;  // of several, one at a time
  gl::Query farSamples_;
  bool counted_ = false;
};

}  // namespace tessera::view
