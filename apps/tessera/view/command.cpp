// tessera view: a thin viewer of what `tessera serve` sends.
#include "apps/tessera/commands.hpp"
#include "apps/tessera/view/options.hpp"

namespace tessera::app {

namespace {

Result<void> run(ViewOptions& options) {
  auto server = transport::parseAddress(options.address);
  if (!server) return tl::unexpected(server.error());
  options.server = *server;
  if (!options.token.empty() && options.keys.empty())
    return fail("--token needs --keys: the folder of this side's certificate and pairings");
  const auto lens = lensOf(options.lensText);
  if (!lens) return tl::unexpected(lens.error());
  options.lens = *lens;
  if (options.headless) return viewHeadless(options);
#ifdef TESSERA_HAS_WINDOW
  return viewWindow(options);
#else
  return fail("built without GLFW and Dear ImGui: only --headless is there");
#endif
}

}  // namespace

Run addView(CLI::App& app) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App& command = *app.add_subcommand("view", "Watch what a server shades, from anywhere in it");
  command.add_option("server", options->address, "HOST:PORT of tessera serve")->required();
  command.add_option("--token", options->token, "the server's; needed for all but loopback addresses");
  command.add_option("--keys", options->keys, "folder of the certificate and of who was paired");
  addSize(command, options->size);
  addContext(command, options->context);
  command.add_flag("--headless", options->headless, "without a window");
  command.add_option("--path", options->path, "camera path: a JSON file, or the name of one of the server's");
  command.add_option("--eye", options->eye, "x,y,z of the first eye in metres; else where the server says")
      ->delimiter(',')
      ->expected(3);
  command.add_option("--target", options->target, "x,y,z looked at first")->delimiter(',')->expected(3);
  command.add_option("--fov-y", options->fovY, "vertical field of view in degrees")
      ->check(CLI::Range(1.0, 150.0));
  command.add_option("--frames", options->frames, "ends after so many with a picture")
      ->check(CLI::Range(1, 1000000000));
  command.add_option("--fps", options->fps, "frames a second without a window")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command.add_option("--patience", options->patience, "seconds to wait for a first picture without a window")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  command.add_option("--record", options->record, "folder for every picture shown, as PNG");
  command.add_option("--stats", options->stats, "JSON file for what was measured");
  command.add_option("--csv", options->csv, "CSV file for the overlay's figures, a row a frame");
  command.add_flag("!--no-overlay", options->overlay, "without the figures in the window, which F1 shows");
  command.add_flag("--stereo", options->stereo, "two eyes side by side");
  addLens(command, options->lensText);
  return [=](const std::string&) { return run(*options); };
}

}  // namespace tessera::app
