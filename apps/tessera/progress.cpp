#include "apps/tessera/progress.hpp"

#include <cstdio>
#include <unistd.h>
#include <utility>

#include <fmt/core.h>

namespace tessera::app {

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (terminal_ && done_ > 0) fmt::print(stderr, "\r\033[K");
}

void Progress::step(const std::string& detail) {
  ++done_;
  if (total_ == 0) {
    if (terminal_)
      fmt::print(stderr, "\r\033[K{}: {}", what_, detail);
    else
      fmt::print(stderr, "{}: {}\n", what_, detail);
  } else if (terminal_) {
    constexpr std::size_t kWidth = 30;
    const std::size_t filled = done_ * kWidth / total_;
    fmt::print(stderr, "\r\033[K{} [{}{}] {}/{} {}", what_, std::string(filled, '#'),
               std::string(kWidth - filled, '.'), done_, total_, detail);
  } else if (const std::size_t tenth = done_ * 10 / total_; tenth != printedTenth_) {
    printedTenth_ = tenth;
    fmt::print(stderr, "{}: {}/{} {}\n", what_, done_, total_, detail);
  }
  std::fflush(stderr);
}

}  // namespace tessera::app
