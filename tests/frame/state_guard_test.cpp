// The engine inside a host's context: every call leaves the host's state as it was, and draws the same
// picture whatever that state is.
#include "engine/gl/state_guard.hpp"

#include <array>
#include <cstdlib>
#include <functional>
#include <regex>
#include <string>
#include <vector>

#include "engine/frame/engine.hpp"
#include "engine/gl/program.hpp"
#include "glsl/shared/bindings.h"
#include "tests/frame/host_state.hpp"
#include "tests/frame/small_scenes.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

/// A context of its own for each test, so that none inherits odd state; the engine only adopts it.
class HostedEngine : public test::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    const bool egl = test::context().info().backend == gl::Backend::Egl;
    auto host = egl ? gl::Context::createEgl({.debug = true}) : gl::Context::createOsMesa({.debug = true});
    ASSERT_TRUE(host) << host.error().message;
    host_ = std::move(*host);
    auto adopted = gl::Context::adoptCurrent(test::procLoader(host_->info().backend));
    ASSERT_TRUE(adopted) << adopted.error().message;
    adopted_ = std::move(*adopted);
  }
  void TearDown() override {
    EXPECT_EQ(gl::api().GetError(), static_cast<GLenum>(GL_NO_ERROR));
    for (const std::string& message : host_->takeErrors()) ADD_FAILURE() << "GL debug message: " << message;
    adopted_.reset();
    host_.reset();
    ASSERT_TRUE(test::context().makeCurrent());
    GlTest::TearDown();
  }

  std::unique_ptr<gl::Context> host_;
  std::unique_ptr<gl::Context> adopted_;
};

/// Calls for every pass: textures, normal map, mask, blend, two kinds of light with shadows, motion,
/// mirroring.
Scene fullScene() {
  Scene scene = test::emptyScene();
  const std::uint32_t checkers = test::addCheckers(scene, 37, 8);
  const std::uint32_t holes = test::addCheckers(scene, 64, 4, true);
  Material solid;
  for (TextureSlot* slot : {&solid.baseColor, &solid.normal, &solid.metallicRoughness, &solid.emissive})
    slot->image = checkers;
  Material leaf;
  leaf.alphaMode = AlphaMode::Mask;
  leaf.doubleSided = true;
  leaf.baseColor.image = holes;
  leaf.baseColor.sampler = {Filter::Nearest, Filter::Nearest, Mip::None, Wrap::Clamp, Wrap::Mirror};
  Material glass;
  glass.alphaMode = AlphaMode::Blend;
  glass.baseColorFactor = {0.2f, 0.4f, 0.9f, 0.5f};
  const auto solidIndex = test::addMaterial(scene, solid);
  const auto leafIndex = test::addMaterial(scene, leaf);
  const auto glassIndex = test::addMaterial(scene, glass);
  scene.nodes.resize(2);
  scene.nodes[1].scale = {-1.0, 1.0, 1.0};
  const auto floor = test::addGrid(scene, {-3, -1, -1}, {6, 0, 0}, {0, 0, -6}, 4, 4, solidIndex);
  const auto wall = test::addGrid(scene, {-3, -1, -7}, {6, 0, 0}, {0, 4, 0}, 4, 4, 0, true);
  const auto card = test::addGrid(scene, {0.4f, -0.8f, -4}, {1.5f, 0, 0.4f}, {0, 1.4f, 0}, 2, 2, leafIndex);
  const auto pane = test::addGrid(scene, {-1.5f, -0.9f, -3}, {2, 0, 0}, {0, 1.5f, 0}, 1, 1, glassIndex);
  for (const std::uint32_t primitive : {floor, wall, card, pane}) test::place(scene, primitive);
  test::place(scene, card, 1);
  scene.vertices.tangent.assign(scene.vertices.position.size(), glm::vec4(1, 0, 0, 1));
  AnimationChannel channel;
  channel.node = 1;
  channel.times = {0.0f, 1.0f};
  channel.values = {glm::vec4(0.0f), glm::vec4(0.0f, 0.5f, 0.0f, 0.0f)};
  scene.animations.push_back({"lift", 1.0, {channel}});
  test::finish(scene);
  return scene;
}

Stage fullStage() {
  Stage stage;
  for (const LightType type : {LightType::Directional, LightType::Point}) {
    StageLight light;
    light.light.type = type;
    light.light.castsShadow = true;
    light.keys.push_back(
        {0.0, {1, 4, 0}, {0, -1, -4}, glm::vec3(1.0f), type == LightType::Point ? 20.0f : 2.0f});
    stage.lights.push_back(light);
  }
  stage.ambient = Ambient{glm::vec3(0.2f), glm::vec3(0.05f)};
  return stage;
}

View frontView(double shift) { return lookAt({shift, 0.8, 1.5}, {0, -0.2, -4}, 60.0, kWidth, kHeight, 0.05); }

/// Everything that a host may call, `after` each call; returns what was drawn.
std::vector<Image> useEngine(gl::Context& context, AtlasFormat format,
                             const std::function<void(const char* call)>& after) {
  std::vector<Image> images;
  EngineOptions options;
  options.atlas.memory.width = 1024;
  options.atlas.memory.height = 1024;
  options.atlas.format = format;
  options.splitEdges = 0.0;
  options.shadowSize = 128;
  options.request.depthPrepass = true;
  options.request.upsample = true;
  options.request.warp = true;
  options.request.displayDeferred = true;
  options.request.lens = true;
  options.timePasses = true;
  options.countFragments = true;
  auto made = Engine::create(context, fullScene(), fullStage(), options);
  after("create");
  if (!made) {
    ADD_FAILURE() << made.error().message;
    return images;
  }
  Engine& engine = **made;
  const auto keep = [&](const char* call) {
    after(call);
    images.push_back(engine.readColor());
    after("readColor");
  };
  engine.update(0.0);
  after("update");
  const View view = frontView(0.0);
  engine.forward(view);
  keep("forward");
  engine.update(0.5);
  after("second update");
  engine.forward(view, true);
  keep("forward with depth pre-pass");
  EXPECT_TRUE(engine.warp(view, frontView(0.05)));
  keep("warp");
  EXPECT_TRUE(engine.upsample(view.width + 8, view.height + 6));
  keep("upsample");
  const std::array<View, 2> views = {view, frontView(0.3)};
  engine.findVisible(views);
  after("findVisible");
  engine.place(views);
  after("place");
  engine.shade(view);
  after("shade");
  engine.display(views[1]);
  keep("display");
  engine.rect(view, DisplayMode::Deferred);
  keep("rect, deferred");
  EXPECT_TRUE(engine.distort({}));
  keep("distort");
  EXPECT_TRUE(engine.place(views, {Foveation{}, Lens{}}));
  after("place with options");
  engine.shade(view);
  engine.display(view);
  keep("display, foveated");
  engine.rect(view, DisplayMode::Deferred);
  for (const DebugView what : {DebugView::Ids, DebugView::Patches, DebugView::Levels, DebugView::TexelDensity,
                               DebugView::Blocks, DebugView::Atlas}) {
    EXPECT_TRUE(engine.debugView(what, view));
    after("debugView");
  }
  EXPECT_FALSE(engine.readAtlas().pixels.empty());
  after("readAtlas");
  EXPECT_EQ(engine.nonFiniteTexels(), 0u);
  after("nonFiniteTexels");
  EXPECT_GT(engine.visibleTriangles(), 0u);
  after("visibleTriangles");
  EXPECT_GT(engine.atlas()->memory().readStatistics().visiblePatches, 0u);
  after("readStatistics");

  TessAtlasOptions tess;
  tess.memory.width = tess.memory.height = 1024;
  tess.format = format;
  EXPECT_TRUE(engine.remakeAtlas(tess));
  after("remakeAtlas");
  // Rasterization sets what rect sets.
  for (const TessGather gather : {TessGather::Compute, TessGather::Tess}) {
    EXPECT_TRUE(engine.setSpawn({gather, 64}));
    after("setSpawn");
    engine.findVisible(views);
    after("findVisible of triangles");
    EXPECT_TRUE(engine.place(views, {Foveation{}, {}}));
    after("place of triangles");
    engine.shade(view);
    after("shade of triangles");
    engine.display(view);
    keep("display of triangles");
    engine.rect(view, DisplayMode::Deferred);
    keep("triangles, deferred");
  }
  EXPECT_GT(engine.tess()->memory().readStatistics().visible, 0u);
  after("readStatistics of triangles");

  // As it is, and scaled into a part of the host's picture.
  gl::Texture picture(GL_RGBA8, kWidth + 40, kHeight + 30);
  const std::array<float, 4> backdrop = {0.25f, 0.5f, 0.75f, 1.0f};
  {
    const gl::StateGuard guard;  // the colour is unpacked as a pixel
    gl::api().ClearTexImage(picture.get(), 0, GL_RGBA, GL_FLOAT, backdrop.data());
  }
  const std::array<const gl::Texture*, 1> colors = {&picture};
  const gl::Framebuffer framebuffer(colors);
  engine.blit(framebuffer.get(), 7, 5, kWidth, kHeight);
  after("blit");
  engine.blit(framebuffer.get(), 20, 60, 50, 40);
  after("scaled blit");
  {
    const gl::StateGuard guard;
    images.push_back(
        {picture.width(), picture.height(), gl::readTexture(picture, GL_RGBA, GL_UNSIGNED_BYTE, 4)});
  }
  made->reset();
  after("destruction");
  return images;
}

/// Largest difference of a channel, and how many pixels differ at all.
std::pair<int, std::size_t> compare(const Image& a, const Image& b) {
  if (a.pixels.size() != b.pixels.size()) return {256, a.pixels.size() + b.pixels.size()};
  int largest = 0;
  std::size_t differing = 0;
  for (std::size_t i = 0; i < a.pixels.size(); i += 4) {
    int difference = 0;
    for (std::size_t c = 0; c < 4; ++c)
      difference = std::max(difference, std::abs(int{a.pixels[i + c]} - int{b.pixels[i + c]}));
    largest = std::max(largest, difference);
    differing += difference > 0 ? 1 : 0;
  }
  return {largest, differing};
}

void expectUntouchedAndEqual(gl::Context& context, AtlasFormat format) {
  const GladGLContext& gl = gl::api();
  const std::vector<Image> clean = useEngine(context, format, [](const char*) {});
  const test::HostState defaults = test::readHostState(gl);

  const test::OddState odd(gl);
  test::HostState before = test::readHostState(gl);
  EXPECT_EQ(gl.GetError(), static_cast<GLenum>(GL_NO_ERROR));
  // A field that kept its default would not show a guard that forgets it.
  for (const auto& [name, value] : before) {
    if (name.rfind("DEBUG_", 0) == 0) continue;  // the host's own, set when it made the context
    if (name == "SHADER_STORAGE_BUFFER_START[2]" || name == "SHADER_STORAGE_BUFFER_SIZE[2]")
      continue;  // whole
    const bool indexed = name.find('[') != std::string::npos;
    // Every second switch of an indexed set is left alone, so that one value for all would show.
    if (indexed && (name.rfind("BLEND[", 0) == 0 || name.rfind("SCISSOR_TEST[", 0) == 0 ||
                    name.rfind("IMAGE_BINDING_LAYERED[", 0) == 0))
      continue;
    EXPECT_NE(value, defaults.at(name)) << name << " is not odd";
  }
  const std::vector<Image> images = useEngine(context, format, [&](const char* call) {
    const test::HostState after = test::readHostState(gl);
    for (const std::string& line : test::differences(before, after)) ADD_FAILURE() << call << ": " << line;
    before = after;  // blames only the call that did it
    EXPECT_EQ(gl.GetError(), static_cast<GLenum>(GL_NO_ERROR)) << call;
  });
  ASSERT_EQ(images.size(), clean.size());
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const auto [largest, differing] = compare(clean[i], images[i]);
    // Blocks are placed in the order in which atomics happen to run, and interpolation elsewhere in the atlas
    // may round the last bit of a texel the other way: seen as one pixel of one picture, off by one. Wrong
    // state shows in far more.
    EXPECT_LE(largest, 1) << "picture " << i << ": " << differing << " pixels differ";
    EXPECT_LE(differing, 8u) << "picture " << i;
  }
}

TEST_F(HostedEngine, LeavesOddStateAsItWasAndDrawsTheSame) {
  expectUntouchedAndEqual(*adopted_, AtlasFormat::Srgb8);
}

TEST_F(HostedEngine, LeavesOddStateAsItWasWithALinearAtlas) {
  expectUntouchedAndEqual(*adopted_, AtlasFormat::Rgba16f);
}

TEST_F(HostedEngine, LeavesTheDefaultStateToo) {
  const GladGLContext& gl = gl::api();
  const test::HostState before = test::readHostState(gl);
  useEngine(*adopted_, AtlasFormat::Srgb8, [&](const char* call) {
    for (const std::string& line : test::differences(before, test::readHostState(gl)))
      ADD_FAILURE() << call << ": " << line;
  });
}

TEST_F(HostedEngine, AProgramDeletedWhileCurrentIsNoError) {
  const GladGLContext& gl = gl::api();
  const GLuint program = test::linkEmptyProgram(gl);
  gl.UseProgram(program);
  gl.DeleteProgram(program);  // lives on for as long as it is current
  {
    const gl::StateGuard guard;
    gl.UseProgram(0);
  }
  GLint now = -1;
  gl.GetIntegerv(GL_CURRENT_PROGRAM, &now);
  EXPECT_EQ(now, 0);
}

TEST(Bindings, CountsCoverEveryBinding) {
  const auto text = gl::glslText("shared/bindings.h");
  ASSERT_TRUE(text) << text.error().message;
  const std::regex line(R"(#define (BIND|UNIT)_(\w+) +(\d+))");
  int units = 0;
  int highest = 0;
  for (auto it = std::cregex_iterator(text->data(), text->data() + text->size(), line);
       it != std::cregex_iterator(); ++it) {
    const std::string name = (*it)[2];
    const int number = std::stoi((*it)[3]);
    if (name == "COUNT" || name.ends_with("_COUNT")) continue;
    int& most = (*it)[1] == "UNIT" ? units : highest;
    most = std::max(most, number);
  }
  EXPECT_EQ(highest + 1, BIND_STORAGE_COUNT);
  EXPECT_EQ(units + 1, UNIT_COUNT);
}

}  // namespace
}  // namespace tessera
