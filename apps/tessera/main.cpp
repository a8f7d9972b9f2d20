#include <cstdio>
#include <utility>
#include <vector>

#include <fmt/core.h>

#include "apps/tessera/commands.hpp"
#include "apps/tessera/report_output.hpp"

namespace {

int run(int argc, char** argv) {
  using tessera::app::Exit;
  CLI::App app(
      "Tessera: shades the visible surfaces of a scene into one texture and draws any number of views from "
      "it.");
  app.name("tessera");
  app.require_subcommand(1);
  Exit ending = Exit::Ok;
  const std::vector<std::pair<std::string, tessera::app::Run>> commands = {
      {"render", tessera::app::addRender(app)},
      {"info", tessera::app::addInfo(app)},
      {"compare", tessera::app::addCompare(app)},
      {"atlas-bench", tessera::app::addAtlasBench(app)},
      {"stability", tessera::app::addStability(app, ending)},
      {"accuracy", tessera::app::addAccuracy(app)},
      {"pvs", tessera::app::addPvs(app)},
#ifdef TESSERA_HAS_CODEC
      {"video-bench", tessera::app::addVideoBench(app)},
      {"serve", tessera::app::addServe(app)},
      {"view", tessera::app::addView(app)},
      {"stream-study", tessera::app::addStreamStudy(app)},
#endif
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // CLI11 prints help, or the one line that says which option is wrong.
    return app.exit(error) == 0 ? static_cast<int>(Exit::Ok) : static_cast<int>(Exit::BadInput);
  }
  for (const auto& [name, command] : commands) {
    if (!app.got_subcommand(name)) continue;
    auto result = tessera::app::checkFinite(*app.get_subcommand(name));
    if (result) result = command(tessera::app::commandLine(argc, argv));
    if (result) return static_cast<int>(ending);
    fmt::print(stderr, "tessera {}: {}\n", name, result.error().message);
    return static_cast<int>(Exit::BadInput);
  }
  return static_cast<int>(Exit::BadInput);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tessera: %s\n", error.what());
    return static_cast<int>(tessera::app::Exit::Failed);
  }
}
