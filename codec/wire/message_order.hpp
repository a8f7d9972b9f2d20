// Which messages may come when. A side has one of these for what it hears.
#pragma once

#include "codec/wire/message.hpp"

namespace tessera::wire {

class MessageOrder {
 public:
  /// Of what a peer of this role says.
  explicit MessageOrder(Role peer) : peer_(peer) {}
  /// Fails for a message that this peer may not send now: anything before its hello, a second hello, a
  /// server's frames before its set-up and all paths that it announced, more paths than those, the other
  /// role's messages, frame and pose numbers that do not rise, geometry of another frame than that of the
  /// last frame message, anything after a refusal.
  Result<void> accept(const Message& message);

 private:
  Role peer_;
  bool greeted_ = false;
  bool refused_ = false;
  bool setUp_ = false;
  std::uint16_t pathsToCome_ = 0;
  bool geometryDone_ = true;  // of `frame_`
  std::uint32_t frame_ = 0;
  std::uint32_t pose_ = 0;
};

}  // namespace tessera::wire
