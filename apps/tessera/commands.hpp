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
/// `ending` becomes Exit::Failed where a case does not hold.
Run addStability(CLI::App& app, Exit& ending);
Run addAccuracy(CLI::App& app);
Run addPvs(CLI::App& app);
/// Only where video coding is built.
Run addVideoBench(CLI::App& app);
Run addServe(CLI::App& app);
Run addView(CLI::App& app);
Run addStreamStudy(CLI::App& app);

}  // namespace tessera::app
