#include "engine/gl/readback.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "tests/gl_test.hpp"

namespace tessera {
namespace {

// A GPU that is as far behind as a test wants: of the fences only the `passed` oldest pass.
std::size_t passed = 0;
std::vector<GLsync> fences;
PFNGLFENCESYNCPROC driversFence = nullptr;
PFNGLCLIENTWAITSYNCPROC driversWait = nullptr;

GLsync keepFence(GLenum condition, GLbitfield flags) {
  fences.push_back(driversFence(condition, flags));
  return fences.back();
}

GLenum waitIfAllowed(GLsync sync, GLbitfield /*flags*/, GLuint64 /*timeout*/) {
  // A driver may give the address of a deleted fence to a new one.
  const auto age = std::find(fences.rbegin(), fences.rend(), sync);
  if (static_cast<std::size_t>(fences.rend() - age) > passed) return GL_TIMEOUT_EXPIRED;
  return driversWait(sync, GL_SYNC_FLUSH_COMMANDS_BIT, std::numeric_limits<GLuint64>::max());
}

class Readback : public test::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    passed = 0;
    fences.clear();
    driversFence = functions().FenceSync;
    driversWait = functions().ClientWaitSync;
    functions().FenceSync = keepFence;
    functions().ClientWaitSync = waitIfAllowed;
  }
  void TearDown() override {
    functions().FenceSync = driversFence;
    functions().ClientWaitSync = driversWait;
    GlTest::TearDown();
  }
  /// Those of the context, which owns them and is not const.
  static GladGLContext& functions() { return const_cast<GladGLContext&>(gl::api()); }

  /// The source holds `value` when it is copied.
  void request(std::uint32_t value) {
    source.writeValue(value);
    readback.request(source);
  }
  std::uint32_t latest() {
    std::uint32_t value = 0;
    if (const void* bytes = readback.latest()) std::memcpy(&value, bytes, sizeof(value));
    return value;
  }
  gl::Buffer source{sizeof(std::uint32_t)};
  gl::Readback readback{sizeof(std::uint32_t), 4};
};

TEST_F(Readback, TheLastThatArrivedStaysHoweverFarTheGpuIsBehind) {
  EXPECT_EQ(readback.latest(), nullptr);
  std::uint32_t frame = 0;
  for (; frame < 10;) request(++frame);
  EXPECT_EQ(readback.latest(), nullptr) << "nothing has arrived";
  passed = 1;
  EXPECT_EQ(latest(), 1u) << "and what was asked for first was not given up";
  for (; frame < 30;) {
    request(++frame);
    EXPECT_EQ(latest(), 1u) << "frame " << frame;
  }
  // Once the GPU has caught up, the copies are new ones.
  passed = 1000;
  EXPECT_EQ(latest(), 4u) << "the slots were full then";
  for (; frame < 40;) {
    request(++frame);
    EXPECT_EQ(latest(), frame);
  }
}

TEST_F(Readback, AGpuAFewFramesBehindLeavesNothingOut) {
  std::uint32_t frame = 0;
  for (; frame < 2;) request(++frame);
  for (; frame < 20;) {
    ++passed;
    request(++frame);
    EXPECT_EQ(latest(), frame - 2);
  }
}

}  // namespace
}  // namespace tessera
