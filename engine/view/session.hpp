// A viewer's end of a stream: connected, kept connected, decoded and put together on threads of its own. The
// display takes the newest whole frame when it likes, and never waits for any of it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "codec/transport/client.hpp"
#include "engine/core/result.hpp"
#include "engine/view/figures.hpp"
#include "engine/view/shaded_frame.hpp"

namespace tessera::view {

struct SessionOptions {
  transport::ClientOptions client;                 // `log` too
  double posesPerSecond = 120.0;                   // at most, (0, 1000]
  std::chrono::milliseconds askAgain{250};         // between two requests for an I-frame
  std::chrono::milliseconds stalled{1000};         // without a frame: the condition says so
  std::chrono::milliseconds longestBacklog{500};   // a coded frame that waited longer is not decoded
  std::chrono::milliseconds longestBackoff{5000};  // after streams that were broken
};

/// Cameras that a server's stage brings.
struct Offer {
  wire::Camera start;
  std::vector<wire::Path> paths;
};

class Session {
 public:
  /// Fails as transport::Client::start does.
  static Result<std::unique_ptr<Session>> start(SessionOptions options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Where the viewer looks from now. The newest goes to the server; any rate.
  void pose(const wire::Camera& camera);
  /// The newest whole frame becomes frame(). False where there is none newer than the last.
  bool take();
  /// What take() took; of method Rect and empty before the first. The display's own until the next take().
  [[nodiscard]] const ShadedFrame& frame() const;

  /// Of the newest connection that has said it; nothing before the first.
  [[nodiscard]] std::optional<Offer> offer() const;
  [[nodiscard]] Figures figures() const;
  [[nodiscard]] Latency& latency();

 private:
  class State;
  explicit Session(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tessera::view
