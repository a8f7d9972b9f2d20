#include "apps/tessera/study/recorder.hpp"

#include <algorithm>

#include "engine/measure/metrics.hpp"

namespace tessera::app {

const Image& Truth::at(double time) {
  if (const auto found = pictures_.find(time); found != pictures_.end()) return found->second;
  return pictures_.emplace(time, draw(time)).first->second;
}

Image Truth::once(double time) {
  const auto found = pictures_.find(time);
  return found != pictures_.end() ? found->second : draw(time);
}

Image Truth::draw(double time) {
  engine_->update(path_->sceneTime(time));
  engine_->forward(path_->at(time).view);
  return engine_->readColor();
}

Result<Film> Film::create(glm::ivec2 size, double picturesPerSecond) {
  EncoderOptions options;
  options.width = size.x;
  options.height = size.y;
  options.framesPerSecond = picturesPerSecond;
  options.rate = RateControl::ConstantQuality;
  options.quality = 18.0;
  options.iFrameInterval = 0;
  auto encoder = VideoEncoder::create(options);
  if (!encoder) return tl::unexpected(encoder.error());
  auto writer = Mp4Writer::create(size.x, size.y, picturesPerSecond);
  if (!writer) return tl::unexpected(writer.error());
  return Film(std::move(*encoder), std::move(*writer));
}

Result<void> Film::add(const Image& picture) {
  auto planes = toYuv(picture, Chroma::Yuv420);
  if (!planes) return tl::unexpected(planes.error());
  auto coded = encoder_.encode(planes->view(), ++frames_);
  if (!coded) return tl::unexpected(coded.error());
  return writer_.add(*coded);
}

Result<Recorder> Recorder::create(Truth& truth, std::size_t bitrates, bool film,
                                  const StudySettings& settings) {
  Recorder recorder(truth);
  recorder.scores_.resize(bitrates);
  if (!film) return recorder;
  auto made = Film::create(settings.size, settings.videoHz);
  if (!made) return tl::unexpected(made.error());
  recorder.film_.emplace(std::move(*made));
  return recorder;
}

Result<void> Recorder::add(const Taken& taken) {
  if (taken.shot.filmed && film_ && taken.bitrate == 0)
    if (auto filmed = film_->add(taken.picture); !filmed) return filmed;
  if (taken.shot.sample < 0) return {};
  const Image& truth = truth_->at(taken.shot.time);
  const auto similarity = mssim(truth, taken.picture);
  if (!similarity) return tl::unexpected(similarity.error());
  const auto noise = psnr(truth, taken.picture);
  if (!noise) return tl::unexpected(noise.error());
  Scores& scores = scores_[taken.bitrate];
  scores.mssim.push_back(similarity->mean);
  scores.psnr.push_back(*noise);
  scores.uncovered.push_back(taken.uncovered);
  scores.age.push_back(taken.ageMs);
  return {};
}

StudyPoint Recorder::point(std::size_t bitrate) const {
  const Scores& scores = scores_[bitrate];
  StudyPoint point;
  const Statistics mssims = summarize(scores.mssim);
  point.mssim = mssims.mean;
  point.mssimWorst = mssims.min;
  point.psnrDb = summarize(scores.psnr).mean;
  point.uncoveredPixels = summarize(scores.uncovered).mean;
  point.shadedBehindMs = summarize(scores.age).mean;
  return point;
}

Result<std::vector<std::uint8_t>> Recorder::film() {
  if (!film_) return std::vector<std::uint8_t>();
  return film_->finish();
}

}  // namespace tessera::app
