// The program as a process of its own, with what it prints.
#pragma once

#include <csignal>
#include <cstdlib>
#include <poll.h>
#include <string>
#include <sys/prctl.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace tessera::test {

class Program {
 public:
  /// Starts TESSERA_PROGRAM with these arguments; output and errors come together.
  explicit Program(std::vector<std::string> arguments, const std::string& display = "")
      : Program(TESSERA_PROGRAM, std::move(arguments), display) {}
  /// Another program, by its name on the path; `display`: an X display that it may open windows on.
  Program(std::string program, std::vector<std::string> arguments, const std::string& display) {
    int ends[2] = {-1, -1};
    if (pipe(ends) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      // A test that is cut off leaves no server behind.
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      dup2(ends[1], 1);
      dup2(ends[1], 2);
      close(ends[0]);
      close(ends[1]);
      std::vector<char*> list;
      list.push_back(program.data());
      for (std::string& argument : arguments) list.push_back(argument.data());
      list.push_back(nullptr);
      if (!display.empty()) setenv("DISPLAY", display.c_str(), 1);
      execvp(list[0], list.data());
      _exit(127);
    }
    close(ends[1]);
    output_ = ends[0];
  }
  ~Program() {
    end(SIGKILL);
    if (output_ >= 0) close(output_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Reads until the output has this text; false after so many seconds, or when the process has ended without
  /// it.
  bool waitFor(const std::string& text, int seconds) {
    for (int tenths = 0; tenths < 10 * seconds; ++tenths) {
      if (said_.find(text) != std::string::npos) return true;
      pollfd one{output_, POLLIN, 0};
      if (::poll(&one, 1, 100) <= 0) continue;
      if (!readSome()) return said_.find(text) != std::string::npos;
    }
    return false;
  }
  /// Reads what is there, so that the process never waits to be heard.
  void drain() {
    pollfd one{output_, POLLIN, 0};
    while (::poll(&one, 1, 0) > 0)
      if (!readSome()) return;
  }
  /// Whether it still runs.
  [[nodiscard]] bool runs() {
    siginfo_t info{};
    return process_ > 0 &&
           waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == 0;
  }
  [[nodiscard]] pid_t process() const { return process_; }
  /// All that was read so far.
  [[nodiscard]] const std::string& said() const { return said_; }
  /// The rest of the line behind `text`, which was waited for.
  [[nodiscard]] std::string after(const std::string& text) const {
    const std::size_t at = said_.find(text) + text.size();
    return said_.substr(at, said_.find_first_of(", \n", at) - at);
  }
  /// Sends a signal and waits for the end; the exit status, or -1 where a signal ended it.
  int end(int signal) {
    if (process_ <= 0) return status_;
    kill(process_, signal);
    int raw = 0;
    waitpid(process_, &raw, 0);
    process_ = 0;
    return status_ = WIFEXITED(raw) ? WEXITSTATUS(raw) : -1;
  }

 private:
  bool readSome() {
    char buffer[4096];
    const ssize_t got = read(output_, buffer, sizeof(buffer));
    if (got > 0) said_.append(buffer, static_cast<std::size_t>(got));
    return got > 0;
  }
  pid_t process_ = -1;
  int output_ = -1;
  int status_ = -1;
  std::string said_;
};

}  // namespace tessera::test
