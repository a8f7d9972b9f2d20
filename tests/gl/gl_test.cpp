#include "tests/gl_test.hpp"

#include <array>
#include <vector>

#include "engine/gl/objects.hpp"
#include "engine/gl/program.hpp"
#include "engine/gl/timer.hpp"

namespace tessera {
namespace {

using GlObjects = test::GlTest;

TEST_F(GlObjects, BuffersKeepWhatIsWritten) {
  const std::vector<std::uint32_t> values = {1, 2, 3, 4, 5};
  gl::Buffer buffer(values);
  EXPECT_EQ(buffer.readAll<std::uint32_t>(5), values);
  buffer.fill(7, 4, 8);
  EXPECT_EQ(buffer.readAll<std::uint32_t>(5), (std::vector<std::uint32_t>{1, 7, 7, 4, 5}));
  gl::Buffer moved = std::move(buffer);
  EXPECT_FALSE(
      buffer);  // NOLINT(bugprone-use-after-move): that a moved-from buffer is empty is what is tested
  EXPECT_EQ(moved.readAll<std::uint32_t>(1)[0], 1u);
  const gl::Buffer zeroes(64);
  for (const std::uint32_t value : zeroes.readAll<std::uint32_t>(16)) EXPECT_EQ(value, 0u);
  const gl::Buffer empty{std::vector<float>{}};
  EXPECT_TRUE(empty);
}

TEST_F(GlObjects, ViewReadsTheSameTexels) {
  gl::Texture texture(GL_SRGB8_ALPHA8, 2, 1);
  const std::array<std::uint8_t, 8> pixels = {10, 20, 30, 40, 50, 60, 70, 80};
  texture.upload(0, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  const gl::Texture raw = texture.view(GL_RGBA8);
  const auto read = gl::readTexture(raw, GL_RGBA, GL_UNSIGNED_BYTE, 4);
  EXPECT_TRUE(std::equal(read.begin(), read.end(), pixels.begin(), pixels.end()));
}

TEST_F(GlObjects, ShaderErrorsNameTheFile) {
  auto missing = gl::Program::build(test::context(), {"pass/not_there.comp"});
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("pass/not_there.comp"), std::string::npos);
  auto stage = gl::Program::build(test::context(), {"shared/scene.h"});
  ASSERT_FALSE(stage);
  EXPECT_NE(stage.error().message.find(".h"), std::string::npos);
}

TEST_F(GlObjects, IncludesAreExpandedOnce) {
  std::vector<std::string> files;
  auto text = gl::assembleShader("#version 450 core\n", "shared/scene.h", {{"SOME_DEFINE", "3"}}, files);
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_NE(text->find("#define SOME_DEFINE 3"), std::string::npos);
  EXPECT_EQ(text->find("#include \""), std::string::npos);
  EXPECT_EQ(files, (std::vector<std::string>{"shared/scene.h", "shared/dialect.h"}));
}

TEST_F(GlObjects, TimerMeasuresSomething) {
  gl::Timer timer(gl::timerModeFor(test::context().info()));
  gl::Texture texture(GL_RGBA8, 2048, 2048);
  const std::array<float, 4> color = {1, 0, 0, 1};
  timer.begin();
  for (int i = 0; i < 4; ++i) gl::api().ClearTexImage(texture.get(), 0, GL_RGBA, GL_FLOAT, color.data());
  timer.end();
  EXPECT_GT(timer.milliseconds(), 0.0);
}

TEST_F(GlObjects, PipelineStatisticsCount) {
  const gl::Query query(GL_FRAGMENT_SHADER_INVOCATIONS);
  query.begin();
  query.end();
  EXPECT_EQ(query.result(), 0u);
}

}  // namespace
}  // namespace tessera
