// Plays a fuzzer's corpus once: what it found stays found.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "engine/core/file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

std::vector<std::vector<std::uint8_t>> corpus() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(TESSERA_FUZZ_CORPUS))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::vector<std::uint8_t>> all;
  for (const auto& file : files) {
    auto bytes = tessera::readFile(file);
    EXPECT_TRUE(bytes) << file;
    if (bytes) all.push_back(std::move(*bytes));
  }
  return all;
}

TEST(Corpus, IsPlayedWhole) {
  const auto inputs = corpus();
  EXPECT_GT(inputs.size(), 2u);
  for (const auto& input : inputs) LLVMFuzzerTestOneInput(input.data(), input.size());
}

/// Each file cut off at many places, and with single bytes changed.
TEST(Corpus, CutAndChangedFilesFailInOneLine) {
  for (const auto& input : corpus()) {
    const std::size_t step = std::max<std::size_t>(input.size() / 40, 1);
    for (std::size_t end = 0; end < input.size(); end += step) LLVMFuzzerTestOneInput(input.data(), end);
    for (std::size_t at = 0; at < input.size(); at += step) {
      auto changed = input;
      changed[at] = static_cast<std::uint8_t>(changed[at] ^ (1U << (at % 8)));
      LLVMFuzzerTestOneInput(changed.data(), changed.size());
    }
  }
}

}  // namespace
