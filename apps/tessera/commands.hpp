// The subcommands. Each adds itself to the command line and returns what runs it.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

#include "apps/tessera/options.hpp"

namespace tessera::app {

using Run = std::function<Result<void>()>;

Run addRender(CLI::App& app);
Run addInfo(CLI::App& app);
Run addCompare(CLI::App& app);
Run addAtlasBench(CLI::App& app);

}  // namespace tessera::app
