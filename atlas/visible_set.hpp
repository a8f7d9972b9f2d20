// The exact visible set of one view, or the union over several: a compact list on the GPU.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/gl/program.hpp"

namespace tessera {

/// What the visible list has an entry for.
enum class VisibleElement : std::uint8_t { Patch, Triangle };

/// Visible elements of the current frame. begin(), add() once a view, finish(); nothing is read back.
class VisibleSet {
 public:
  /// Of patch instances, or of triangles: `capacity` of either (see triangleNumber in
  /// glsl/shared/tess_atlas.h). `pixels`: with how many pixels show each, which costs an atomic addition for
  /// each run of 16 or less of them.
  static Result<VisibleSet> create(gl::ProgramCache& programs, VisibleElement element, std::uint32_t capacity,
                                   bool pixels = false);

  /// Starts a new frame's list.
  void begin();
  /// Adds what an id buffer, or each layer of one, (R32UI, see idOfTriangle in glsl/shared/scene.h) shows.
  void add(const gl::Texture& ids);
  /// Writes the indirect-dispatch arguments.
  void finish();

  /// Binds list, marks and dispatch arguments for the passes that read them.
  void bind() const;
  /// The same for passes that mark, see glsl/lib/visible_mark.glsl.
  void bindMarking() const;
  /// uvec3 of groups of 64 over the list, for glDispatchComputeIndirect at offset 0.
  [[nodiscard]] const gl::Buffer& dispatch() const { return dispatch_; }
  [[nodiscard]] std::uint32_t frame() const { return frame_; }
  [[nodiscard]] std::uint32_t capacity() const { return capacity_; }
  [[nodiscard]] VisibleElement element() const { return element_; }
  /// Blocking readback of the list, in the order of compaction.
  [[nodiscard]] std::vector<std::uint32_t> read() const;
  /// Blocking readback, in the same order: of all views that were added, the pixels that show each. After
  /// finish(); empty where they are not counted.
  [[nodiscard]] std::vector<std::uint32_t> readPixels() const;
  /// Blocking readback: pixels of all views that were added that show no element.
  [[nodiscard]] std::uint32_t readEmptyPixels() const;

 private:
  gl::Buffer list_;   // uint count, uint ids[]
  gl::Buffer marks_;  // the frame each patch instance was last visible in; frames count from 1
  gl::Buffer dispatch_;
  gl::Buffer pixels_;  // of each element; empty where they are not counted
  gl::Buffer seen_;    // of each of the list
  const gl::Program* mark_ = nullptr;
  const gl::Program* markLayers_ = nullptr;
  const gl::Program* finish_ = nullptr;
  const gl::Program* inOrder_ = nullptr;
  VisibleElement element_ = VisibleElement::Patch;
  std::uint32_t capacity_ = 0;
  std::uint32_t frame_ = 0;
};

}  // namespace tessera
