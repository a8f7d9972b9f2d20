// Who watches: what each viewer has said, and what it has been told.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "codec/transport/server.hpp"
#include "codec/wire/framing.hpp"
#include "codec/wire/message_order.hpp"
#include "codec/wire/visible_delta.hpp"
#include "engine/frame/predict.hpp"

namespace tessera::app {

struct Viewer {
  wire::MessageParser parser{wire::Role::Viewer};
  wire::MessageOrder order{wire::Role::Viewer};
  std::unique_ptr<wire::VisibleDelta> delta;  // from its hello on
  PoseTrack track;                            // in seconds of the viewer's own clock
  wire::Camera camera;                        // of the last pose
  std::uint32_t pose = 0;                     // number of the last pose
  double latency = 0.0;                       // seconds, that its views were predicted for
  bool videoOpen = false;
  std::chrono::steady_clock::time_point joined = std::chrono::steady_clock::now();
  std::uint32_t acknowledged = 0;  // atlas frame

  /// It has been greeted and has said where it is.
  [[nodiscard]] bool watches() const { return delta != nullptr && track.last().has_value(); }
};

class Viewers {
 public:
  /// How long a viewer may hold a place without a hello.
  static constexpr std::chrono::seconds kHelloWait{5};
  using Log = std::function<void(const std::string&)>;
  /// `greeting`: what follows the server's hello to a new viewer. `source` outlives this.
  Viewers(transport::Server& server, const wire::GeometrySource& source, std::vector<wire::Message> greeting,
          Log log)
      : server_(&server), source_(&source), greeting_(std::move(greeting)), log_(std::move(log)) {}

  /// Takes what happened since the last call. A viewer that says what it may not is dismissed.
  void poll();
  [[nodiscard]] std::map<transport::ViewerId, Viewer>& all() { return viewers_; }
  [[nodiscard]] std::size_t watching() const;
  /// Whether a viewer needs an I-frame; asks at most once for all.
  [[nodiscard]] bool takeIFrameWish() { return std::exchange(wantsIFrame_, false); }
  /// A viewer that cannot be told is dismissed, with a line in the log. Bytes sent.
  std::size_t tell(transport::ViewerId id, const wire::Message& message);
  void dismiss(transport::ViewerId id, const std::string& why);

 private:
  void dismissSilent();
  Result<void> take(transport::ViewerId id, Viewer& viewer, const wire::Message& message);
  Result<void> takeBytes(transport::ViewerId id, std::span<const std::uint8_t> bytes);

  transport::Server* server_;
  const wire::GeometrySource* source_;
  std::vector<wire::Message> greeting_;
  Log log_;
  std::map<transport::ViewerId, Viewer> viewers_;
  bool wantsIFrame_ = false;
};

}  // namespace tessera::app
