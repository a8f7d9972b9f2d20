// The parts of a session that its threads share. For session*.cpp only.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>

#include "codec/decoder.hpp"
#include "codec/wire/framing.hpp"
#include "codec/wire/message_order.hpp"
#include "engine/view/frame_pairs.hpp"
#include "engine/view/session.hpp"
#include "engine/view/triple_buffer.hpp"
#include "engine/view/work_queue.hpp"

namespace tessera::view {

/// Connections count up from 1. What belongs to an earlier one than the present is dropped.
using Generation = std::uint32_t;

struct VideoWork {
  Generation generation = 0;
  std::vector<std::uint8_t> bytes;
  Clock::time_point came;
};
struct HeaderWork {
  wire::FrameHeader header;
  Clock::time_point came;
  Clock::time_point posed;
};
struct ApplyWork {
  Generation generation = 0;
  std::variant<wire::StreamSetup, HeaderWork, wire::Geometry, wire::MaskImage, Picture> what;
};

class Session::State {
 public:
  explicit State(SessionOptions sessionOptions);
  ~State();
  Result<void> connect();
  void run();

  // The network's thread: session_network.cpp.
  void network();
  void handle(transport::ClientEvent& event);
  void receive(const transport::Bytes& bytes);
  void receive(wire::Message& message);
  void giveUp(std::string reason, bool final);
  void countVideo();
  void sendWhatWaits();
  void offerWhenWhole();
  [[nodiscard]] Clock::time_point sentPose(std::uint32_t number) const;

  // The decoder's and the one that applies: session_work.cpp.
  void decode();
  void decodeOne(VideoDecoder& decoder, const VideoWork& work);
  void skip(const VideoWork& work, Clock::duration behind);
  /// Not more often than the options say; under the mutex.
  void askIFrame(std::uint32_t frame, Clock::time_point now);
  void apply();
  Result<void> applyOne(std::optional<FramePairs>& pairs, ApplyWork& work);
  /// The present connection's stream is of no use any more; from any thread.
  void breakStream(Generation generation, std::string reason);

  [[nodiscard]] double secondsOf(Clock::time_point time) const {
    return std::chrono::duration<double>(time - started).count();
  }

  SessionOptions options;
  const Clock::time_point started = Clock::now();
  TripleBuffer<ShadedFrame> frames;
  Latency latency;

  // Of the network's thread alone.
  struct SentPose {
    std::uint32_t number;
    Clock::time_point at;
  };
  std::unique_ptr<transport::Client> client;
  wire::MessageParser parser{wire::Role::Server};
  wire::MessageOrder order{wire::Role::Server};
  std::deque<SentPose> sentPoses;  // numbers rise
  Offer coming;                    // as far as it has come
  int pathsToCome = 0;
  std::uint32_t poseNumber = 0;
  Clock::time_point lastPose{};
  std::optional<Clock::time_point> retryAt;
  std::chrono::milliseconds backoff{100};
  transport::VideoStatistics earlierVideo;  // of connections before the present one
  Rate videoRate, metaRate;

  WorkQueue<VideoWork> videoWork{std::size_t{64} << 20};
  WorkQueue<ApplyWork> applyWork{std::size_t{256} << 20};

  // Shared, under the mutex.
  std::mutex mutex;
  Generation generation = 0;
  std::optional<wire::Camera> nextPose;
  std::vector<wire::Message> outbox;
  std::optional<std::pair<Generation, std::string>> broken;
  Figures figures;
  std::optional<Offer> offer;
  bool connected = false;
  bool final = false;
  std::string trouble;  // why there is no connection
  bool streamBroken = false;
  NoPicture noPicture = NoPicture::NoVideoYet;
  std::string noPictureDetail;
  Clock::time_point connectedAt{};
  Clock::time_point lastPicture{};  // decoded
  Clock::time_point lastShown{};    // whole, for the display
  Clock::time_point lastAsk{};

  std::atomic<bool> stopping = false;
  std::thread networkThread, decodeThread, applyThread;
};

}  // namespace tessera::view
