#include "engine/frame/engine.hpp"

#include <algorithm>
#include <cmath>

#include "engine/frame/charts.hpp"
#include "engine/frame/engine_state.hpp"
#include "engine/scene/finite.hpp"
#include "engine/scene/subdivide.hpp"
#include "glsl/shared/bindings.h"
#include "glsl/shared/tone.h"

namespace tessera {

namespace {

/// Every attribute a permutation reads has an array: a file may texture a mesh that has no coordinates.
void completeAttributes(Scene& scene, const SceneFeatures& features) {
  const std::size_t count = scene.vertices.position.size();
  for (const Primitive& primitive : scene.primitives) {
    const Permutation p = permutationOf(scene.materials[primitive.material], primitive.hasColor, features);
    if (p.usesUv0) scene.vertices.uv0.resize(count, glm::vec2(0.0f));
    if (p.usesUv1) scene.vertices.uv1.resize(count, glm::vec2(0.0f));
    if (p.normalTexture) scene.vertices.tangent.resize(count, glm::vec4(0.0f));
    if (p.vertexColor) scene.vertices.color.resize(count, glm::vec4(1.0f));
  }
}

/// More lights or shadow layers than a uniform block holds are refused, not dropped.
Result<void> checkLights(const Scene& scene, const Stage* stage) {
  SceneState state;
  evaluate(scene, 0.0, state);
  const auto lights = evaluateLights(scene, state, stage, 0.0);
  std::size_t layers = 0;
  for (const LightSample& light : lights)
    if (light.castsShadow) layers += light.type == LightType::Point ? 6 : 1;
  if (lights.size() > glsl::kMaxLights)
    return fail("{}: {} lights are past the limit of {}", scene.file, lights.size(), glsl::kMaxLights);
  if (layers > glsl::kMaxShadowLayers)
    return fail("{}: {} shadow-map layers (one a light, six a point light) are past the limit of {}",
                scene.file, layers, glsl::kMaxShadowLayers);
  return {};
}

Result<void> checkShadowSize(int texels) {
  if (texels < 64 || texels > 8192) return fail("shadow size {} is outside [64, 8192]", texels);
  return {};
}

}  // namespace

Engine::Engine() = default;
Engine::~Engine() = default;

Result<std::unique_ptr<Engine>> Engine::create(gl::Context& context, Scene scene, std::optional<Stage> stage,
                                               const EngineOptions& options) {
  if (auto good = checkShadowSize(options.shadowSize); !good) return tl::unexpected(good.error());
  if (!(options.splitEdges >= 0.0 && options.splitEdges <= 1.0))
    return fail("edge split share {} is outside [0, 1]", options.splitEdges);
  const auto say = [&](const char* step) {
    if (options.progress) options.progress(step);
  };
  auto engine = std::unique_ptr<Engine>(new Engine);
  engine->s_ = std::make_unique<State>(context);
  State& s = *engine->s_;
  s.options = options;
  s.programs.setCommon(definesOf(options.forms));
  s.depth = depthFormOf(options.forms);
  s.scene = std::move(scene);
  s.stage = std::move(stage);
  const auto guard = s.guard();

  if (options.request.warp && !options.forms.reversedDepth)
    return fail("{}: warping reads reversed depth; forms.reversedDepth is off", s.scene.file);
  makeFinite(s.scene);
  if (auto fits = checkLights(s.scene, s.stage ? &*s.stage : nullptr); !fits)
    return tl::unexpected(fits.error());
  say("splitting long edges");
  if (options.splitEdges > 0.0) splitLongEdges(s.scene, {.maxEdgeShare = options.splitEdges});
  s.features = findFeatures(s.scene, s.stage ? &*s.stage : nullptr);
  s.graph = planFrame(s.features, options.request);
  completeAttributes(s.scene, s.features);
  say("building patches");
  s.draw = prepare(s.scene, options.patches, options.request.rect && options.request.blended);
  s.anchor = s.placedAnchor = options.forms.cameraRelative ? s.scene.bounds.centre() : glm::dvec3(0.0);
  say("uploading");
  auto buffers = upload(s.scene, s.draw);
  if (!buffers) return tl::unexpected(buffers.error());
  s.buffers = std::move(*buffers);
  s.frameBuffer = gl::Buffer(sizeof(glsl::FrameGpu));
  s.viewBuffer = gl::Buffer(kMaxViews * sizeof(glsl::ViewGpu));
  s.drawCommands = gl::Buffer(std::max<std::size_t>(s.draw.instances.size(), 1) * sizeof(glsl::DrawCommand));
  if (options.timePasses) s.timer.emplace(gl::timerModeFor(context.info()));
  if (options.countFragments) {
    s.fragmentQuery = gl::Query(GL_FRAGMENT_SHADER_INVOCATIONS);
    s.passedQuery = gl::Query(GL_SAMPLES_PASSED);
  }

  say("compiling shaders");
  if (auto compiled = s.compile(); !compiled) return tl::unexpected(compiled.error());
  if (s.graph.find("gather") != nullptr) {
    if (auto made = s.makeGatherer(options); !made) return tl::unexpected(made.error());
  }
  if (s.features.blend) {
    std::uint32_t longest = 0;
    for (const Instance& instance : s.draw.blended)
      longest = std::max(longest, s.scene.primitives[instance.primitive].indexCount);
    s.blendIndices = gl::Buffer(std::size_t{longest} * sizeof(std::uint32_t));
  }
  return engine;
}

void Engine::State::afterPictureStore() {
  gl::api().MemoryBarrier(GL_FRAMEBUFFER_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                          GL_TEXTURE_UPDATE_BARRIER_BIT);
}

glm::vec4 Engine::State::encodedBackground() const {
  const glm::vec3& b = options.background;
  return {glsl::encodeSrgb(b.r), glsl::encodeSrgb(b.g), glsl::encodeSrgb(b.b), 0.0f};
}

glm::vec4 Engine::encodedBackground() const { return s_->encodedBackground(); }

void Engine::State::bindScene() {
  buffers.bind();
  if (lightBuffer) lightBuffer.bindUniform(BIND_LIGHTS);
  if (shadowBuffer) shadowBuffer.bindUniform(BIND_SHADOWS);
  frameBuffer.bindUniform(BIND_FRAME);
  viewBuffer.bindUniform(BIND_VIEWS);
  if (shadowMap) shadowMap.bind(UNIT_SHADOW);
}

void Engine::State::setViews(std::span<const View> views) {
  std::vector<glsl::ViewGpu> records;
  for (const View& view : views.first(std::min(views.size(), kMaxViews)))
    records.push_back(viewGpu(view, anchor, options.forms.reversedDepth));
  viewBuffer.write(std::span<const glsl::ViewGpu>(records));
}

void Engine::State::setDensities(std::span<const View> views, const PlaceOptions& placing) {
  std::vector<glsl::DensityGpu> records;
  for (const View& view : views) records.push_back(densityGpu(view, placing));
  if (!densityBuffer) densityBuffer = gl::Buffer(kMaxViews * sizeof(glsl::DensityGpu));
  densityBuffer.write(std::span<const glsl::DensityGpu>(records));
  densityBuffer.bindUniform(BIND_DENSITY);
}

glm::dvec3 Engine::State::anchorFor(const View& view) const {
  if (!options.forms.cameraRelative) return glm::dvec3(0.0);
  // At the edge of a cell a float's last place is 1/1024 of the near plane at the most.
  constexpr double kCellInNearPlanes = 16384.0;
  const double cell = defaultNear(scene) * kCellInNearPlanes;
  const glm::dvec3 centre = scene.bounds.centre();
  const glm::dvec3 cells = glm::round((view.eye - centre) / cell);
  const bool finite = std::isfinite(cells.x) && std::isfinite(cells.y) && std::isfinite(cells.z);
  return finite ? centre + cells * cell : centre;
}

void Engine::State::moveAnchor(const glm::dvec3& to) {
  if (to == anchor || !updated) return;
  anchor = to;
  writeInstances();
  writeLights();
  drawShadows();
}

void Engine::State::writeInstances() {
  const auto records = instanceRecords(scene, draw, now, anchor);
  buffers.instances.write(std::span<const glsl::InstanceGpu>(records));
  bounds = instanceBounds(scene, draw.instances, now);
  for (Box& box : bounds) {
    box.min -= anchor;
    box.max -= anchor;
  }
  mirrored.clear();
  for (std::size_t i = 0; i < draw.instances.size(); ++i)
    mirrored.push_back((records[i].flags & glsl::kInstanceMirrored) != 0);
}

void Engine::State::writeLights() {
  if (!features.lights) return;
  lights = buildLights(evaluateLights(scene, now, stage ? &*stage : nullptr, time), scene.bounds, anchor,
                       options.shadowSize);
  lightBuffer.write(std::span<const glsl::LightGpu>(lights.lights));
  if (shadowBuffer) shadowBuffer.write(std::span<const glsl::ShadowGpu>(lights.shadows));
}

void Engine::update(double time) {
  State& s = *s_;
  const auto guard = s.guard();
  const bool first = !s.updated;
  if (first || s.features.animated) {
    evaluate(s.scene, time, s.now);
    s.writeInstances();
  }
  s.time = time;
  if (first) {
    if (s.features.lights) s.lightBuffer = gl::Buffer(glsl::kMaxLights * sizeof(glsl::LightGpu));
    if (s.features.shadows) s.shadowBuffer = gl::Buffer(glsl::kMaxShadowLayers * sizeof(glsl::ShadowGpu));
  }
  s.writeLights();
  if (s.features.shadows && s.shadowMap.width() != s.options.shadowSize) s.makeShadowMap();
  const Stage* stage = s.stage ? &*s.stage : nullptr;
  // Ambient alone must show the scene; beside lights it only keeps shadows from going black.
  constexpr float kAmbientAlone = 0.8f;
  const Ambient unlitScene{glm::vec3(kAmbientAlone), glm::vec3(kAmbientAlone)};
  const Ambient ambient = stage != nullptr && stage->ambient ? *stage->ambient
                          : s.features.lights                ? Ambient{}
                                                             : unlitScene;
  glsl::FrameGpu frame{};
  frame.ambientSky = glm::vec4(boundedRadiance(ambient.sky), stage != nullptr ? stage->exposure : 1.0f);
  frame.ambientGround = glm::vec4(boundedRadiance(ambient.ground), 0.0f);
  frame.lightCount = static_cast<glsl::uint>(s.lights.lights.size());
  frame.shadowReach = s.options.shadowFilter == ShadowFilter::Wide ? 1 : 0;
  s.frameBuffer.writeValue(frame);
  s.updated = true;
  s.drawShadows();
}

Result<void> Engine::remakeAtlas(const RectMemoryOptions& memory) {
  EngineOptions options = s_->options;
  options.gatherer = GathererKind::Rect;
  options.atlas.memory = memory;
  if (s_->gatherer() == nullptr) return {};
  const auto guard = s_->guard();
  return s_->makeGatherer(options);
}

Result<void> Engine::remakeAtlas(const RectAtlasOptions& rect) {
  EngineOptions options = s_->options;
  options.gatherer = GathererKind::Rect;
  options.atlas = rect;
  if (s_->gatherer() == nullptr) return {};
  const auto guard = s_->guard();
  return s_->makeGatherer(options);
}

Result<void> Engine::remakeAtlas(const TessAtlasOptions& tess) {
  EngineOptions options = s_->options;
  options.gatherer = GathererKind::Tess;
  options.tess = tess;
  if (s_->gatherer() == nullptr) return {};
  const auto guard = s_->guard();
  return s_->makeGatherer(options);
}

Result<void> Engine::remakeAtlas(const TexelAtlasOptions& texel) {
  EngineOptions options = s_->options;
  options.gatherer = GathererKind::Texel;
  options.texel = texel;
  if (s_->gatherer() == nullptr) return {};
  const auto guard = s_->guard();
  return s_->makeGatherer(options);
}

Result<void> Engine::setShadowSize(int texels) {
  if (auto good = checkShadowSize(texels); !good) return good;
  s_->options.shadowSize = texels;
  return {};
}

void Engine::setShadowFilter(ShadowFilter filter) {
  s_->options.shadowFilter = filter;
  if (s_->shadowMap) s_->filterShadowMap();
}

Result<void> Engine::setSpawn(const TessSpawn& spawn) {
  State& s = *s_;
  if (auto good = check(spawn); !good || !s.tess) return good;
  const auto guard = s.guard();
  EngineOptions options = s.options;
  options.tess.spawn = spawn;
  if (auto compiled = s.compileGatherer(options); !compiled) return compiled;
  s.tess->setSpawn(spawn);
  s.options.tess.spawn = spawn;
  return {};
}

Result<void> Engine::State::makeGatherer(const EngineOptions& wanted) {
  const bool triangles = wanted.gatherer == GathererKind::Tess;
  if (wanted.gatherer == GathererKind::Texel && graph.find("mark-blended") != nullptr)
    return fail("{}: texel shading shades what pixels show: of blended surfaces that is no one texel",
                scene.file);
  const VisibleElement element = triangles ? VisibleElement::Triangle : VisibleElement::Patch;
  // Numbers of triangles leave room for the three of a patch and one more.
  const std::uint32_t elements = draw.patchInstances * (triangles ? 4 : 1);
  std::optional<VisibleSet> newVisible;
  if (!visible || visible->element() != element) {
    auto made = VisibleSet::create(programs, element, elements, wanted.visiblePixels);
    if (!made) return tl::unexpected(made.error());
    newVisible = std::move(*made);
  }
  std::vector<glsl::BatchGpu> batches;
  for (const Batch& batch : draw.batches)
    batches.push_back(triangles ? glsl::BatchGpu{batch.firstTriangle, batch.triangles}
                                : glsl::BatchGpu{batch.firstEntry, batch.entryCapacity});
  if (triangles) {
    auto made = TessAtlas::create(programs, wanted.tess, elements, batches);
    if (!made) return tl::unexpected(made.error());
    if (auto compiled = compileGatherer(wanted); !compiled) return compiled;
    tess = std::move(*made);
    atlas.reset();
    texel.reset();
  } else if (wanted.gatherer == GathererKind::Texel) {
    auto charts = chartsOf(scene, draw);
    if (!charts) return tl::unexpected(charts.error());
    auto made = TexelAtlas::create(programs, wanted.texel, *charts, draw.entries, batches);
    if (!made) return tl::unexpected(made.error());
    if (auto compiled = compileGatherer(wanted); !compiled) return compiled;
    texel = std::move(*made);
    atlas.reset();
    tess.reset();
  } else {
    auto made = RectAtlas::create(programs, wanted.atlas, draw.patchInstances, draw.entries, batches);
    if (!made) return tl::unexpected(made.error());
    if (auto compiled = compileGatherer(wanted); !compiled) return compiled;
    atlas = std::move(*made);
    tess.reset();
    texel.reset();
  }
  if (newVisible) visible = std::move(newVisible);
  options.gatherer = wanted.gatherer;
  options.atlas = wanted.atlas;
  options.tess = wanted.tess;
  options.texel = wanted.texel;
  return {};
}

void Engine::rect(const View& view, DisplayMode mode) {
  const std::array<View, 1> views = {view};
  findVisible(views);
  place(views);
  shade(view);
  display(view, mode);
}

const gl::Texture& Engine::color() const { return s_->shown().color; }

Image Engine::readColor() const {
  const auto guard = s_->guard();
  const gl::Texture& texture = s_->shown().encoded;
  return flipped(texture.width(), texture.height(), gl::readTexture(texture, GL_RGBA, GL_UNSIGNED_BYTE, 4));
}

Image Engine::readAtlas() const {
  const auto guard = s_->guard();
  if (s_->gatherer() == nullptr) return {};
  const gl::Texture& texture = s_->gatherer()->atlas().display();
  return flipped(texture.width(), texture.height(), gl::readTexture(texture, GL_RGBA, GL_UNSIGNED_BYTE, 4));
}

void Engine::blit(unsigned framebuffer, int x, int y, int width, int height) const {
  const auto guard = s_->guard();
  gl::apply({});
  const PictureTarget& shown = s_->shown();
  const bool same = width == shown.color.width() && height == shown.color.height();
  gl::api().BlitNamedFramebuffer(shown.encodedFramebuffer.get(), framebuffer, 0, 0, shown.color.width(),
                                 shown.color.height(), x, y, x + width, y + height, GL_COLOR_BUFFER_BIT,
                                 same ? GL_NEAREST : GL_LINEAR);
}

const Scene& Engine::scene() const { return s_->scene; }
const SceneState& Engine::state() const { return s_->now; }
const Stage* Engine::stage() const { return s_->stage ? &*s_->stage : nullptr; }
const DrawScene& Engine::drawScene() const { return s_->draw; }
const SceneFeatures& Engine::features() const { return s_->features; }
const FrameGraph& Engine::graph() const { return s_->graph; }
const RectAtlas* Engine::atlas() const { return s_->atlas ? &*s_->atlas : nullptr; }
RectAtlas* Engine::atlas() { return s_->atlas ? &*s_->atlas : nullptr; }
const TessAtlas* Engine::tess() const { return s_->tess ? &*s_->tess : nullptr; }
const TexelAtlas* Engine::texel() const { return s_->texel ? &*s_->texel : nullptr; }
TessAtlas* Engine::tess() { return s_->tess ? &*s_->tess : nullptr; }
const Gatherer* Engine::gatherer() const { return s_->gatherer(); }
const VisibleSet* Engine::visibleSet() const { return s_->visible ? &*s_->visible : nullptr; }
const std::vector<std::string>& Engine::permutations() const { return s_->programs.compiled(); }
const std::vector<PassTime>& Engine::times() const { return s_->times; }
void Engine::clearTimes() { s_->times.clear(); }
gl::TimerMode Engine::timerMode() const { return gl::timerModeFor(s_->context->info()); }
std::uint64_t Engine::fragments() const { return s_->fragments; }
std::uint64_t Engine::samplesPassed() const { return s_->samplesPassed; }

std::vector<std::pair<std::string, std::size_t>> Engine::memory() const {
  const State& s = *s_;
  std::size_t targets = 0;
  for (const gl::Texture* texture :
       {&s.picture.color, &s.picture.depth, &s.spare.color, &s.spare.depth, &s.upsampledRows,
        &s.distorted.color, &s.id.ids, &s.id.depth, &s.idLayers.ids, &s.idLayers.depth})
    if (*texture) targets += texture->bytes();
  std::vector<std::pair<std::string, std::size_t>> sizes = {
      {"geometry", s.buffers.geometryBytes}, {"textures", s.buffers.textureBytes}, {"targets", targets}};
  if (const Gatherer* gatherer = s_->gatherer(); gatherer != nullptr)
    sizes.emplace_back("atlas", gatherer->bytes());
  if (s.shadowMap) sizes.emplace_back("shadow-map", s.shadowMap.bytes());
  return sizes;
}

}  // namespace tessera
