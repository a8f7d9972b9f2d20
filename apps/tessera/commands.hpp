// The subcommands. Each adds itself to the command line and returns what runs it.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

#include "apps/tessera/options.hpp"

namespace tessera::app {

/// Runs with what was parsed; `line` is the whole command line, for the record.
using Run = std::function<Result<void>(const std::string& line)>;

Run addRender(CLI::App& app);
Run addInfo(CLI::App& app);
Run addCompare(CLI::App& app);
Run addAtlasBench(CLI::App& app);
Run addAccuracy(CLI::App& app);

}  // namespace tessera::app
