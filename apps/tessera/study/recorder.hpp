// Scores a method's pictures against the truth, and films them.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "apps/tessera/report/study_report.hpp"
#include "apps/tessera/study/shots.hpp"
#include "codec/mp4_writer.hpp"

namespace tessera::app {

/// Forward's pictures of the poses that are shown.
class Truth {
 public:
  Truth(Engine& engine, const StudyPath& path) : engine_(&engine), path_(&path) {}
  /// At a display time; kept.
  const Image& at(double time);
  /// The same, not kept where at() has not drawn it.
  Image once(double time);

 private:
  Image draw(double time);
  Engine* engine_;
  const StudyPath* path_;
  std::map<double, Image> pictures_;
};

/// Pictures as an MP4 that a browser plays, coded so well that it adds nothing to see.
class Film {
 public:
  static Result<Film> create(glm::ivec2 size, double picturesPerSecond);
  Result<void> add(const Image& picture);
  Result<std::vector<std::uint8_t>> finish() { return writer_.finish(); }

 private:
  Film(VideoEncoder encoder, Mp4Writer writer) : encoder_(std::move(encoder)), writer_(std::move(writer)) {}
  VideoEncoder encoder_;
  Mp4Writer writer_;
  std::uint64_t frames_ = 0;
};

/// Of one method in one run.
class Recorder {
 public:
  /// `film`: whether shots that are to be filmed are, at the first bitrate.
  static Result<Recorder> create(Truth& truth, std::size_t bitrates, bool film,
                                 const StudySettings& settings);
  Result<void> add(const Taken& taken);
  /// The scores at one bitrate; what a run says of itself is the caller's to fill in.
  [[nodiscard]] StudyPoint point(std::size_t bitrate) const;
  /// Empty where nothing was filmed.
  Result<std::vector<std::uint8_t>> film();

 private:
  struct Scores {
    std::vector<double> mssim, psnr, uncovered, age;
  };
  explicit Recorder(Truth& truth) : truth_(&truth) {}
  Truth* truth_;
  std::vector<Scores> scores_;
  std::optional<Film> film_;
};

}  // namespace tessera::app
