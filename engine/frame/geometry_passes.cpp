// Passes that draw the scene's geometry: shadow maps, ids, depth pre-pass, forward, transparent.
#include <algorithm>
#include <numeric>

#include "engine/frame/engine_state.hpp"
#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

void clearColor(const gl::Framebuffer& framebuffer, const glm::vec4& color) {
  gl::api().ClearNamedFramebufferfv(framebuffer.get(), GL_COLOR, 0, &color.x);
}

void clearDepth(const gl::Framebuffer& framebuffer, float value) {
  gl::api().ClearNamedFramebufferfv(framebuffer.get(), GL_DEPTH, 0, &value);
}

// Clears obey masks and scissor, so a pass sets its state first.
void beginPass(const gl::Framebuffer& framebuffer, int width, int height, const gl::DrawState& state) {
  gl::api().BindFramebuffer(GL_FRAMEBUFFER, framebuffer.get());
  gl::api().Viewport(0, 0, width, height);
  gl::apply(state);
}

}  // namespace

void PictureTarget::resize(int width, int height, const DepthForm* form) {
  if (color && color.width() == width && color.height() == height) return;
  *this = {};
  color = gl::Texture(GL_SRGB8_ALPHA8, width, height);
  color.filter(GL_LINEAR, GL_LINEAR);
  color.wrap(GL_CLAMP_TO_EDGE);
  encoded = color.view(GL_RGBA8);
  encoded.filter(GL_LINEAR, GL_LINEAR);
  encoded.wrap(GL_CLAMP_TO_EDGE);
  if (form != nullptr) depth = gl::Texture(form->format, width, height);
  const gl::Texture* attached = form != nullptr ? &depth : nullptr;
  const std::array<const gl::Texture*, 1> colors = {&color};
  const std::array<const gl::Texture*, 1> raw = {&encoded};
  framebuffer = gl::Framebuffer(colors, attached);
  encodedFramebuffer = gl::Framebuffer(raw, attached);
}

void Engine::State::beginPicture(const View& view) {
  // Upsampling alternates between two sizes: each target keeps its own.
  const auto fits = [&](const PictureTarget& target) {
    return target.color && target.color.width() == view.width && target.color.height() == view.height;
  };
  if (!fits(picture) && fits(spare)) std::swap(picture, spare);
  picture.resize(view.width, view.height, &depth);
  throughLens = false;
}

void IdTarget::resize(int width, int height, const DepthForm& form, int layers) {
  if (ids && ids.width() == width && ids.height() == height && ids.layers() == layers) return;
  *this = {};
  ids = gl::Texture(GL_R32UI, width, height, 1, layers);
  ids.filter(GL_NEAREST, GL_NEAREST);
  depth = gl::Texture(form.format, width, height, 1, layers);
  const std::array<const gl::Texture*, 1> colors = {&ids};
  framebuffer = gl::Framebuffer(colors, &depth);
  if (layers == 0) return;
  lastIds = ids.layer(layers - 1);
  lastIds.filter(GL_NEAREST, GL_NEAREST);
  lastDepth = depth.layer(layers - 1);
  lastDepth.filter(GL_NEAREST, GL_NEAREST);
}

DrawList Engine::State::visibleDraws(std::span<const View> views, bool blended) const {
  std::vector<Frustum> frusta;
  for (const View& view : views) frusta.push_back(frustumOf(viewProjection(view, anchor)));
  return cull(scene, draw, bounds, mirrored, frusta, blended);
}

void Engine::State::useCommands(const DrawList& list) {
  drawCommands.write(std::span<const glsl::DrawCommand>(list.commands));
  gl::api().BindBuffer(GL_DRAW_INDIRECT_BUFFER, drawCommands.get());
  gl::api().BindVertexArray(buffers.vertexArray.get());
}

void Engine::State::drawRange(const DrawRange& range) const {
  gl::api().MultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT,
                                      reinterpret_cast<const void*>(range.first * sizeof(glsl::DrawCommand)),
                                      static_cast<GLsizei>(range.count), 0);
}

void Engine::State::drawDepthList(const DrawList& list, const gl::Program* BatchPrograms::*program,
                                  bool doCull, int layer) {
  useCommands(list);
  for (std::size_t i = 0; i < list.ranges.size(); ++i) {
    DrawRange run = list.ranges[i];
    const Batch& batch = draw.batches[run.batch];
    const BatchPrograms& chosen = batchPrograms[run.batch];
    // Ranges that need no material and share their culling are one multi-draw.
    while (!batch.mask && i + 1 < list.ranges.size()) {
      const DrawRange& next = list.ranges[i + 1];
      const Batch& other = draw.batches[next.batch];
      if (other.mask || other.doubleSided != batch.doubleSided || next.mirrored != run.mirrored) break;
      run.count += next.count;
      ++i;
    }
    (chosen.*program)->use();
    if (layer >= 0) (chosen.*program)->set(LOCATION_VIEW, static_cast<unsigned>(layer));
    if (batch.mask) {
      buffers.bindMaterial(batch.material, chosen.depth);
    }
    gl::applyCulling(doCull && !batch.doubleSided, run.mirrored);
    drawRange(run);
  }
}

void Engine::State::filterShadowMap() {
  const GLint filter = options.shadowFilter == ShadowFilter::Nearest ? GL_NEAREST : GL_LINEAR;
  shadowMap.filter(filter, filter);
}

void Engine::State::makeShadowMap() {
  const int size = options.shadowSize;
  shadowFramebuffers.clear();
  shadowMap = gl::Texture(GL_DEPTH_COMPONENT32F, size, size, 1, static_cast<int>(lights.layers.size()));
  filterShadowMap();
  shadowMap.wrap(GL_CLAMP_TO_EDGE);
  shadowMap.set(GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  shadowMap.set(GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  for (std::size_t i = 0; i < lights.layers.size(); ++i)
    shadowFramebuffers.emplace_back(std::span<const gl::Texture* const>{}, &shadowMap, static_cast<int>(i));
  uploadedLights.clear();
}

void Engine::State::drawShadows() {
  if (!features.shadows) return;
  // A static scene under lights that stand still keeps its shadow map.
  std::vector<bool> stale(lights.layers.size(), features.animated);
  const bool comparable = lights.lights.size() == uploadedLights.size();
  for (std::size_t i = 0; i < lights.lights.size(); ++i) {
    const glsl::LightGpu& light = lights.lights[i];
    if (light.shadowLayer == glsl::kNoShadow) continue;
    const bool moved = !comparable || uploadedLights[i].position != light.position ||
                       uploadedLights[i].direction != light.direction ||
                       uploadedLights[i].coneScale != light.coneScale ||
                       uploadedLights[i].coneOffset != light.coneOffset;
    const std::uint32_t layers = light.type == glsl::kLightPoint ? 6 : 1;
    for (std::uint32_t layer = light.shadowLayer; moved && layer < light.shadowLayer + layers; ++layer)
      stale[layer] = true;
  }
  uploadedLights = lights.lights;
  if (std::none_of(stale.begin(), stale.end(), [](bool b) { return b; })) return;
  pass("shadow", [&] {
    bindScene();
    for (std::size_t layer = 0; layer < lights.layers.size(); ++layer) {
      if (!stale[layer]) continue;
      // The slope-scaled offset covers what the normal offset in lib/shadow.glsl does not: the map's own
      // sampling.
      beginPass(
          shadowFramebuffers[layer], options.shadowSize, options.shadowSize,
          {.depth = gl::DepthTest::Less, .depthWrite = true, .offsetFactor = 1.5f, .offsetUnits = 2.0f});
      clearDepth(shadowFramebuffers[layer], 1.0f);
      // Both sides cast: thin walls and open meshes throw shadows from either.
      drawDepthList(cull(scene, draw, bounds, mirrored, {&lights.layers[layer].frustum, 1}),
                    &BatchPrograms::shadow, false, static_cast<int>(layer));
    }
  });
}

void Engine::findVisible(std::span<const View> views) {
  std::vector<TimedView> timed;
  for (const View& view : views) timed.push_back({s_->now.time, view});
  findVisible(timed);
}

void Engine::findVisible(std::span<const TimedView> wanted) {
  State& s = *s_;
  if (!s.visible || wanted.empty()) return;
  // Who stands still is predicted where they are: such views show what the one before them shows.
  std::vector<TimedView> views;
  for (const TimedView& view : wanted) {
    const bool again = !views.empty() && view.view == views.back().view &&
                       (view.time == views.back().time || !s.features.animated);
    if (!again) views.push_back(view);
  }
  const auto guard = s.guard();
  s.moveAnchor(s.anchorFor(views.front().view));
  s.bindScene();
  s.visible->begin();
  s.gatherer()->beginViews();
  s.viewPixels = 0;
  for (const TimedView& view : views)
    s.viewPixels +=
        static_cast<std::uint64_t>(view.view.width) * static_cast<std::uint64_t>(view.view.height);
  const double present = s.now.time;
  const bool layered = views.size() > 1 && s.drawsIdLayers();
  for (std::size_t first = 0; first < views.size();) {
    const TimedView& leader = views[first];
    std::vector<View> drawn = {leader.view};
    const auto joins = [&](const TimedView& other) {
      return other.view.width == leader.view.width && other.view.height == leader.view.height &&
             (other.time == leader.time || !s.features.animated);
    };
    while (layered && drawn.size() < kMaxViews && first + drawn.size() < views.size() &&
           joins(views[first + drawn.size()]))
      drawn.push_back(views[first + drawn.size()].view);
    s.moveObjects(leader.time);
    s.drawIds(drawn, layered);
    s.pass("mark", [&] {
      const gl::Texture& ids = layered ? s.idLayers.ids : s.id.ids;
      s.visible->add(ids);
      std::vector<glm::mat3> rays;
      for (const View& view : drawn) rays.emplace_back(pixelToRay(view));
      s.gatherer()->addViews(ids, rays);
    });
    s.markBlended(drawn, layered);
    first += drawn.size();
  }
  s.moveObjects(present);
  s.visible->finish();
}

void Engine::State::moveObjects(double to) {
  if (!features.animated || now.time == to) return;
  evaluate(scene, to, now);
  writeInstances();
}

void Engine::State::drawIds(std::span<const View> views, bool layered) {
  idsInLayers = layered;
  IdTarget& target = layered ? idLayers : id;
  const int width = views.front().width;
  const int height = views.front().height;
  setViews(views);
  target.resize(width, height, depth, layered ? static_cast<int>(views.size()) : 0);
  pass("id", [&] {
    beginPass(target.framebuffer, width, height, {.depth = depth.nearer, .depthWrite = true});
    const std::array<GLuint, 4> none = {0, 0, 0, 0};
    gl::api().ClearNamedFramebufferuiv(target.framebuffer.get(), GL_COLOR, 0, none.data());
    clearDepth(target.framebuffer, depth.farthest);
    if (layered)
      drawLayers(visibleDraws(views), views.size(), &BatchPrograms::idLayers);
    else
      drawDepthList(visibleDraws(views), &BatchPrograms::id, true, -1);
  });
}

void Engine::State::drawLayers(DrawList list, std::size_t layers,
                               const gl::Program* BatchPrograms::*program) {
  const auto count = static_cast<glsl::uint>(layers);
  for (glsl::DrawCommand& command : list.commands) command.instanceCount *= count;
  for (const BatchPrograms& batch : batchPrograms)
    if (batch.*program != nullptr) (batch.*program)->set(LOCATION_COUNT, count);
  buffers.stepInstances(count);
  drawDepthList(list, program, true, -1);
  buffers.stepInstances(1);
}

void Engine::State::markBlended(std::span<const View> views, bool layered) {
  pass("mark-blended", [&] {
    const IdTarget& target = layered ? idLayers : id;
    // Nothing is written to the target: one blended surface hides no other.
    beginPass(target.framebuffer, views.front().width, views.front().height, {.depth = depth.nearerOrEqual});
    gl::api().ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    visible->bindMarking();
    const auto program = layered ? &BatchPrograms::markLayers : &BatchPrograms::mark;
    for (const BatchPrograms& batch : batchPrograms)
      if (batch.*program != nullptr) (batch.*program)->set(LOCATION_FRAME, visible->frame());
    const DrawList list = visibleDraws(views, true);
    if (layered)
      drawLayers(list, views.size(), program);
    else
      drawDepthList(list, program, true, -1);
    gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  });
}

void Engine::forward(const View& view, bool depthPrepass) {
  State& s = *s_;
  const auto guard = s.guard();
  s.moveAnchor(s.anchorFor(view));
  s.bindScene();
  s.setViews({&view, 1});
  s.beginPicture(view);
  const DrawList list = s.visibleDraws({&view, 1});
  gl::DrawState state{.depth = s.depth.nearer, .depthWrite = true, .encodeSrgb = true};
  const bool prepass = depthPrepass && s.graph.find("depth-prepass") != nullptr;
  if (prepass)
    s.pass("depth-prepass", [&] {
      beginPass(s.picture.framebuffer, view.width, view.height,
                {.depth = s.depth.nearer, .depthWrite = true});
      gl::api().ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
      clearDepth(s.picture.framebuffer, s.depth.farthest);
      s.drawDepthList(list, &BatchPrograms::depthOnly, true, -1);
    });
  if (prepass) {
    state.depth = gl::DepthTest::Equal;
    state.depthWrite = false;
  }
  const glm::vec4 background(s.options.background, 0.0f);
  if (s.graph.find("forward") == nullptr) {
    beginPass(s.picture.framebuffer, view.width, view.height, state);
    clearColor(s.picture.framebuffer, background);
    clearDepth(s.picture.framebuffer, s.depth.farthest);
  }
  s.pass("forward", [&] {
    beginPass(s.picture.framebuffer, view.width, view.height, state);
    clearColor(s.picture.framebuffer, background);
    if (!prepass) clearDepth(s.picture.framebuffer, s.depth.farthest);
    s.useCommands(list);
    s.counted([&] {
      for (const DrawRange& range : list.ranges) {
        const Batch& batch = s.draw.batches[range.batch];
        const BatchPrograms& programs = s.batchPrograms[range.batch];
        programs.forward->use();
        s.buffers.bindMaterial(batch.material, programs.shading);
        gl::applyCulling(!batch.doubleSided, range.mirrored);
        s.drawRange(range);
      }
    });
  });
  s.drawTransparent(view, "forward-transparent", s.picture.depth);
}

void Engine::State::drawTransparent(const View& view, const char* passName, const gl::Texture& opaque) {
  if (!features.blend) return;
  pass(passName, [&] {
    const std::array<const gl::Texture*, 1> colors = {&picture.color};
    const gl::Framebuffer own =
        &opaque == &picture.depth ? gl::Framebuffer() : gl::Framebuffer(colors, &opaque);
    beginPass(own ? own : picture.framebuffer, view.width, view.height,
              {.depth = depth.nearerOrEqual, .blend = true, .encodeSrgb = true});
    gl::api().BindVertexArray(buffers.vertexArray.get());
    gl::api().VertexArrayElementBuffer(buffers.vertexArray.get(), blendIndices.get());
    const Frustum frustum = frustumOf(viewProjection(view, anchor));
    // Far to near by the centre of the instance's box; within an instance by the centre of each triangle.
    struct Item {
      double distance;
      std::size_t index;
    };
    std::vector<Item> items;
    const auto worldBounds = instanceBounds(scene, draw.blended, now);
    for (std::size_t i = 0; i < draw.blended.size(); ++i) {
      Box box = worldBounds[i];
      const double distance = glm::length(box.centre() - view.eye);
      box.min -= anchor;
      box.max -= anchor;
      if (frustum.touches(box)) items.push_back({distance, i});
    }
    std::stable_sort(items.begin(), items.end(),
                     [](const Item& a, const Item& b) { return a.distance > b.distance; });
    std::vector<std::pair<float, std::uint32_t>> order;
    std::vector<std::uint32_t> sorted;
    for (const Item& item : items) {
      const Instance& instance = draw.blended[item.index];
      const Primitive& primitive = scene.primitives[instance.primitive];
      const Material& material = scene.materials[primitive.material];
      const glm::dmat4& world = now.world[instance.node];
      const glm::vec3 eye(glm::inverse(world) * glm::dvec4(view.eye, 1.0));
      const std::uint32_t* triangles = scene.indices.data() + primitive.firstIndex;
      order.clear();
      for (std::uint32_t t = 0; t < primitive.indexCount / 3; ++t) {
        const glm::vec3 centre =
            (scene.vertices.position[triangles[3 * t]] + scene.vertices.position[triangles[3 * t + 1]] +
             scene.vertices.position[triangles[3 * t + 2]]) /
            3.0f;
        const glm::vec3 d = centre - eye;
        order.emplace_back(-glm::dot(d, d), t);
      }
      std::stable_sort(order.begin(), order.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
      sorted.clear();
      for (const auto& [distance, t] : order)
        sorted.insert(sorted.end(), triangles + 3 * t, triangles + 3 * t + 3);
      blendIndices.write(std::span<const std::uint32_t>(sorted));
      const BlendedPrograms& chosen = blendedPrograms[item.index];
      chosen.forward->use();
      buffers.bindMaterial(primitive.material, chosen.shading);
      gl::applyCulling(!material.doubleSided, mirrors(world));
      gl::api().DrawElementsInstancedBaseInstance(GL_TRIANGLES, static_cast<GLsizei>(sorted.size()),
                                                  GL_UNSIGNED_INT, nullptr, 1,
                                                  static_cast<GLuint>(draw.instances.size() + item.index));
    }
    gl::api().VertexArrayElementBuffer(buffers.vertexArray.get(), buffers.indices.get());
  });
}

}  // namespace tessera
