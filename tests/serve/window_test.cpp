// The viewer's window as an X server has it: a true screenshot, compared with the picture that a viewer
// without a window drew of the same frame.
#include <csignal>

#include "engine/measure/metrics.hpp"
#include "tests/serve/processes.hpp"

namespace tessera {
namespace {

using test::kSeconds;

/// An X server without a screen, which keeps its picture in a file.
class XServer {
 public:
  static bool there() {
    std::istringstream path(std::getenv("PATH") != nullptr ? std::getenv("PATH") : "");
    for (std::string folder; std::getline(path, folder, ':');)
      if (std::filesystem::exists(std::filesystem::path(folder) / "Xvfb")) return true;
    return false;
  }
  XServer()
      : folder_(std::filesystem::path(testing::TempDir()) / "serve_x"),
        made_(std::filesystem::create_directories(folder_)),
        program_("Xvfb",
                 {"-nocursor", "-displayfd", "1", "-screen", "0", "320x240x24", "-nolisten", "tcp", "-fbdir",
                  folder_.string()},
                 "") {
    // It prints its number, once it takes windows.
    EXPECT_TRUE(program_.waitFor("\n", kSeconds)) << program_.said();
    display_ = ":" + program_.after("");
  }
  ~XServer() { program_.end(SIGTERM); }
  XServer(const XServer&) = delete;
  XServer& operator=(const XServer&) = delete;
  [[nodiscard]] const std::string& display() const { return display_; }

  /// What is at the top left of the screen. The file is an X window dump (XWDFile.h, version 7).
  [[nodiscard]] Image screenshot(int width, int height) const {
    std::ifstream file(folder_ / "Xvfb_screen0", std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    const auto field = [&](std::size_t index) {  // big-endian
      std::size_t value = 0;
      for (std::size_t i = 0; i < 4 && 4 * index + i < bytes.size(); ++i)
        value = value << 8 | static_cast<unsigned char>(bytes[4 * index + i]);
      return value;
    };
    EXPECT_EQ(field(1), 7u) << "version";
    EXPECT_EQ(field(7), 0u) << "pixels from their lowest byte";
    EXPECT_EQ(field(11), 32u) << "bits a pixel";
    EXPECT_EQ(field(14), 0xff0000u) << "where red is";
    const std::size_t pixels = field(0) + 12 * field(19);
    const std::size_t row = field(12);
    Image image;
    if (testing::Test::HasFailure() || bytes.size() < pixels + row * static_cast<std::size_t>(height))
      return image;
    image.width = width;
    image.height = height;
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
      for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
        const auto* at = reinterpret_cast<const std::uint8_t*>(bytes.data()) + pixels + y * row + 4 * x;
        image.pixels.insert(image.pixels.end(), {at[2], at[1], at[0], 255});
      }
    return image;
  }

 private:
  std::filesystem::path folder_;
  bool made_;
  test::Program program_;
  std::string display_;
};

TEST(Window, ShowsWhatAViewerWithoutOneDraws) {
  if (!XServer::there()) GTEST_SKIP() << "Xvfb is not installed: ./run.sh installs it";
  const XServer x;
  ASSERT_FALSE(HasFailure());
  // Each frame stands long enough to be looked at.
  const test::Server server("127.0.0.1:0", {"--fps", "2", "--bitrate", "4M"});
  const std::vector<std::string> same = {"--size",        "320x180",  "--eye",
                                         "10.2,1.75,4.1", "--target", "0,2.4,-0.4"};
  test::Viewer without("without", server.address, same);
  std::vector<std::string> options = same;
  options.emplace_back("--no-overlay");
  test::Viewer window = test::Viewer::inWindow("window", server.address, x.display(), options);
  Image shot;
  std::uint32_t frame = 0;
  ASSERT_TRUE(test::waitFor([&] {
    if (!window.program().runs()) return true;
    // Of a frame that was shown for a while before, and still is afterwards.
    const auto rows = window.rows();
    const std::size_t count = rows.size();
    if (count < 3 || rows[count - 3].frame < 4 || rows[count - 3].frame != rows[count - 1].frame)
      return false;
    frame = rows.back().frame;
    shot = x.screenshot(320, 180);
    return window.shown() == frame && window.rows().back().live && without.shown() >= frame;
  })) << window.program().said();
  if (window.program().waitFor("built without GLFW", 0)) GTEST_SKIP() << "built without a window";
  ASSERT_TRUE(window.program().runs()) << window.program().said();
  ASSERT_FALSE(shot.pixels.empty());
  EXPECT_GT(window.end().at("frames_shown"), 0);
  without.end();
  const auto pictures = without.pictures();
  ASSERT_TRUE(pictures.contains(frame)) << "atlas frame " << frame << " of " << pictures.size();
  Image expected = pictures.at(frame);
  for (std::size_t i = 3; i < expected.pixels.size(); i += 4) expected.pixels[i] = 255;  // a screen has none
  const std::string file = testing::TempDir() + "serve_window";
  ASSERT_TRUE(writePng(file + "_shot.png", shot));
  ASSERT_TRUE(writePng(file + "_expected.png", expected));
  const auto alike = psnr(expected, shot);
  ASSERT_TRUE(alike) << alike.error().message;
  EXPECT_GT(*alike, 40.0) << file << "_shot.png and _expected.png";
}

}  // namespace
}  // namespace tessera
