// The server's loop: for whoever watches, what will be seen is placed, shaded, coded as video and sent with
// its geometry. While nobody does, nothing is shaded.
#pragma once

#include <atomic>
#include <chrono>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "apps/tessera/serve/coding.hpp"
#include "apps/tessera/serve/viewers.hpp"
#include "engine/frame/engine.hpp"
#include "engine/stream/feed.hpp"
#include "engine/yuv/packer.hpp"

namespace tessera::app {

struct StreamingOptions {
  double framesPerSecond = 30.0;  // (0, 1000]
  int iFrames = 60;               // frames from one I-frame to the next; 0: only those that are asked for
  std::uint32_t frames = 0;       // ends after so many; 0: goes on
  PvsOptions pvs;
  /// The time that is predicted is each viewer's round trip and a frame's time, in place of pvs.latency.
  bool measureLatency = true;
  ShadeOptions shade;
  bool timeStages = false;  // each stage ends before the next, so that times are its own
  std::string csv;          // file for a row a coded frame; empty: none
};

class Streaming {
 public:
  /// The engine is of the rect or tess gatherer, updated once, with an atlas of the packer's size; engine and
  /// server outlive this. `greeting`: what a new viewer is told first.
  Streaming(const StreamingOptions& options, Engine& engine, transport::Server& server, YuvPacker packer,
            VideoEncoder encoder, std::vector<wire::Message> greeting);

  /// Until all frames are made or `stop` is set. What is coded then is still sent. Fails where the engine
  /// does.
  Result<void> run(const std::atomic<bool>& stop);
  /// Medians of milliseconds by stage over the last ten thousand frames and more, totals, and shares of a
  /// frame: `own_share` is all but shading and coding, `streaming_share` what is left of that without finding
  /// and placing the visible set.
  [[nodiscard]] nlohmann::json statistics() const;

 private:
  using Clock = std::chrono::steady_clock;
  /// Milliseconds of a part of each frame.
  struct Times {
    std::vector<double> visible, place, shade, convert, read, meta, encode, send;
  };
  static constexpr std::size_t kRemembered = 10'000;  // times of a part, at least
  static void keep(std::vector<double>& times, double milliseconds);

  /// Of the atlas's memory.
  struct Resets {
    std::uint32_t count = 0;  // since it was made
    bool pending = false;     // held back until an I-frame
  };

  template <class Part>
  void timed(std::vector<double>& times, const Part& part);
  std::vector<TimedView> predict(double time);
  [[nodiscard]] double latencyOf(const transport::ViewerStatus* status) const;
  bool beginFrame();
  Result<void> frame(double time);
  void noteReset();
  void tellFrame(const wire::FrameHeader& told, const std::vector<wire::VisibleElement>& elements,
                 const std::vector<wire::ObjectTransform>& objects);
  void sendCoded();
  void noteRow(std::size_t metaBytes);
  Result<void> writeRow(const EncodedFrame& coded);
  void report();

  StreamingOptions options_;
  Engine& engine_;
  transport::Server& server_;
  YuvPacker packer_;
  CodingThread coding_;
  GeometryFeed feed_;
  Viewers viewers_;
  std::vector<View> ends_;  // of each viewer's predicted views the first, then the last ones
  View shadedFrom_;         // the first viewer's last: the picture is shown then
  std::uint32_t frame_ = 0;
  int sinceIFrame_ = 0;
  bool wish_ = false;   // for an I-frame, not granted yet
  Resets resets_;       // of the atlas, after the last frame
  bool reset_ = false;  // in the last frame
  std::uint64_t resetFrames_ = 0;
  double watched_ = 0.0;  // seconds with somebody there
  std::size_t mostWatching_ = 0;
  std::uint64_t videoBytes_ = 0, metaBytes_ = 0, sentBytes_ = 0, iFrames_ = 0, uncoded_ = 0;
  Times times_;
  std::ofstream csv_;
  std::map<std::uint32_t, std::string> rows_;  // of frames that are being coded: what is known of them
  Clock::time_point reported_ = Clock::now();
  std::uint32_t reportedFrame_ = 0;
  std::uint64_t reportedVideo_ = 0, reportedMeta_ = 0;
};

}  // namespace tessera::app
