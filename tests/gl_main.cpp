#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "tests/gl_test.hpp"

namespace tessera::test {

namespace {
std::unique_ptr<gl::Context> made;
}

gl::Context& context() { return *made; }

void GlTest::SetUp() { context().takeErrors(); }
void GlTest::TearDown() {
  for (const std::string& message : context().takeErrors()) ADD_FAILURE() << "GL debug message: " << message;
}

}  // namespace tessera::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  const char* wanted = std::getenv("TESSERA_TEST_CONTEXT");
  const std::string name = wanted == nullptr ? "osmesa" : wanted;
  tessera::gl::ContextOptions options;
  options.debug = true;
  auto context =
      name == "egl" ? tessera::gl::Context::createEgl(options) : tessera::gl::Context::createOsMesa(options);
  if (!context) {
    std::fprintf(stderr, "no %s context: %s\n", name.c_str(), context.error().message.c_str());
    return 1;  // a run without its context is a failure, not a skip
  }
  tessera::test::made = std::move(*context);
  const auto& info = tessera::test::made->info();
  std::printf("context: %s, %s, GL %s, GLSL %s\n", info.backendName.c_str(), info.renderer.c_str(),
              info.version.c_str(), info.glslVersion.c_str());
  // The true 4.6 is the point of the second path: a driver that quietly gives less would hide it.
  if (name == "egl" && info.minor < 6) {
    std::fprintf(stderr, "the egl context is only %d.%d: zink is not in use\n", info.major, info.minor);
    return 1;
  }
  const int result = RUN_ALL_TESTS();
  tessera::test::made.reset();
  return result;
}
