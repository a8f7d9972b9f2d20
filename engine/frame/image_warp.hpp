// Image warping: a picture as another view sees it, without the scene. What the atlas is compared with.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec4.hpp>

#include "engine/frame/view.hpp"
#include "engine/gl/program.hpp"

namespace tessera {

enum class Warp : std::uint8_t {
  Time,      // turned only, all of it at infinity (Van Waveren 2016); reads no depth
  Mesh,      // the surface that its depth draws, a vertex a pixel, without gaps (Mark et al. 1997)
  Iterative  // each pixel looks for its place in the picture by fixed-point iteration (Bowles et al. 2012)
};

/// A picture of a view, of its size. Beyond its edges the picture goes on.
struct WarpSource {
  const gl::Texture* encoded = nullptr;  // RGBA8, display-encoded
  const gl::Texture* depth = nullptr;    // reversed: near plane / distance ahead, 0 at infinity; not for Time
  View view;
};

/// Of Warp::Iterative. Measured on the atrium and sponza: more of either changes MSSIM by less than 0.001.
struct WarpOptions {
  int starts = 8;      // at most, and one at infinity, [1, 64]; fewer where nothing shifts by so many pixels
  int iterations = 6;  // from each start, [1, 64]
  float converged = 0.5f;  // pixels, (0, 16]
};

/// Move only; its context must be current, and its state is the caller's to guard.
class ImageWarp {
 public:
  /// Fails where a program does not compile.
  static Result<ImageWarp> create(gl::ProgramCache& programs, std::span<const Warp> wanted);

  /// Draws into (0, 0, to.width, to.height) of a target of RGBA8, with depth. `background`, display-encoded,
  /// is what shows where there is nothing. Depth is left as `to` sees it, of Time 0. Fails for a picture that
  /// is missing or not of its view's size, options out of range, and a warp that create() was not asked for.
  Result<void> draw(Warp warp, const WarpSource& source, const View& to, const gl::Framebuffer& target,
                    const glm::vec4& background, const WarpOptions& options = {});

 private:
  void drawMesh(const WarpSource& source, const View& to);
  void drawPixels(const gl::Program& program, Warp warp, const WarpSource& source, const View& to,
                  const WarpOptions& options);

  const gl::Program* time_ = nullptr;
  const gl::Program* mesh_ = nullptr;
  const gl::Program* iterative_ = nullptr;
  const gl::Program* findNearest_ = nullptr;
  gl::Buffer nearest_;
  gl::VertexArray noVertices_;
};

}  // namespace tessera
