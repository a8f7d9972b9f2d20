// `tessera serve` and `tessera view` as processes, with what the viewer writes.
#pragma once

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/image/image.hpp"
#include "tests/serve/program.hpp"

namespace tessera::test {

inline constexpr int kSeconds = 60;  // that anything may take on a busy machine

/// Options, and of the defaults (names and their values) those that they do not set.
inline std::vector<std::string> withDefaults(std::vector<std::string> options,
                                             const std::vector<std::string>& defaults) {
  for (std::size_t i = 0; i + 1 < defaults.size(); i += 2)
    if (std::find(options.begin(), options.end(), defaults[i]) == options.end())
      options.insert(options.end(), {defaults[i], defaults[i + 1]});
  return options;
}

/// `tessera serve`, once it listens.
struct Server {
  explicit Server(const std::string& listen = "127.0.0.1:0", const std::vector<std::string>& more = {})
      : program(arguments(listen, more)) {
    EXPECT_TRUE(program.waitFor("x264", kSeconds)) << program.said();
    address = program.after("listening on ");
  }
  static std::vector<std::string> arguments(const std::string& listen, const std::vector<std::string>& more) {
    // Few packets a frame: with 5 % loss most frames come whole.
    std::vector<std::string> all = {"serve", TESSERA_SOURCE_DIR "/assets/atrium.glb", "--listen", listen};
    const auto options = withDefaults(
        more, {"--context", "osmesa", "--fps", "8", "--atlas-mpix", "0.25", "--bitrate", "300k"});
    all.insert(all.end(), options.begin(), options.end());
    return all;
  }
  Program program;
  std::string address;
};

/// A row of --csv.
struct Row {
  double time = 0.0;
  std::uint32_t frame = 0;
  bool live = false;
};

/// `tessera view` without a window, and the files that it writes.
class Viewer {
 public:
  Viewer(const std::string& name, const std::string& address, const std::vector<std::string>& more = {})
      : Viewer(name) {
    std::vector<std::string> all = {"view", address, "--headless"};
    const auto options =
        withDefaults(more, {"--context", "osmesa", "--size", "160x90", "--fps", "12", "--frames", "1000000",
                            "--csv", file("csv"), "--stats", file("json"), "--record", file("shown")});
    all.insert(all.end(), options.begin(), options.end());
    program_ = std::make_unique<Program>(all);
  }
  /// In a window on an X display.
  static Viewer inWindow(const std::string& name, const std::string& address, const std::string& display,
                         const std::vector<std::string>& more) {
    Viewer viewer(name);
    std::vector<std::string> all = {"view", address};
    const auto options = withDefaults(more, {"--csv", viewer.file("csv"), "--stats", viewer.file("json")});
    all.insert(all.end(), options.begin(), options.end());
    viewer.program_ = std::make_unique<Program>(all, display);
    return viewer;
  }
  [[nodiscard]] std::string file(const std::string& what) const { return (folder_ / what).string(); }
  Program& program() { return *program_; }

  /// Whole rows so far.
  [[nodiscard]] std::vector<Row> rows() const {
    std::vector<Row> rows;
    std::ifstream csv(file("csv"));
    std::string line;
    std::getline(csv, line);
    while (std::getline(csv, line) && !csv.eof()) {
      std::istringstream values(line);
      Row row;
      double frameMs = 0.0;
      int live = 0;
      char comma = 0;
      values >> row.time >> comma >> frameMs >> comma >> row.frame >> comma >> live;
      row.live = live != 0;
      rows.push_back(row);
    }
    return rows;
  }
  /// Atlas frame that was shown last; 0 before the first.
  [[nodiscard]] std::uint32_t shown() const {
    const auto all = rows();
    return all.empty() ? 0 : all.back().frame;
  }
  /// Ends it, and takes what it measured.
  nlohmann::json end() {
    EXPECT_EQ(program_->end(SIGTERM), 0) << program_->said();
    return nlohmann::json::parse(std::ifstream(file("json")), nullptr, false);
  }
  /// The first picture of each atlas frame; after end().
  [[nodiscard]] std::map<std::uint32_t, Image> pictures() const {
    std::map<std::uint32_t, Image> all;
    int number = 0;
    for (const Row& row : rows()) {
      if (row.frame == 0) continue;
      ++number;
      if (all.contains(row.frame)) continue;
      auto picture = readImage(file("shown") + fmt::format("/{:04}.png", number));
      EXPECT_TRUE(picture) << picture.error().message;
      if (picture) all.emplace(row.frame, std::move(*picture));
    }
    return all;
  }

 private:
  explicit Viewer(const std::string& name)
      : folder_(std::filesystem::path(testing::TempDir()) / ("serve_process_" + name)) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  std::filesystem::path folder_;
  std::unique_ptr<Program> program_;
};

template <class Holds>
bool waitFor(const Holds& holds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(kSeconds);
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace tessera::test
