// Runs the program as a user does, each test in a folder of its own.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <sys/wait.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tessera::test {

struct Ran {
  int code = -1;
  std::string out;
  std::string error;
};

inline std::string slurp(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

class Cli : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(TESSERA_BINARY_DIR) / "cli" /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  Ran run(const std::string& arguments) const {
    const std::string command =
        fmt::format("cd '{}' && '{}' {} > out.txt 2> err.txt", folder_.string(), TESSERA_PROGRAM, arguments);
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(folder_ / "out.txt"),
            slurp(folder_ / "err.txt")};
  }
  void expectRefused(const std::string& arguments, const std::string& named) const {
    const Ran ran = run(arguments);
    EXPECT_EQ(ran.code, 2) << arguments << "\n" << ran.error;
    EXPECT_NE(ran.error.find(named), std::string::npos) << arguments << "\n" << ran.error;
  }
  std::string atrium() const { return std::string(TESSERA_SOURCE_DIR) + "/assets/atrium.glb"; }
  std::filesystem::path folder_;
};

}  // namespace tessera::test
