// Server and viewer for long, over a bad network, with viewers that come and go beside them: the memory of
// both stays flat. Only where TESSERA_SOAK_MINUTES says for how long.
#include <csignal>
#include <cstdlib>

#include "engine/measure/statistics.hpp"
#include "tests/serve/processes.hpp"
#include "tests/transport/proxy.hpp"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kWarmUp = 0.2;  // share of the time; at least a minute of ten
constexpr double kMostGrowth = 1.05;

/// Resident memory of a process, MiB.
double residentMib(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/statm", process));
  double pages = 0.0;
  file >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// Back and forth through the atrium.
void writePath(const std::string& file, double seconds) {
  const double eyes[4][3] = {{10.2, 1.75, 4.1}, {3.0, 3.1, 3.0}, {-0.6, 5.7, 4.2}, {3.0, 1.8, -1.0}};
  nlohmann::json keys = nlohmann::json::array();
  for (int i = 0; 4.0 * i <= seconds + 8.0; ++i) {
    const auto& eye = eyes[i % 4];
    keys.push_back(
        {{"t", 4.0 * i}, {"eye", {eye[0], eye[1], eye[2]}}, {"target", {-3.0, 3.0, 0.5}}, {"fov_y", 60}});
  }
  std::ofstream(file) << nlohmann::json{{"keyframes", keys}};
}

struct Memory {
  std::vector<double> first, second;  // halves after the warm-up
  [[nodiscard]] double growth() const { return summarize(second).median / summarize(first).median; }
};

TEST(Soak, MemoryOfBothStaysFlat) {
  const char* minutes = std::getenv("TESSERA_SOAK_MINUTES");
  if (minutes == nullptr) GTEST_SKIP() << "takes minutes: ./run.sh soak-stream";
  const double seconds = 60.0 * std::atof(minutes);
  ASSERT_GE(seconds, 30.0) << minutes << " minutes are too few for a median";
  const std::string path = testing::TempDir() + "soak_path.json";
  writePath(path, seconds);
  test::Server server("127.0.0.1:0", {"--fps", "10", "--bitrate", "500k", "--i-frames", "20"});
  test::Impairment bad;
  bad.loss = 0.05;
  bad.delayMs = 20.0;
  bad.jitterMs = 5.0;
  test::Proxy proxy(*transport::parseAddress(server.address), bad, 3);
  const std::vector<std::string> quiet = {"--size", "640x360", "--fps", "10", "--record", ""};
  test::Viewer viewer("soak", transport::describe(proxy.address()),
                      test::withDefaults(quiet, {"--path", path}));
  ASSERT_TRUE(test::waitFor([&] { return viewer.shown() > 0; })) << viewer.program().said();
  Memory served, viewed;
  std::unique_ptr<test::Viewer> guest;
  const Clock::time_point start = Clock::now();
  int guests = 0;
  for (double at = 0.0; at < seconds; at = std::chrono::duration<double>(Clock::now() - start).count()) {
    server.program.drain();
    viewer.program().drain();
    ASSERT_TRUE(server.program.runs()) << server.program.said();
    ASSERT_TRUE(viewer.program().runs()) << viewer.program().said();
    // One is there for half of each 30 s; every second one is killed.
    const int phase = static_cast<int>(at / 15.0);
    if (phase % 2 == 1 && !guest) {
      guest = std::make_unique<test::Viewer>("soak_guest", server.address, quiet);
      ++guests;
    } else if (phase % 2 == 0 && guest) {
      guest->program().end(guests % 2 == 0 ? SIGKILL : SIGTERM);
      guest.reset();
    }
    if (guest) guest->program().drain();
    if (at > kWarmUp * seconds) {
      const bool late = at > 0.5 * (1.0 + kWarmUp) * seconds;
      (late ? served.second : served.first).push_back(residentMib(server.program.process()));
      (late ? viewed.second : viewed.first).push_back(residentMib(viewer.program().process()));
    }
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
  const auto stats = viewer.end();
  fmt::print("{} minutes, {} guests, {} frames shown, {} atlas frames, {:.2f} % of packets lost\n", minutes,
             guests, stats.at("frames_shown").get<int>(), stats.at("atlas_frames_received").get<int>(),
             stats.at("loss_percent").get<double>());
  for (const auto& [name, memory] :
       {std::pair<const char*, const Memory&>{"server", served}, {"viewer", viewed}})
    fmt::print("{}: {:.1f} MiB, then {:.1f} MiB ({:+.2f} %), most {:.1f} MiB\n", name,
               summarize(memory.first).median, summarize(memory.second).median,
               100.0 * (memory.growth() - 1.0),
               *std::max_element(memory.second.begin(), memory.second.end()));
  EXPECT_LE(served.growth(), kMostGrowth);
  EXPECT_LE(viewed.growth(), kMostGrowth);
  EXPECT_EQ(stats.at("reconnects"), 0);
}

}  // namespace
}  // namespace tessera
