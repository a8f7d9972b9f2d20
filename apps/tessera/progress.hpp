// Progress of long work: a line that is rewritten on a terminal, plain lines otherwise. On stderr.
#pragma once

#include <string>

namespace tessera::app {

class Progress {
 public:
  /// `total` 0: steps without a count.
  explicit Progress(std::string what, std::size_t total = 0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// One more step done, or about to be done when there is no count.
  void step(const std::string& detail = {});

 private:
  std::string what_;
  std::size_t total_;
  std::size_t done_ = 0;
  std::size_t printedTenth_ = 0;
  bool terminal_;
};

}  // namespace tessera::app
