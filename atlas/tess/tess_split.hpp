// Splits the visible triangles that want more samples than a slot has into pieces, which are sampled and
// placed as triangles are. What the later stages work on is a list of both.
#pragma once

#include <cstdint>

#include "atlas/visible_set.hpp"
#include "engine/gl/program.hpp"
#include "glsl/shared/tess_split.h"

namespace tessera {

class TessSplit {
 public:
  TessSplit() = default;
  static Result<TessSplit> create(gl::ProgramCache& programs, std::uint32_t triangles, std::uint32_t batches);

  /// Makes the list of a frame's visible set; the views are in BIND_VIEWS. Bound must be the memory (states
  /// and atlas) and entryOfTriangle.
  void list(const VisibleSet& visible) const;
  /// Binds the list in place of the visible set's, and the pieces.
  void bind() const;
  /// As VisibleSet::dispatch, over the list.
  [[nodiscard]] const gl::Buffer& dispatch() const { return dispatch_; }
  /// Moves each batch's entries behind the pieces of the batches before it. Bound must be batches and
  /// commands, as they are without any.
  void makeRoom() const;
  [[nodiscard]] std::size_t bytes() const;
  /// Triangles that are split; blocking readback.
  [[nodiscard]] std::uint32_t readSplit() const;

 private:
  std::uint32_t batchCount_ = 0;
  gl::Buffer state_;     // TessSplitState, uint[batches]
  gl::Buffer pieces_;    // TessPieceGpu[kSplitNumbers]
  gl::Buffer elements_;  // uint count, uint[triangles + kSplitNumbers]
  gl::Buffer dispatch_;
  const gl::Program* begin_ = nullptr;
  const gl::Program* split_ = nullptr;
  const gl::Program* finish_ = nullptr;
  const gl::Program* ranges_ = nullptr;
};

}  // namespace tessera
