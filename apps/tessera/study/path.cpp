#include "apps/tessera/study/path.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::app {

Result<StudyPath> StudyPath::of(std::vector<TimedView> recorded, const StudySettings& settings) {
  const double latency =
      1e-3 * std::max(*std::max_element(settings.latenciesMs.begin(), settings.latenciesMs.end()),
                      settings.videos ? settings.videoLatencyMs : 0.0);
  const double slowest = std::min(
      settings.serverHz, *std::min_element(settings.serverRates.begin(), settings.serverRates.end()));
  StudyPath path;
  // Whatever the latency and the rate: the same poses are shown, and there is a picture by the first.
  const double lead = std::max(latency + 1.0 / settings.serverHz, 1.0 / slowest);
  path.samples_ = samplesOver(settings.seconds, settings.samples, settings.displayHz, lead);
  const double first = recorded.front().time;
  const double length = recorded.back().time - first;
  const double needed = path.samples_.last();
  if (length < needed)
    return fail("a path of {:.2f} s is shorter than the samples' {:.2f} s, {:.2f} s before them included",
                length, needed, path.samples_.first);
  const double begins = settings.start >= 0.0
                            ? settings.start
                            : std::floor(0.5 * (length - needed) * settings.displayHz) / settings.displayHz;
  if (begins > length - needed)
    return fail("--start {}: from there the path has {:.2f} s left of the samples' {:.2f} s", settings.start,
                std::max(length - begins, 0.0), needed);
  path.start_ = first + begins;
  path.moving_ = settings.moving;
  path.recorded_ = std::move(recorded);
  return path;
}

TimedView StudyPath::at(double time) const {
  return {sceneTime(time), sampleRecorded(recorded_, start_ + time)};
}

double StudyPath::metresPerSecond() const {
  double metres = 0.0;
  for (int i = 1; i < samples_.count; ++i)
    metres += glm::length(at(samples_.at(i)).view.eye - at(samples_.at(i - 1)).view.eye);
  return samples_.count > 1 ? metres / (samples_.last() - samples_.first) : 0.0;
}

double StudyPath::degreesPerSecond() const {
  double radians = 0.0;
  for (int i = 1; i < samples_.count; ++i) {
    const View a = at(samples_.at(i - 1)).view;
    const View b = at(samples_.at(i)).view;
    radians += std::atan2(glm::length(glm::cross(a.forward, b.forward)), glm::dot(a.forward, b.forward));
  }
  return samples_.count > 1 ? glm::degrees(radians) / (samples_.last() - samples_.first) : 0.0;
}

}  // namespace tessera::app
