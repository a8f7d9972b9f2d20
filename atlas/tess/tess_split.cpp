#include "atlas/tess/tess_split.hpp"

#include <algorithm>
#include <iterator>

#include "glsl/shared/bindings.h"

namespace tessera {

namespace {
void storageBarrier() { gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT); }
}  // namespace

Result<TessSplit> TessSplit::create(gl::ProgramCache& programs, std::uint32_t triangles,
                                    std::uint32_t batches) {
  TessSplit split;
  split.batchCount_ = batches;
  auto compiled = programs.getAll({{&split.begin_, "pass/split_begin.comp"},
                                   {&split.split_, "pass/split.comp"},
                                   {&split.finish_, "pass/visible_finish.comp"},
                                   {&split.ranges_, "pass/split_ranges.comp"}});
  if (!compiled) return tl::unexpected(compiled.error());
  glsl::TessSplitState state{};
  std::fill(std::begin(state.owners), std::end(state.owners), glsl::kNoEntry);
  split.state_ = gl::Buffer(sizeof(state) + batches * sizeof(glsl::uint));
  split.state_.writeValue(state);
  split.pieces_ = gl::Buffer(glsl::kSplitNumbers * sizeof(glsl::TessPieceGpu));
  split.elements_ = gl::Buffer((std::size_t{triangles} + glsl::kSplitNumbers + 1) * sizeof(glsl::uint));
  split.dispatch_ = gl::Buffer(3 * sizeof(glsl::uint));
  return split;
}

void TessSplit::list(const VisibleSet& visible) const {
  visible.bind();
  state_.bindStorage(BIND_SPLIT_STATE);
  elements_.bindStorage(BIND_SPLIT_ELEMENTS);
  pieces_.bindStorage(BIND_SPLIT_PIECES);
  begin_->use();
  begin_->set(LOCATION_FRAME, visible.frame());
  begin_->set(LOCATION_COUNT, batchCount_);
  gl::api().DispatchCompute(1, 1, 1);
  storageBarrier();
  split_->use();
  split_->set(LOCATION_FRAME, visible.frame());
  gl::dispatchIndirect(visible.dispatch());
  storageBarrier();
  bind();
  dispatch_.bindStorage(BIND_DISPATCH);
  finish_->use();
  gl::api().DispatchCompute(1, 1, 1);
  gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

void TessSplit::bind() const {
  elements_.bindStorage(BIND_VISIBLE);
  pieces_.bindStorage(BIND_SPLIT_PIECES);
}

void TessSplit::makeRoom() const {
  state_.bindStorage(BIND_SPLIT_STATE);
  ranges_->use();
  ranges_->set(LOCATION_COUNT, batchCount_);
  gl::api().DispatchCompute(1, 1, 1);
  gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

std::size_t TessSplit::bytes() const {
  return state_.size() + pieces_.size() + elements_.size() + dispatch_.size();
}

std::uint32_t TessSplit::readSplit() const {
  gl::api().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  const auto state = state_.readAll<glsl::TessSplitState>(1)[0];
  return static_cast<std::uint32_t>(std::count_if(std::begin(state.owners), std::end(state.owners),
                                                  [](glsl::uint owner) { return owner != glsl::kNoEntry; }));
}

}  // namespace tessera
