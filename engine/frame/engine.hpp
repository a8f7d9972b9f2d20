// The face of the engine. A host calls the stages, each at its own rate:
//   update       animation and lights at a time
//   findVisible  the visible set of one or more views
//   place        levels and blocks for the visible set
//   shade        the blocks' texels
//   display      a picture of any view, from the atlas
// and `forward` is the reference: the same shading code, straight to the screen.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/rect/rect_atlas.hpp"
#include "atlas/tess/tess_atlas.hpp"
#include "atlas/texel/texel_atlas.hpp"
#include "engine/frame/batches.hpp"
#include "engine/frame/features.hpp"
#include "engine/frame/forms.hpp"
#include "engine/frame/graph.hpp"
#include "engine/frame/image_warp.hpp"
#include "engine/frame/lights.hpp"
#include "engine/frame/predict.hpp"
#include "engine/frame/scene_buffers.hpp"
#include "engine/frame/view.hpp"
#include "engine/gl/context.hpp"
#include "engine/gl/timer.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/stage.hpp"

namespace tessera {

/// Which way an atlas is filled.
enum class GathererKind : std::uint8_t { Rect, Tess, Texel };

/// What a lookup of a shadow map takes: the nearest texel, the four nearest blended, or nine such blends one
/// texel apart, whose edges are soft over three texels.
enum class ShadowFilter : std::uint8_t { Nearest, Linear, Wide };

struct EngineOptions {
  GathererKind gatherer = GathererKind::Rect;  // of the three that follow, which one there is
  RectAtlasOptions atlas;
  TessAtlasOptions tess;
  TexelAtlasOptions texel;
  PatchOptions patches;
  FrameRequest request{.rect = true, .displayGeometry = true, .displayDeferred = false, .forward = true};
  /// Triangles with an edge longer than this share of the scene's diagonal are split at load, so that huge
  /// quads become patches of bounded size of which only the visible are shaded. (0, 1]; 0 = never. 1/24:
  /// measured default.
  double splitEdges = 1.0 / 24.0;
  int shadowSize = 1024;  // texels a side of a shadow-map layer, [64, 8192]
  ShadowFilter shadowFilter = ShadowFilter::Linear;
  glm::vec3 background{0.030f, 0.034f, 0.042f};  // display-referred linear
  /// Several views' ids in one pass, a layer of the target each, where the context can
  /// (ContextInfo::vertexLayers); false: a pass a view. The visible set is the same.
  /// On a software renderer one pass takes 1.01 to 1.04 of the time of two (stereo at 720p, medians).
  bool idLayers = true;
  bool visiblePixels = false;                             // VisibleSet::readPixels has something to give
  NumericForms forms;                                     // without reversed depth there is no warping
  bool timePasses = false;                                // measure each pass: a finish or a query around it
  bool countFragments = false;                            // pipeline statistics around forward and gather
  std::function<void(const std::string& step)> progress;  // load steps, may be empty
};

/// Time of one pass in its last run.
struct PassTime {
  std::string name;
  double milliseconds = 0.0;
};

/// How shade() fills texels.
struct ShadeOptions {
  /// Mip levels added where material textures are read, cut to [-2, 1]; not a number counts as 0. Below 0 is
  /// sharper: display filters the texels once more. -0.5: measured default. Compared with supersampled
  /// forward it is best at four texels a pixel, and better than 0 at any density without more shimmer; at one
  /// texel a pixel it is the best against plain forward as well, whose own filter denser texels match with
  /// -(1 + bias) / 2.
  float textureBias = -0.5f;
};

enum class DisplayMode : std::uint8_t { Geometry, Deferred };
enum class DebugView : std::uint8_t { Ids, Patches, Levels, TexelDensity, Blocks, Atlas };

class Engine {
 public:
  /// Takes the scene, prepares and uploads it, and compiles every program its plan needs. The context must be
  /// current on this thread, here and in every later call. Fails with the shader, image or limit that does
  /// not fit.
  static Result<std::unique_ptr<Engine>> create(gl::Context& context, Scene scene, std::optional<Stage> stage,
                                                const EngineOptions& options);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// Moves nodes, lights and shadow maps to `time` seconds. Must be called once before the first other stage.
  void update(double time);
  /// The union of what the views see, however many.
  void findVisible(std::span<const View> views);
  /// The same at several times, with animated objects where they are at each view's: a potentially visible
  /// set (see predictedViews and widened). Views of one size in a row at one time, or in a scene that nothing
  /// moves in, are drawn in one pass where the context can. Afterwards the scene is again as of the last
  /// update().
  /// A view that is the same as the one before it is drawn once.
  void findVisible(std::span<const TimedView> views);
  /// Places the visible set for these views, at most kMaxViews (the largest over them counts), with fewer
  /// texels where the options say that fewer are seen. The program of a combination of options is compiled at
  /// its first use. Fails, and leaves everything as it was, where check() of an option or that program fails.
  /// Texel Shading takes its levels from the pixels of findVisible's views, whatever these are, and fails
  /// with any option.
  Result<void> place(std::span<const View> views, const PlaceOptions& options = {});
  /// Shades every placed patch, as seen from `view`'s eye. For several views: once, from between them.
  void shade(const View& view, const ShadeOptions& options = {});
  /// Draws a view from the atlas into color(). Geometry: any camera, any size. Deferred: the view that
  /// findVisible was last called with.
  /// If the plan (EngineOptions::request) has only the other form, that one draws.
  void display(const View& view, DisplayMode mode = DisplayMode::Geometry);
  /// Draws the picture of the last display or forward through the lens, at its size; color() is the distorted
  /// picture from here to the next display or forward. Fails where check(lens) does, without a picture, and
  /// where the plan has no such pass (FrameRequest::lens).
  Result<void> distort(const Lens& lens);
  /// The reference. With `depthPrepass`, depth alone is drawn first.
  void forward(const View& view, bool depthPrepass = false);
  /// What the atlas is compared with. Both take the picture that forward drew last, make another of it, and
  /// that is color() and what distort() sees. They fail where the plan has no such pass
  /// (FrameRequest::upsample, ::warp), and without a picture of forward's to take.
  /// Lanczos-3 to a size not below the picture's, on encoded values, edges clamped. Uncovered pixels have no
  /// part in a covered pixel's colour; a pixel is covered where the covered ones have half of its weight or
  /// more, and then opaque.
  Result<void> upsample(int width, int height);
  /// Mesh warping (Mark et al. 1997): the picture as `to` sees the surface that its depth buffer draws, a
  /// vertex a pixel. `from` is the view that forward drew. The surface has no gaps: it is drawn out between
  /// near and far, and beyond the picture's edges it goes on as far again as the picture is wide and high.
  Result<void> warp(const View& from, const View& to);
  /// Another atlas in place of the one there is; what that one held is lost. Fails, and leaves the old one,
  /// where such an atlas cannot be made. With memory options alone, a rectangular one keeps its format.
  Result<void> remakeAtlas(const RectMemoryOptions& memory);
  Result<void> remakeAtlas(const RectAtlasOptions& rect);
  Result<void> remakeAtlas(const TessAtlasOptions& tess);
  Result<void> remakeAtlas(const TexelAtlasOptions& texel);
  /// Shadow maps of another size (see EngineOptions::shadowSize), from the next update() on. Fails, and
  /// changes nothing, for a size out of range.
  Result<void> setShadowSize(int texels);
  /// From the next update() on.
  void setShadowFilter(ShadowFilter filter);
  /// Another way to spawn the samples of what is placed; without effect on any but the tessellation gatherer.
  /// Fails, and changes nothing, where check(spawn) does or a program does not compile.
  Result<void> setSpawn(const TessSpawn& spawn);
  /// findVisible, place (without options), shade and display of one view.
  void rect(const View& view, DisplayMode mode = DisplayMode::Geometry);

  /// What display, forward or distort drew last: SRGB8_ALPHA8, alpha 0 where nothing was drawn.
  [[nodiscard]] const gl::Texture& color() const;
  /// What forward drew last, as ImageWarp takes it; `drawn` is the view that it drew. The next picture may be
  /// drawn into the same textures.
  [[nodiscard]] WarpSource warpSource(const View& drawn) const;
  /// EngineOptions::background as RGBA8 textures hold it; alpha 0.
  [[nodiscard]] glm::vec4 encodedBackground() const;
  /// Blocking readback of color(), or of the atlas, rows from the top.
  [[nodiscard]] Image readColor() const;
  [[nodiscard]] Image readAtlas() const;
  /// A picture that explains a stage; ids to texel density need findVisible and place for `view` first.
  Result<Image> debugView(DebugView what, const View& view);
  /// Draws color() over the host's framebuffer (x, y, width, height in pixels).
  void blit(unsigned framebuffer, int x, int y, int width, int height) const;

  [[nodiscard]] const Scene& scene() const;
  [[nodiscard]] const SceneState& state() const;
  [[nodiscard]] const Stage* stage() const;
  [[nodiscard]] const DrawScene& drawScene() const;
  [[nodiscard]] const SceneFeatures& features() const;
  [[nodiscard]] const FrameGraph& graph() const;
  /// What fills the atlas; null where the plan has none. atlas(), tess() and texel() are the same by kind, or
  /// null.
  [[nodiscard]] const Gatherer* gatherer() const;
  [[nodiscard]] const RectAtlas* atlas() const;
  [[nodiscard]] RectAtlas* atlas();
  [[nodiscard]] const TessAtlas* tess() const;
  [[nodiscard]] TessAtlas* tess();
  [[nodiscard]] const TexelAtlas* texel() const;
  [[nodiscard]] const VisibleSet* visibleSet() const;
  /// "pass/forward.vert + pass/shade.frag NORMAL_TEX ...", one a program.
  [[nodiscard]] const std::vector<std::string>& permutations() const;
  /// Times of the passes that ran since clearTimes(), in order; empty without EngineOptions::timePasses.
  [[nodiscard]] const std::vector<PassTime>& times() const;
  void clearTimes();
  [[nodiscard]] gl::TimerMode timerMode() const;
  /// Fragment-shader invocations of the last forward (opaque part) or gather; 0 without countFragments.
  [[nodiscard]] std::uint64_t fragments() const;
  /// Samples of the same draws that passed the depth test: what early depth testing leaves to be shaded.
  [[nodiscard]] std::uint64_t samplesPassed() const;
  /// Of the samples that the last place() allocated, those of patches with a corner outside the view;
  /// blocking readback.
  [[nodiscard]] std::uint64_t samplesPartlyInView(const View& view) const;
  /// Sum of triangles over the visible patches; blocking readback.
  [[nodiscard]] std::uint64_t visibleTriangles() const;
  /// What each pixel of the last view of findVisible shows, rows from the top: see idOfTriangle in
  /// glsl/shared/scene.h, 0 for nothing; blocking readback. Empty before findVisible.
  [[nodiscard]] std::vector<std::uint32_t> readIds() const;
  /// VisibleSet::readPixels of the last findVisible(); empty without EngineOptions::visiblePixels. Blocking.
  [[nodiscard]] std::vector<std::uint32_t> readVisiblePixels() const;
  /// Of the pixels of the views of the last findVisible(), the share that shows nothing that covers, [0, 1];
  /// 0 before. Blocking.
  [[nodiscard]] double readBackgroundShare() const;
  /// Longest edge to height of such a triangle (an id that is not 0), as the view's eye sees it: what makes
  /// it slanted. 0 where it is no longer than a pixel.
  [[nodiscard]] double slantOf(std::uint32_t id, const View& view) const;
  /// Texels of live blocks that are not finite, in an atlas of floats (AtlasFormat::Rgba16f, R11g11b10f);
  /// blocking readback. 0 for the other formats, which cannot hold such a value.
  [[nodiscard]] std::uint64_t nonFiniteTexels() const;
  /// Bytes of GPU memory by purpose: "geometry", "textures", "atlas", "targets", "shadow-map".
  [[nodiscard]] std::vector<std::pair<std::string, std::size_t>> memory() const;

  static constexpr std::size_t kMaxViews = RECT_VIEWS;

 private:
  Engine();
  struct State;
  std::unique_ptr<State> s_;
};

}  // namespace tessera
