// Server and viewer as two processes, over a good network and a bad one: what the viewer shows, what it says
// of it, and that either may die and come back.
#include <csignal>

#include "engine/measure/metrics.hpp"
#include "tests/serve/processes.hpp"
#include "tests/transport/proxy.hpp"

namespace tessera {
namespace {

using test::kSeconds;
using test::Server;
using test::Viewer;
using test::waitFor;

constexpr int kLatestHeal = 10;  // server's frames after an outage

/// PSNR in dB; infinite for pictures that are the same.
double alike(const Image& a, const Image& b) {
  const auto value = psnr(a, b);
  EXPECT_TRUE(value) << value.error().message;
  return value ? *value : 0.0;
}

transport::Address parsed(const std::string& address) { return *transport::parseAddress(address); }

void expectStages(const nlohmann::json& stats) {
  for (const char* stage : {"server", "receive", "decode", "apply", "wait", "upload", "display", "total"}) {
    ASSERT_TRUE(stats.at("latency_ms").at(stage).is_number()) << stage << ": " << stats.dump(2);
    EXPECT_GE(stats.at("latency_ms").at(stage).get<double>(), 0.0) << stage;
  }
  EXPECT_GE(stats.at("latency_ms").at("total"), stats.at("latency_ms").at("server"));
}

// What is shown over a bad network is what is shown over a good one: pictures are missing, none is broken,
// and geometry is never lost.
TEST(Processes, ABadNetworkShowsTheSamePictures) {
  Server server("127.0.0.1:0", {"--i-frames", "8"});
  test::Impairment bad;
  bad.loss = 0.05;
  bad.delayMs = 20.0;
  test::Proxy proxy(parsed(server.address), bad, 7);
  Viewer good("good", server.address, {"--eye", "10.2,1.75,4.1", "--target", "0,2.4,-0.4"});
  Viewer lossy("lossy", transport::describe(proxy.address()),
               {"--eye", "10.2,1.75,4.1", "--target", "0,2.4,-0.4"});
  ASSERT_TRUE(waitFor([&] { return good.shown() > 0 && lossy.shown() > 0; }))
      << good.program().said() << lossy.program().said();
  const std::uint32_t first = good.shown();
  ASSERT_TRUE(waitFor([&] { return good.shown() >= first + 32; })) << server.program.said();
  // It goes on to the end.
  ASSERT_TRUE(waitFor([&] { return lossy.shown() >= first + 24; })) << lossy.program().said();
  ASSERT_TRUE(waitFor([&] { return lossy.rows().back().live; })) << lossy.program().said();
  const auto goodStats = good.end();
  const auto lossyStats = lossy.end();
  expectStages(goodStats);
  expectStages(lossyStats);
  EXPECT_EQ(goodStats.at("loss_percent"), 0.0);
  const test::ProxyStatistics passed = proxy.statistics();
  const double injected = 100.0 * static_cast<double>(passed.lost) / static_cast<double>(passed.datagrams);
  EXPECT_NEAR(lossyStats.at("loss_percent").get<double>(), injected, 2.5);
  EXPECT_GT(lossyStats.at("loss_percent").get<double>(), 0.5);
  EXPECT_EQ(lossyStats.at("reconnects"), 0) << "its geometry was never at odds";
  const auto there = good.pictures();
  const auto here = lossy.pictures();
  int compared = 0;
  for (const auto& [frame, picture] : here) {
    const auto other = there.find(frame);
    if (other == there.end()) continue;
    ++compared;
    EXPECT_GT(alike(picture, other->second), 40.0) << "atlas frame " << frame;
  }
  EXPECT_GE(compared, 8) << here.size() << " of " << there.size();
}

// All video is lost for a while, and there are no regular I-frames: one that is asked for heals the picture.
TEST(Processes, AnOutageHealsByAnIFrame) {
  Server server("127.0.0.1:0", {"--i-frames", "0"});
  test::Impairment network;
  network.delayMs = 20.0;
  test::Proxy proxy(parsed(server.address), network, 11);
  Viewer good("outage_good", server.address);
  Viewer cut("outage_cut", transport::describe(proxy.address()));
  ASSERT_TRUE(waitFor([&] { return good.shown() >= 4 && cut.shown() >= 4; })) << cut.program().said();
  network.loss = 1.0;
  proxy.impair(network);
  const std::uint32_t from = good.shown();
  ASSERT_TRUE(waitFor([&] { return good.shown() >= from + 5; })) << server.program.said();
  const std::uint32_t stood = cut.shown();
  const std::uint32_t until = good.shown();
  network.loss = 0.0;
  proxy.impair(network);
  ASSERT_TRUE(waitFor([&] { return cut.shown() > stood; })) << cut.program().said();
  EXPECT_LE(cut.shown(), until + kLatestHeal);
  // From then on it misses little.
  const std::uint32_t healed = cut.shown();
  ASSERT_TRUE(waitFor([&] { return cut.shown() >= healed + 5; })) << cut.program().said();
  const auto stats = cut.end();
  EXPECT_GE(stats.at("i_frames_asked"), 1);
  EXPECT_GT(stats.at("loss_percent").get<double>(), 0.0);
}

TEST(Processes, EitherSideMayDieAndReturn) {
  auto server = std::make_unique<Server>();
  const std::string address = server->address;
  auto killed = std::make_unique<Viewer>("killed", address);
  Viewer stays("stays", address);
  ASSERT_TRUE(waitFor([&] { return killed->shown() >= 3 && stays.shown() >= 3; })) << server->program.said();
  killed->program().end(SIGKILL);
  ASSERT_TRUE(server->program.waitFor("left", kSeconds)) << server->program.said();
  Viewer returned("returned", address);
  const std::uint32_t before = stays.shown();
  ASSERT_TRUE(waitFor([&] { return returned.shown() > before && stays.shown() > before; }))
      << returned.program().said();
  expectStages(returned.end());

  server->program.end(SIGKILL);
  ASSERT_TRUE(waitFor([&] { return !stays.rows().back().live; }));
  const std::uint32_t last = stays.shown();
  server = std::make_unique<Server>(address);
  // The new server counts anew.
  ASSERT_TRUE(waitFor([&] {
    const auto rows = stays.rows();
    return rows.back().live && rows.back().frame >= 4 && rows.back().frame != last;
  })) << stays.program().said();
  EXPECT_TRUE(stays.program().waitFor("connecting again", kSeconds)) << stays.program().said();
  EXPECT_EQ(stays.end().at("reconnects"), 1);
  EXPECT_EQ(server->program.end(SIGINT), 0) << server->program.said();
}

// The stage's start camera and its paths come from the server.
TEST(Processes, CamerasAreTheStages) {
  Server server("127.0.0.1:0", {"--bitrate", "10M"});
  Viewer unknown("unknown", server.address, {"--path", "no_such_path"});
  EXPECT_TRUE(unknown.program().waitFor("stage has only tour", kSeconds)) << unknown.program().said();
  EXPECT_EQ(unknown.program().end(0), 2);
  Viewer start("start", server.address, {"--frames", "3"});
  Viewer tour("tour", server.address, {"--path", "tour", "--frames", "3"});
  Viewer there("there", server.address,
               {"--eye", "10.2,1.75,4.1", "--target", "0,2.4,-0.4", "--fov-y", "65", "--frames", "3"});
  for (Viewer* viewer : {&start, &tour, &there})
    ASSERT_TRUE(waitFor([&] { return std::filesystem::exists(viewer->file("json")); }))
        << viewer->program().said();
  const auto first = [](const Viewer& viewer) {
    const auto picture = readImage(viewer.file("shown") + "/0001.png");
    EXPECT_TRUE(picture) << picture.error().message;
    return picture ? *picture : Image();
  };
  // The tour's first key, which is not where the scene's first camera is.
  EXPECT_GT(alike(first(tour), first(there)), 25.0);
  EXPECT_LT(alike(first(start), first(there)), 20.0);
}

}  // namespace
}  // namespace tessera
