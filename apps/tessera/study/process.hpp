// This program once more, as a process of its own.
#pragma once

#include <string>
#include <sys/types.h>
#include <vector>

#include "engine/core/result.hpp"

namespace tessera::app {

/// Move only. Ends with its owner.
class OwnProcess {
 public:
  /// Runs this program with these arguments; what it prints, errors too, is kept.
  static Result<OwnProcess> start(const std::vector<std::string>& arguments);
  OwnProcess(OwnProcess&& other) noexcept;
  OwnProcess& operator=(OwnProcess&& other) noexcept;
  ~OwnProcess();

  /// Reads until this text was printed; false when the process ends, or so many seconds pass, without it.
  bool waitFor(const std::string& text, double seconds);
  /// Waits for its end: the exit status, or nothing where it has not ended by then.
  Result<int> wait(double seconds);
  void signal(int number) const;
  [[nodiscard]] const std::string& said() const { return said_; }
  /// The last line that it printed, for an error.
  [[nodiscard]] std::string lastLine() const;

 private:
  OwnProcess() = default;
  bool readSome(double seconds);
  void end();
  pid_t process_ = -1;
  int output_ = -1;
  std::string said_;
};

}  // namespace tessera::app
