#include "apps/tessera/study/process.hpp"

#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace tessera::app {

namespace {

using Clock = std::chrono::steady_clock;

double secondsUntil(Clock::time_point due) {
  return std::chrono::duration<double>(due - Clock::now()).count();
}

Clock::time_point dueIn(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

Result<OwnProcess> OwnProcess::start(const std::vector<std::string>& arguments) {
  int ends[2] = {-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0) return fail("no pipe: {}", std::strerror(errno));
  std::vector<std::string> words{"tessera"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> list;
  for (std::string& word : words) list.push_back(word.data());
  list.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  OwnProcess process;
  const int error = posix_spawn(&process.process_, "/proc/self/exe", &actions, nullptr, list.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  process.output_ = ends[0];
  if (error != 0) {
    process.process_ = -1;
    return fail("{}: not started: {}", arguments.front(), std::strerror(error));
  }
  return process;
}

OwnProcess::OwnProcess(OwnProcess&& other) noexcept { *this = std::move(other); }

OwnProcess& OwnProcess::operator=(OwnProcess&& other) noexcept {
  if (this == &other) return *this;
  end();
  process_ = std::exchange(other.process_, -1);
  output_ = std::exchange(other.output_, -1);
  said_ = std::move(other.said_);
  return *this;
}

OwnProcess::~OwnProcess() { end(); }

void OwnProcess::end() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  if (output_ >= 0) close(output_);
  process_ = output_ = -1;
}

/// False where the output has ended.
bool OwnProcess::readSome(double seconds) {
  pollfd one{output_, POLLIN, 0};
  if (poll(&one, 1, static_cast<int>(1e3 * seconds)) <= 0) return true;
  char buffer[4096];
  const ssize_t got = read(output_, buffer, sizeof(buffer));
  if (got > 0) said_.append(buffer, static_cast<std::size_t>(got));
  return got > 0;
}

bool OwnProcess::waitFor(const std::string& text, double seconds) {
  const auto due = dueIn(seconds);
  while (said_.find(text) == std::string::npos)
    if (secondsUntil(due) <= 0.0 || !readSome(0.1)) return said_.find(text) != std::string::npos;
  return true;
}

Result<int> OwnProcess::wait(double seconds) {
  const auto due = dueIn(seconds);
  // A full pipe would hold it.
  while (secondsUntil(due) > 0.0 && readSome(0.1)) {
  }
  while (process_ > 0) {
    int raw = 0;
    if (waitpid(process_, &raw, WNOHANG) == process_) {
      process_ = -1;
      if (WIFEXITED(raw)) return WEXITSTATUS(raw);
      return fail("ended by signal {}", WTERMSIG(raw));
    }
    if (secondsUntil(due) <= 0.0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return fail("not ended after {:g} s", seconds);
}

void OwnProcess::signal(int number) const {
  if (process_ > 0) kill(process_, number);
}

std::string OwnProcess::lastLine() const {
  std::string text = said_;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const std::size_t at = text.rfind('\n');
  return oneLine(at == std::string::npos ? text : text.substr(at + 1));
}

}  // namespace tessera::app
