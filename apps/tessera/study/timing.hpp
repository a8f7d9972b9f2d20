// Which picture a viewer shows when: the model of latency and of upsampled frame rates. No GL.
#pragma once

#include <cstdint>

namespace tessera::app {

/// A server makes frame k of the pose at k / serverHz seconds; a viewer can show it `latency` seconds later.
struct StreamTiming {
  double serverHz = 30.0;  // frames a second, > 0
  double latency = 0.0;    // seconds, >= 0
};

/// The newest frame that is there at a time in seconds; below 0 where none is yet.
std::int64_t shownFrame(double time, const StreamTiming& timing);

/// How long after its pose a frame may still be on the screen: the latency and the time to the next frame
/// (Mueller 2021, sec. 7.2).
double longestUse(const StreamTiming& timing);
/// Predicted views for that, a step of 33.3 ms each at most (sec. 7.2).
int predictionSteps(const StreamTiming& timing);

/// Evenly spread display times.
struct Samples {
  double first = 0.0;  // seconds after the first server frame
  int stride = 1;      // displayed pictures from one sample to the next
  int count = 0;
  double displayHz = 120.0;
  [[nodiscard]] double at(int sample) const { return first + sample * stride / displayHz; }
  [[nodiscard]] double last() const { return at(count - 1); }
};

/// `count` samples over about `seconds`, none before `lead` seconds: from there on every method of every run
/// has a picture. The stride is odd, so that samples meet every phase of a server whose rate divides the
/// display's by a power of two.
Samples samplesOver(double seconds, int count, double displayHz, double lead);

}  // namespace tessera::app
