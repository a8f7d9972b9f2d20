#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "glsl/shared/tess_split.h"

namespace tessera {
namespace {

using glm::dvec3;
using glm::vec3;
using glsl::uint;

dvec3 cornerOf(const glm::mat3& corners, int i) { return dvec3(corners[i]); }
/// Twice the area, in units of the whole triangle's; positive in its orientation.
double shareOf(const glm::mat3& corners) { return glm::determinant(glm::dmat3(corners)); }

TEST(Split, PiecesAreCongruentAndCoverTheTriangleOnce) {
  for (uint n = 2; n <= glsl::kSplitMost; ++n) {
    std::set<std::array<std::array<float, 3>, 3>> seen;
    double whole = 0.0;
    for (uint index = 0; index < n * n; ++index) {
      const glm::mat3 corners = glsl::pieceCorners({index, n});
      EXPECT_NEAR(shareOf(corners) * n * n, 1.0, 1e-5) << "piece " << index << " of " << n;
      whole += shareOf(corners);
      std::array<std::array<float, 3>, 3> key{};
      for (int i = 0; i < 3; ++i) {
        key[i] = {corners[i].x, corners[i].y, corners[i].z};
        EXPECT_NEAR(corners[i].x + corners[i].y + corners[i].z, 1.0f, 1e-6f);
        EXPECT_GE(std::min({corners[i].x, corners[i].y, corners[i].z}), 0.0f);
      }
      seen.insert(key);
    }
    EXPECT_EQ(seen.size(), n * n);
    EXPECT_NEAR(whole, 1.0, 1e-5);
  }
}

TEST(Split, APointIsFoundInThePieceThatHoldsIt) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.02, 0.96);
  for (uint n = 1; n <= glsl::kSplitMost; ++n)
    for (uint index = 0; index < n * n; ++index) {
      const glm::mat3 corners = glsl::pieceCorners({index, n});
      for (int i = 0; i < 20; ++i) {
        const double s = unit(random);
        const double t = (1.0 - s) * unit(random);
        const dvec3 at(1.0 - s - t, s, t);
        const dvec3 b =
            at.x * cornerOf(corners, 0) + at.y * cornerOf(corners, 1) + at.z * cornerOf(corners, 2);
        const glsl::PiecePoint found = glsl::pieceAt(vec3(b), n);
        ASSERT_EQ(found.index, index) << "of " << n;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(static_cast<double>(found.at[c]), at[c], 1e-5);
      }
    }
}

TEST(Split, AnyFloatIsInAPiece) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float huge = std::numeric_limits<float>::infinity();
  const std::array<float, 12> values = {0.0f,  1.0f, -0.0f, -1e-7f, 1.0000001f, 0.5f,
                                        -3.0f, 7.0f, 1e30f, nan,    huge,       -huge};
  for (const uint n : {1u, 2u, 3u, 8u, 16u})
    for (const float x : values)
      for (const float y : values)
        for (const float z : values) {
          const glsl::PiecePoint found = glsl::pieceAt(vec3(x, y, z), n);
          ASSERT_LT(found.index, n * n);
          for (int c = 0; c < 3; ++c) {
            ASSERT_GE(found.at[c], 0.0f);
            ASSERT_LE(found.at[c], 1.0f);
          }
          ASSERT_NEAR(found.at.x + found.at.y + found.at.z, 1.0f, 1e-6f);
        }
}

TEST(Split, PackedPiecesComeBack) {
  for (uint n = 2; n <= glsl::kSplitMost; ++n)
    for (const uint index : {0u, 1u, n * n - 1u}) {
      const glsl::SplitPiece piece = glsl::pieceOf(glsl::packPiece(n, index));
      EXPECT_EQ(piece.n, n);
      EXPECT_EQ(piece.index, index);
    }
  for (uint index = 0; index < 70000; ++index) {
    const uint row = glsl::pieceRow(index);
    ASSERT_TRUE(row * row <= index && index < (row + 1) * (row + 1)) << index;
  }
}

}  // namespace
}  // namespace tessera
