// Packing and unpacking inside a host's context: its state stays, whatever it is, and so do the results.
#include "engine/yuv/packer.hpp"
#include "engine/yuv/unpacker.hpp"
#include "tests/frame/host_state.hpp"
#include "tests/gl_test.hpp"

namespace tessera {
namespace {

class HostedPlanes : public test::GlTest {
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
    for (const std::string& message : host_->takeErrors()) ADD_FAILURE() << "GL debug message: " << message;
    adopted_.reset();
    host_.reset();
    ASSERT_TRUE(test::context().makeCurrent());
    GlTest::TearDown();
  }
  std::unique_ptr<gl::Context> host_;
  std::unique_ptr<gl::Context> adopted_;
};

TEST_F(HostedPlanes, LeaveOddStateAsItWas) {
  constexpr int kWidth = 50;
  constexpr int kHeight = 22;
  Image image{kWidth, kHeight, std::vector<std::uint8_t>(std::size_t{4} * kWidth * kHeight)};
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<std::uint8_t>(i * 37);
  gl::Texture texture(GL_RGBA8, kWidth, kHeight);
  texture.upload(0, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());

  const GladGLContext& gl = gl::api();
  const test::OddState odd(gl);
  const test::HostState before = test::readHostState(gl);
  const auto untouched = [&](const char* call) {
    for (const std::string& line : test::differences(before, test::readHostState(gl)))
      ADD_FAILURE() << call << ": " << line;
  };
  {
    auto packer = YuvPacker::create(*adopted_, kWidth, kHeight, Chroma::Yuv420);
    untouched("YuvPacker::create");
    auto unpacker = YuvUnpacker::create(*adopted_);
    untouched("YuvUnpacker::create");
    ASSERT_TRUE(packer && unpacker);
    ASSERT_TRUE(packer->pack(texture, 3));
    untouched("pack");
    (void)packer->latest();
    untouched("latest");
    const auto read = packer->read();
    untouched("read");
    const auto wanted = toYuv(image, Chroma::Yuv420);
    ASSERT_TRUE(read && wanted);
    EXPECT_EQ(std::vector(read->planes.view().planes[0], read->planes.view().planes[0] + kWidth),
              std::vector(wanted->view().planes[0], wanted->view().planes[0] + kWidth));
    ASSERT_TRUE(unpacker->unpack(wanted->view()));
    untouched("unpack");
  }
  untouched("destruction");
}

}  // namespace
}  // namespace tessera
