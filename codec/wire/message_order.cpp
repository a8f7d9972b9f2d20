#include "codec/wire/message_order.hpp"

namespace tessera::wire {

Result<void> MessageOrder::accept(const Message& message) {
  const Kind kind = kindOf(message);
  if (refused_) return fail("{}: after a refusal", nameOf(kind));
  if (kind == Kind::Refusal) {
    refused_ = true;
    return {};
  }
  if (const Hello* hello = std::get_if<Hello>(&message)) {
    if (greeted_) return fail("hello: a second one");
    if (hello->role != peer_)
      return fail("hello: from a {}", hello->role == Role::Server ? "server" : "viewer");
    greeted_ = true;
    return {};
  }
  if (!greeted_) return fail("{}: before a hello", nameOf(kind));
  if (!sends(peer_, kind))
    return fail("{}: from a {}", nameOf(kind), peer_ == Role::Server ? "server" : "viewer");
  if (const StreamSetup* setup = std::get_if<StreamSetup>(&message)) {
    if (setUp_) return fail("setup: a second one");
    setUp_ = true;
    pathsToCome_ = setup->paths;
    return {};
  }
  if (peer_ == Role::Server && !setUp_) return fail("{}: before the setup", nameOf(kind));
  if (kind == Kind::Path) {
    if (pathsToCome_ == 0) return fail("path: more of them than the setup said");
    --pathsToCome_;
  } else if (const FrameHeader* frame = std::get_if<FrameHeader>(&message)) {
    if (pathsToCome_ > 0) return fail("frame {}: {} paths are still to come", frame->frame, pathsToCome_);
    if (!geometryDone_) return fail("frame {}: frame {} had no geometry", frame->frame, frame_);
    if (frame->frame <= frame_) return fail("frame {}: after frame {}", frame->frame, frame_);
    frame_ = frame->frame;
    geometryDone_ = false;
  } else if (const Geometry* geometry = std::get_if<Geometry>(&message)) {
    if (geometry->frame != frame_ || geometryDone_)
      return fail("geometry: of frame {}, after frame {}{}", geometry->frame, frame_,
                  geometryDone_ ? ", which has its own" : "");
    geometryDone_ = true;
  } else if (const Pose* pose = std::get_if<Pose>(&message)) {
    if (pose->number <= pose_) return fail("pose {}: after pose {}", pose->number, pose_);
    pose_ = pose->number;
  }
  return {};
}

}  // namespace tessera::wire
