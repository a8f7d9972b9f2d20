// What a viewer measures of its stream.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace tessera::view {

/// From a pose to what it made visible, in order.
enum class Stage : std::uint8_t {
  Server,   // a pose sent, to its frame's header: both ways, and the server's work
  Receive,  // from there until its video is whole
  Decode,   // to planes, with the wait for the decoder
  Apply,    // geometry applied and paired with the atlas
  Wait,     // until the display takes it
  Upload,   // to the GPU
  Display,  // until it is drawn
  Total     // a pose sent, to the picture; where the pose is known
};
inline constexpr std::size_t kStages = 8;
/// "server", "receive", ...
const char* nameOf(Stage stage);

/// Times by stage. Any thread.
class Latency {
 public:
  void add(Stage stage, double milliseconds);
  /// Of the last 4096; negative where there is none.
  [[nodiscard]] double median(Stage stage) const;

 private:
  struct Ring {
    std::vector<double> values;
    std::size_t next = 0;
  };
  mutable std::mutex mutex_;
  std::array<Ring, kStages> rings_;
};

/// Bytes over time. One thread.
class Rate {
 public:
  /// `total` counts up; `seconds` is any clock that rises.
  void add(std::uint64_t total, double seconds);
  [[nodiscard]] double mbitPerSecond() const { return last_; }  // over the last whole second

 private:
  double start_ = -1.0;
  std::uint64_t startTotal_ = 0;
  double last_ = 0.0;
};

/// Why the picture is black, or stands still.
enum class Condition : std::uint8_t {
  Live,
  Connecting,
  Refused,       // and no further try will be made
  ServerGone,    // and tried again
  StreamBroken,  // what it sent was no stream; tried again
  NoVideoYet,
  WaitingForIFrame,
  DecodeFailed,
  Stalled,  // connected, but no frame comes
};

struct Figures {
  Condition condition = Condition::Connecting;
  std::string why;                // one line for a user; empty while Live
  std::uint64_t atlasFrames = 0;  // decoded since the start
  std::uint64_t frames = 0;       // announced since the start
  std::uint64_t videoBytes = 0;
  std::uint64_t metaBytes = 0;  // of messages, without TCP and TLS
  double videoMbit = 0.0;       // over the last whole second
  double metaMbit = 0.0;
  std::uint64_t packets = 0;
  std::uint64_t lostPackets = 0;
  double roundTripMs = 0.0;
  std::uint64_t reconnects = 0;
  std::uint64_t askedIFrames = 0;
  double connectedSeconds = 0.0;  // that a server was there, in all
  [[nodiscard]] double lossPercent() const {
    const std::uint64_t sent = packets + lostPackets;
    return sent == 0 ? 0.0 : 100.0 * static_cast<double>(lostPackets) / static_cast<double>(sent);
  }
};

}  // namespace tessera::view
