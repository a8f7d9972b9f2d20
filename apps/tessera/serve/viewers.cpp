#include "apps/tessera/serve/viewers.hpp"

#include "codec/wire/handshake.hpp"
#include "engine/stream/feed.hpp"

namespace tessera::app {

namespace {

template <class... Cases>
struct Match : Cases... {
  using Cases::operator()...;
};

}  // namespace

std::size_t Viewers::watching() const {
  std::size_t count = 0;
  for (const auto& [id, viewer] : viewers_) count += viewer.watches() ? 1 : 0;
  return count;
}

void Viewers::dismiss(transport::ViewerId id, const std::string& why) {
  log_(fmt::format("viewer {}: dismissed: {}", id, why));
  server_->dismiss(id, why);
  viewers_.erase(id);
}

std::size_t Viewers::tell(transport::ViewerId id, const wire::Message& message) {
  const auto bytes = wire::encode(message);
  const auto sent = bytes ? server_->send(id, *bytes) : Result<void>(tl::unexpected(bytes.error()));
  if (sent) return bytes->size();
  dismiss(id, fmt::format("{} not sent: {}", wire::nameOf(wire::kindOf(message)), sent.error().message));
  return 0;
}

Result<void> Viewers::take(transport::ViewerId id, Viewer& viewer, const wire::Message& message) {
  if (auto allowed = viewer.order.accept(message); !allowed) return allowed;
  if (const auto* hello = std::get_if<wire::Hello>(&message)) {
    // The transport has looked at the token.
    wire::Hello said = *hello;
    said.token.clear();
    const wire::Answer answer = wire::answer(said, wire::Role::Server, wire::kSpoken, "");
    if (!answer.version) {
      tell(id, answer.refusal);
      return fail("{}", answer.refusal.why);
    }
    viewer.delta = std::make_unique<wire::VisibleDelta>(*source_);
    if (tell(id, wire::Hello{wire::kSpoken, wire::Role::Server, ""}) == 0) return {};
    for (const wire::Message& one : greeting_)
      if (tell(id, one) == 0) return {};
    wantsIFrame_ = true;
  } else if (const auto* pose = std::get_if<wire::Pose>(&message)) {
    auto view = viewOf(pose->camera);
    if (!view) return fail("pose {}: {}", pose->number, view.error().message);
    if (!viewer.track.add({pose->time, *view})) return {};
    viewer.camera = pose->camera;
    viewer.pose = pose->number;
  } else if (const auto* seen = std::get_if<wire::Acknowledge>(&message)) {
    viewer.acknowledged = seen->atlasFrame;
  } else if (std::get_if<wire::AskIFrame>(&message) != nullptr) {
    wantsIFrame_ = true;
  }
  return {};
}

Result<void> Viewers::takeBytes(transport::ViewerId id, std::span<const std::uint8_t> bytes) {
  if (const auto found = viewers_.find(id); found != viewers_.end()) found->second.parser.feed(bytes);
  while (true) {
    // Looked up anew: a viewer that could not be answered is gone.
    const auto found = viewers_.find(id);
    if (found == viewers_.end()) return {};
    auto message = found->second.parser.next();
    if (!message) return tl::unexpected(message.error());
    if (!*message) return {};
    if (auto taken = take(id, found->second, **message); !taken) return taken;
  }
}

void Viewers::dismissSilent() {
  std::vector<transport::ViewerId> silent;
  const auto now = std::chrono::steady_clock::now();
  for (const auto& [id, viewer] : viewers_)
    if (viewer.delta == nullptr && now - viewer.joined > kHelloWait) silent.push_back(id);
  for (const transport::ViewerId id : silent)
    dismiss(id, fmt::format("no hello within {} s", kHelloWait.count()));
}

void Viewers::poll() {
  for (transport::ServerEvent& event : server_->poll())
    std::visit(Match{[&](const transport::ViewerJoined& joined) {
                       log_(fmt::format("viewer {}: joined from {}{}{}", joined.viewer, joined.address,
                                        joined.secure ? ", secure, certificate " : "", joined.fingerprint));
                       viewers_.emplace(joined.viewer, Viewer());
                     },
                     [&](const transport::ViewerVideoOpen& open) {
                       if (const auto found = viewers_.find(open.viewer); found != viewers_.end())
                         found->second.videoOpen = true;
                       wantsIFrame_ = true;
                     },
                     [&](const transport::ViewerMessage& message) {
                       if (auto taken = takeBytes(message.viewer, message.bytes); !taken)
                         dismiss(message.viewer, taken.error().message);
                     },
                     [&](const transport::ViewerLeft& left) {
                       log_(fmt::format("viewer {}: left: {}", left.viewer, left.reason));
                       viewers_.erase(left.viewer);
                     }},
               event);
  dismissSilent();
}

}  // namespace tessera::app
