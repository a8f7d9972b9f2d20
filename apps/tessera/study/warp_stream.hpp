// A picture as it is streamed, and bent to the pose that is shown (Mueller 2021, sec. 7.2.2).
#pragma once

#include <memory>
#include <string>

#include "apps/tessera/study/coder.hpp"
#include "apps/tessera/study/shots.hpp"
#include "engine/frame/image_warp.hpp"
#include "engine/yuv/unpacker.hpp"

namespace tessera::app {

class WarpStream {
 public:
  /// Engine, context and path outlive this; `wanted` in the order in which pictures are numbered. Fails where
  /// a program does not compile.
  static Result<WarpStream> create(const gl::Context& context, Engine& engine, const StudyPath& path,
                                   const StudySettings& settings, std::vector<Warp> wanted);

  /// Of the warp of this number in `wanted`, and of the run of this number.
  using TakeWarp = std::function<Result<void>(std::size_t warp, std::size_t run, const Taken&)>;
  /// Streams of one server rate and the same bitrates, one for each latency. Pictures of the present pose are
  /// drawn and coded once for all of them.
  Result<std::vector<StreamFacts>> run(const std::vector<StreamRun>& runs, const TakeWarp& take);

 private:
  struct Target {
    Target(int width, int height);
    gl::Texture color, depth;
    gl::Framebuffer framebuffer;
  };
  WarpStream(const gl::Context& context, Engine& engine, const StudyPath& path, const StudySettings& settings,
             YuvUnpacker unpacker);
  [[nodiscard]] Result<View> sourceView(double time, double latency) const;
  /// Of `count` frames, all of one size.
  [[nodiscard]] Result<std::vector<View>> sourceViews(std::int64_t count, double serverHz,
                                                      double latency) const;
  Result<StreamFacts> stream(const std::vector<StreamRun>& runs, std::size_t first, std::size_t count,
                             const TakeWarp& take);
  Result<void> show(const WarpSource& source, std::int64_t frame, const StreamRun& run, std::size_t number,
                    std::size_t bitrate, const TakeWarp& take);

  const gl::Context* context_;
  Engine* engine_;
  const StudyPath* path_;
  const StudySettings* settings_;
  YuvUnpacker unpacker_;
  std::unique_ptr<gl::ProgramCache> programs_;
  std::vector<Warp> wanted_;
  ImageWarp warp_;
  Target target_;
};

}  // namespace tessera::app
