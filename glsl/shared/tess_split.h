// Splitting of triangles that need more samples than a slot has: n x n pieces of the triangle's plane, each sampled and
// placed as a triangle of its own. Lattice point (row, column), 0 <= column <= row <= n, has the weights
// (n - row, row - column, column) / n; row r of the pieces lies between lattice rows r and r + 1 and has 2 r + 1 of them,
// upright ones at even places.
#ifndef TESSERA_GLSL_SHARED_TESS_SPLIT_H
#define TESSERA_GLSL_SHARED_TESS_SPLIT_H
#include "shared/dialect.h"
#include "shared/levels.h"
TESSERA_SHARED_BEGIN

SHARED_CONST uint kSplitMost = 16u;     // n at most
SHARED_CONST uint kSplitBlock = 256u;   // numbers of pieces that a split triangle owns: kSplitMost squared
SHARED_CONST uint kSplitBlocks = 256u;  // triangles that may be split at once
SHARED_CONST uint kSplitNumbers = 65536u;
SHARED_CONST uint kNoEntry = 0xffffffffu;

// A piece: which, of how many along an edge.
struct SplitPiece {
  uint index;  // [0, n * n)
  uint n;      // 2 to kSplitMost
};
SHARED_FN uint packPiece(uint n, uint index) { return n | (index << 8u); }
SHARED_FN SplitPiece pieceOf(uint code) {
  SplitPiece piece;
  piece.index = code >> 8u;
  piece.n = code & 255u;
  return piece;
}

// What the GPU knows of a piece by its number, counted from the first one's.
struct TessPieceGpu {
  uint triangle;
  uint piece;  // see packPiece
  uint frame;  // in which it was last listed
  uint unused0;
};

// Which triangles are split.
struct TessSplitState {
  int freeCount;
  uint owners[kSplitBlocks];  // triangle number, or kNoEntry
  uint freeBlocks[kSplitBlocks];
};

// Of TessState::split: n and the block, or 0.
SHARED_FN uint packSplit(uint n, uint block) { return n | (block << 8u); }
SHARED_FN uint splitCount(uint split) { return split & 255u; }
SHARED_FN uint splitBlock(uint split) { return split >> 8u; }

SHARED_FN uint pieceRow(uint index) {
  uint row = uint(sqrt(float(index)));
  // The root of a square may be rounded below it.
  return (row + 1u) * (row + 1u) <= index ? row + 1u : row;
}

SHARED_FN vec3 latticePoint(uint n, uint row, uint column) {
  return vec3(float(n - row), float(row - column), float(column)) / float(n);
}

// Barycentric coordinates, in the whole triangle, of a piece's corners: columns 0 to 2. In the triangle's orientation.
// Lattice points that pieces share are the same to the bit.
SHARED_FN mat3 pieceCorners(SplitPiece piece) {
  uint row = pieceRow(piece.index);
  uint place = piece.index - row * row;
  uint column = place / 2u;
  if ((place & 1u) == 0u)
    return mat3(latticePoint(piece.n, row, column), latticePoint(piece.n, row + 1u, column),
                latticePoint(piece.n, row + 1u, column + 1u));
  return mat3(latticePoint(piece.n, row, column), latticePoint(piece.n, row + 1u, column + 1u),
              latticePoint(piece.n, row, column + 1u));
}

// Where a point of the triangle lies: the piece, and barycentric coordinates in it. Any float gives a valid piece, and
// coordinates in [0, 1] that sum to 1.
struct PiecePoint {
  uint index;
  vec3 at;
};
SHARED_FN PiecePoint pieceAt(vec3 b, uint n) {
  float most = float(n);
  float down = min((kLevelOne - b.x) * most, most);
  if (!(down > kLevelZero)) down = kLevelZero;
  float right = min(b.z * most, down);
  if (!(right > kLevelZero)) right = kLevelZero;
  uint row = min(uint(down), n - 1u);
  uint column = min(uint(right), row);
  float f = min(down - float(row), kLevelOne);
  float g = min(right - float(column), kLevelOne);
  PiecePoint point;
  if (g <= f || column == row) {
    g = min(g, f);
    point.index = row * row + 2u * column;
    point.at = vec3(kLevelOne - f, f - g, g);
  } else {
    point.index = row * row + 2u * column + 1u;
    point.at = vec3(kLevelOne - g, f, g - f);
  }
  return point;
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(tessera::glsl::kSplitBlock == tessera::glsl::kSplitMost * tessera::glsl::kSplitMost);
static_assert(tessera::glsl::kSplitNumbers == tessera::glsl::kSplitBlock * tessera::glsl::kSplitBlocks);
static_assert(sizeof(tessera::glsl::TessPieceGpu) == 16);
#endif
#endif
