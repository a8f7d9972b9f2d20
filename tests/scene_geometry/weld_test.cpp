#include "engine/scene/weld.hpp"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Weld, FirstEqualByBitsButZero) {
  const std::vector<float> keys{1, 0, 2, 0, 1, -0.0f, 2, 1e-45f, 2, 0};
  EXPECT_EQ(firstEqual(keys, 2), (std::vector<std::uint32_t>{0, 1, 0, 3, 1}));
  EXPECT_TRUE(firstEqual({}, 3).empty());
}

}  // namespace
}  // namespace tessera
