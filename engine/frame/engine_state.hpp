// The insides of Engine, shared by the files that implement it. Not installed.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/frame/engine.hpp"
#include "engine/frame/image_warp.hpp"
#include "engine/gl/draw_state.hpp"
#include "engine/gl/state_guard.hpp"

namespace tessera {

/// Colour and depth of one picture.
struct PictureTarget {
  gl::Texture color;                   // SRGB8_ALPHA8
  gl::Texture encoded;                 // its RGBA8 view
  gl::Texture depth;                   // see DepthForm
  gl::Framebuffer framebuffer;         // of color
  gl::Framebuffer encodedFramebuffer;  // of encoded: writes are copied as they are
  /// Without a depth form there is no depth.
  void resize(int width, int height, const DepthForm* form);
};

/// The id pass's target.
struct IdTarget {
  gl::Texture ids;  // R32UI
  gl::Texture depth;
  gl::Framebuffer framebuffer;
  gl::Texture lastIds, lastDepth;  // the last of several layers
  void resize(int width, int height, const DepthForm& form, int layers = 0);
};

/// Programs of a batch, by what draws it. Null where the plan has no such pass.
struct BatchPrograms {
  Permutation shading;
  Permutation depth;
  const gl::Program* forward = nullptr;
  const gl::Program* gather = nullptr;
  const gl::Program* id = nullptr;
  const gl::Program* idLayers = nullptr;  // from the first call with several views on
  const gl::Program* mark = nullptr;      // of a batch that blends, in place of id; the gatherer's
  const gl::Program* markLayers = nullptr;
  const gl::Program* depthOnly = nullptr;
  const gl::Program* shadow = nullptr;
  std::vector<const gl::Program*>
      display;  // of each list that the gatherer displays, see Gatherer::drawBatches
};

/// A BLEND instance and its program.
struct BlendedPrograms {
  Permutation shading;
  const gl::Program* forward = nullptr;
};

struct Engine::State {
  explicit State(gl::Context& current) : context(&current), programs(current) {}

  gl::Context* context;
  gl::ProgramCache programs;
  EngineOptions options;
  DepthForm depth;  // of options.forms
  Scene scene;
  std::optional<Stage> stage;
  SceneFeatures features;
  FrameGraph graph;
  BarrierTracker barriers;
  DrawScene draw;
  SceneBuffers buffers;
  glm::dvec3 anchor{0.0};        // what positions on the GPU are relative to; see anchorFor
  glm::dvec3 placedAnchor{0.0};  // of what the gatherer emitted last

  SceneState now;
  double time = 0.0;  // of the last update, seconds
  bool updated = false;
  std::vector<Box> bounds;  // of draw.instances, relative to the anchor
  std::vector<bool> mirrored;
  LightSet lights;
  std::vector<glsl::LightGpu> uploadedLights;
  gl::Buffer lightBuffer, shadowBuffer, frameBuffer, viewBuffer, drawCommands;
  gl::Buffer densityBuffer;  // of place() with options
  gl::Texture shadowMap;
  std::vector<gl::Framebuffer> shadowFramebuffers;
  gl::Buffer blendIndices;
  gl::VertexArray blendArray;

  std::vector<BatchPrograms> batchPrograms;
  std::vector<BlendedPrograms> blendedPrograms;  // one a blended instance
  const gl::Program* deferred = nullptr;
  std::optional<LensPass> distort;
  const gl::Program* upsampleRows = nullptr;
  const gl::Program* upsampleColumns = nullptr;
  std::optional<ImageWarp> warp;

  std::optional<VisibleSet> visible;
  std::optional<RectAtlas> atlas;
  std::optional<TessAtlas> tess;
  std::optional<TexelAtlas> texel;
  PictureTarget picture;
  PictureTarget spare;           // what upsample() and warp() draw into; then it is the picture
  gl::Texture upsampledRows;     // RGBA16F, full width, the picture's height
  PictureTarget distorted;       // of distort(), without depth
  std::uint64_t viewPixels = 0;  // of the last findVisible()
  bool throughLens = false;      // which of the two color() is
  IdTarget id;
  IdTarget idLayers;
  bool idsInLayers = false;  // which of the two findVisible drew last

  std::vector<PassTime> times;
  std::optional<gl::Timer> timer;
  gl::Query fragmentQuery;
  gl::Query passedQuery;
  std::uint64_t fragments = 0;
  std::uint64_t samplesPassed = 0;

  /// Runs a pass of the plan with its barriers and its timer; does nothing for a pass that the plan does not
  /// have.
  template <class Run>
  void pass(const char* name, Run&& run) {
    const Pass* planned = graph.find(name);
    if (planned == nullptr) return;
    if (const std::uint32_t bits = barriers.before(*planned); bits != 0) gl::api().MemoryBarrier(bits);
    if (!timer) {
      run();
      return;
    }
    timer->begin();
    run();
    timer->end();
    times.push_back({name, timer->milliseconds()});
  }
  /// Counts the fragments that `run` shades, when asked to.
  template <class Run>
  void counted(Run&& run) {
    if (!options.countFragments) {
      run();
      return;
    }
    fragmentQuery.begin();
    passedQuery.begin();
    run();
    passedQuery.end();
    fragmentQuery.end();
    fragments = fragmentQuery.result();
    samplesPassed = passedQuery.result();
  }
  /// A host's state is saved around every call; contexts of our own have no one to be kind to.
  [[nodiscard]] std::optional<gl::StateGuard> guard() const { return gl::guardHost(*context); }

  Result<void> compile();
  /// The programs of the gatherer that the options name: those to shade and to display its atlas.
  Result<void> compileGatherer(const EngineOptions& wanted);
  /// Makes the gatherer that the options name, with its programs and its visible set, in place of the one
  /// there is.
  Result<void> makeGatherer(const EngineOptions& wanted);
  [[nodiscard]] Gatherer* gatherer() {
    if (texel) return &*texel;
    return tess ? static_cast<Gatherer*>(&*tess) : (atlas ? &*atlas : nullptr);
  }
  /// Whether several views' ids are drawn in one pass, a layer each; compiles what that needs at its first
  /// use. What a driver offers and then refuses is not asked for again.
  bool drawsIdLayers();
  /// Of the last view that findVisible drew.
  [[nodiscard]] const gl::Texture& ids() const { return idsInLayers ? idLayers.lastIds : id.ids; }
  [[nodiscard]] const gl::Texture& idDepth() const { return idsInLayers ? idLayers.lastDepth : id.depth; }
  /// Draws the ids of views of one size: of several as layers, which drawsIdLayers() must allow, or of one.
  void drawIds(std::span<const View> views, bool layered);
  /// Adds to the visible set what blended geometry shows before the depths that drawIds drew.
  void markBlended(std::span<const View> views, bool layered);
  /// A list into each of so many layers.
  void drawLayers(DrawList list, std::size_t layers, const gl::Program* BatchPrograms::*program);
  /// Animated objects to where they are at a time; lights and shadow maps stay.
  void moveObjects(double to);
  [[nodiscard]] const PictureTarget& shown() const { return throughLens ? distorted : picture; }
  /// Makes the undistorted picture the one that is drawn to and shown.
  void beginPicture(const View& view);
  /// After shaders stored the picture: whoever reads color() does not know that they did.
  static void afterPictureStore();
  /// The background in the encoding of the picture, for what writes encoded values; alpha 0.
  [[nodiscard]] glm::vec4 encodedBackground() const;
  void bindScene();
  void setViews(std::span<const View> views);
  /// Where floats are fine enough for a view: the scene's centre, or for an eye far from it the nearest point
  /// of a wide grid around it. Of the eye alone, so that the same view has the same picture whatever came
  /// before.
  [[nodiscard]] glm::dvec3 anchorFor(const View& view) const;
  /// Positions on the GPU become relative to another anchor, but for what a gatherer emitted.
  void moveAnchor(const glm::dvec3& to);
  void writeInstances();
  void writeLights();
  /// The permutation of the measuring pass for these options; null for the plain one.
  Result<const gl::Program*> measureProgram(const PlaceOptions& placing);
  /// Uploads and binds what that permutation reads of each view.
  void setDensities(std::span<const View> views, const PlaceOptions& placing);
  /// What any of the views may see.
  [[nodiscard]] DrawList visibleDraws(std::span<const View> views, bool blended = false) const;
  /// Uploads the list's commands and makes them current.
  void useCommands(const DrawList& list);
  void drawRange(const DrawRange& range) const;
  /// Draws all of a list with depth-only or id programs, material by material only where the alpha test needs
  /// it.
  void drawDepthList(const DrawList& list, const gl::Program* BatchPrograms::*program, bool cull, int layer);
  /// A layer for each that the lights ask for, of the options' size; all are drawn at the next drawShadows().
  void makeShadowMap();
  void filterShadowMap();
  void drawShadows();
  void drawTransparent(const View& view, const char* passName, const gl::Texture& depth);
};

}  // namespace tessera
