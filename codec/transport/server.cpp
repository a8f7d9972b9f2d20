#include "codec/transport/server.hpp"

#include <algorithm>
#include <array>
#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <asio/post.hpp>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "codec/transport/channel.hpp"
#include "codec/transport/crypto.hpp"
#include "codec/transport/handshake.hpp"
#include "codec/transport/pins.hpp"
#include "codec/transport/video_hello.hpp"

namespace tessera::transport {

namespace {

using asio::ip::tcp;
using asio::ip::udp;

/// Connections under way that are no viewers yet.
constexpr std::size_t kMostHandshakes = 32;
constexpr int kMostPortTries = 16;

struct Viewer {
  ViewerId id = 0;
  std::shared_ptr<Channel> channel;
  std::optional<ServerHandshake> handshake;
  std::optional<Binding> binding;  // on a secure channel
  Ready ready;
  bool joined = false;
  std::optional<ViewerVideo> video;
  udp::endpoint path;  // where its last true video hello came from
  std::unique_ptr<asio::steady_timer> pace;
  bool videoOpen = false;  // was told to the host
};

asio::ip::address plainAddress(const asio::ip::address& address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped())
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  return address;
}

}  // namespace

class Server::State {
 public:
  explicit State(ServerOptions given)
      : options(std::move(given)), work(asio::make_work_guard(io)), acceptor(io), socket(io), lingering(io) {}

  Result<void> prepare();
  Result<void> listen();
  void run();
  void stop();

  std::vector<ServerEvent> poll();
  Result<std::shared_ptr<Channel>> channelOf(ViewerId id) const;
  void pushVideo(ViewerId id, std::uint32_t frame, const Bytes& accessUnit);
  void dismiss(ViewerId id, const std::string& why);
  std::vector<ViewerStatus> status() const;

  ServerOptions options;
  std::string shownFingerprint;
  Address address;
  asio::io_context io;

 private:
  Result<void> bind(const asio::ip::address& ip);
  void accept();
  void admit(tcp::socket peer);
  void opened(Viewer& viewer);
  void received(Viewer& viewer, Record record);
  void shakeHands(Viewer& viewer, const Record& record);
  Result<void> pin(const Viewer& viewer);
  void left(ViewerId id, const std::string& reason);
  void receiveHellos();
  void heardHello(std::span<const std::uint8_t> datagram, const udp::endpoint& from);
  void pace(Viewer& viewer);
  void log(const std::string& line) const {
    if (options.log) options.log(line);
  }
  void report(ServerEvent event, std::size_t bytes = 0);

  asio::executor_work_guard<asio::io_context::executor_type> work;
  tcp::acceptor acceptor;
  udp::socket socket;
  asio::steady_timer lingering;
  std::thread thread;
  std::optional<PairingKey> key;
  Identity identity;
  std::optional<Pins> pins;
  std::unique_ptr<asio::ssl::context> tls;
  std::map<ViewerId, Viewer> viewers;
  ViewerId lastId = 0;
  bool stopping = false;

  mutable std::mutex mutex;  // of what follows
  std::vector<ServerEvent> events;
  std::size_t inbox = 0;  // bytes in them
  std::map<ViewerId, std::pair<std::shared_ptr<Channel>, SendStatistics>> joined;
};

Result<void> Server::State::prepare() {
  const auto interval = std::chrono::duration<double>(options.frameInterval).count();
  if (interval <= 0.0 || interval > 10.0)
    return fail("frame interval {} s: expected above 0, at most 10", interval);
  if (options.packetBytes < 256 || options.packetBytes > 65000)
    return fail("video packets of {} bytes: expected 256 to 65000", options.packetBytes);
  if (options.token.empty()) return {};
  auto made = PairingKey::make(options.token);
  if (!made) return tl::unexpected(made.error());
  key = *made;
  if (options.folder.empty()) return fail("a pairing token needs a folder for the certificate");
  auto own = loadOrMakeIdentity(options.folder);
  if (!own) return tl::unexpected(own.error());
  identity = std::move(*own);
  shownFingerprint = showFingerprint(identity.fingerprint);
  auto known = Pins::load(options.folder / "paired");
  if (!known) return tl::unexpected(known.error());
  pins = std::move(*known);
  auto context = makeTlsContext(identity);
  if (!context) return tl::unexpected(context.error());
  tls = std::move(*context);
  return {};
}

Result<void> Server::State::listen() {
  asio::error_code error;
  tcp::resolver resolver(io);
  const auto found = resolver.resolve(options.listen.host, std::to_string(options.listen.port),
                                      tcp::resolver::passive | tcp::resolver::numeric_service, error);
  if (error || found.empty()) return fail("{}: {}", describe(options.listen), error.message());
  const asio::ip::address ip = found.begin()->endpoint().address();
  if (options.token.empty() && !plainAllowed(ip.to_string(), options.treatAsRemote))
    return fail("{}: not of this machine alone: listening there needs a pairing token",
                describe(options.listen));
  if (const auto bound = bind(ip); !bound) return bound;
  address = {options.listen.host, acceptor.local_endpoint().port()};
  return {};
}

Result<void> Server::State::bind(const asio::ip::address& ip) {
  asio::error_code error;
  // TCP and UDP share one port number, so that one number is all a user forwards or types.
  const int tries = options.listen.port == 0 ? kMostPortTries : 1;
  for (int i = 0; i < tries; ++i) {
    const tcp::endpoint endpoint(ip, options.listen.port);
    acceptor.close(error);
    socket.close(error);
    acceptor.open(endpoint.protocol(), error);
    acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error) continue;
    const udp::endpoint same(ip, acceptor.local_endpoint(error).port());
    socket.open(same.protocol(), error);
    asio::error_code ignored;
    socket.set_option(asio::socket_base::send_buffer_size(1 << 20), ignored);
    socket.bind(same, error);
    if (!error) socket.non_blocking(true, error);
    if (!error) return {};
  }
  return fail("{}: {}", describe(options.listen), error.message());
}

void Server::State::run() {
  accept();
  receiveHellos();
  thread = std::thread([this] { io.run(); });
}

void Server::State::stop() {
  asio::post(io, [this] {
    stopping = true;
    asio::error_code ignored;
    acceptor.close(ignored);
    socket.close(ignored);
    std::vector<std::shared_ptr<Channel>> channels;
    for (auto& [id, viewer] : viewers) channels.push_back(viewer.channel);
    for (const auto& channel : channels)
      channel->closeAfter(encode(Refusal{RefusalReason::Closing, options.versions, "the server stops"}),
                          "the server stops");
    if (viewers.empty()) return io.stop();
    lingering.expires_after(std::chrono::milliseconds(300));
    lingering.async_wait([this](asio::error_code) { io.stop(); });
  });
  if (thread.joinable()) thread.join();
}

void Server::State::accept() {
  acceptor.async_accept([this](asio::error_code error, tcp::socket peer) {
    if (stopping) return;
    if (!error) {
      admit(std::move(peer));
    } else {
      // Out of descriptors, say: the next try waits for a while instead of spinning.
      log(fmt::format("a connection could not be taken: {}", error.message()));
      lingering.expires_after(std::chrono::milliseconds(100));
      lingering.async_wait([this](asio::error_code stopped) {
        if (!stopped && !stopping) accept();
      });
      return;
    }
    accept();
  });
}

void Server::State::admit(tcp::socket peer) {
  const auto waiting = std::ranges::count_if(viewers, [](const auto& entry) { return !entry.second.joined; });
  if (static_cast<std::size_t>(waiting) >= kMostHandshakes) {
    log("a connection was closed: too many are in their handshake");
    return;
  }
  const ViewerId id = ++lastId;
  Viewer& viewer = viewers[id];
  viewer.id = id;
  viewer.channel = std::make_shared<Channel>(std::move(peer), options.limits);
  viewer.channel->open(tls.get(), Side::Server,
                       {[this, id] {
                          if (const auto found = viewers.find(id); found != viewers.end())
                            opened(found->second);
                        },
                        [this, id](Record record) {
                          if (const auto found = viewers.find(id); found != viewers.end())
                            received(found->second, std::move(record));
                        },
                        [this, id](const std::string& reason) { left(id, reason); }});
}

void Server::State::opened(Viewer& viewer) {
  Ready& ready = viewer.ready;
  fillRandom({reinterpret_cast<std::uint8_t*>(&ready.session), sizeof(ready.session)});
  fillRandom(ready.helloKey);
  while (ready.source == 0)
    fillRandom({reinterpret_cast<std::uint8_t*>(&ready.source), sizeof(ready.source)});
  std::optional<SecureTerms> terms;
  if (SSL* connection = viewer.channel->tls()) {
    const auto binding = bindingOf(connection, Side::Server, identity.fingerprint);
    if (!binding) return viewer.channel->close(binding.error().message);
    viewer.binding = *binding;
    if (!options.pairNew && !pins->knowsViewer(binding->viewerCertificate)) {
      const std::string why = fmt::format("the viewer's certificate {} is not paired with this server",
                                          showFingerprint(binding->viewerCertificate));
      return viewer.channel->closeAfter(encode(Refusal{RefusalReason::Certificate, options.versions, why}),
                                        why);
    }
    ready.srtpKey = makeSrtpKey();
    terms = SecureTerms{*key, *binding};
  }
  viewer.handshake.emplace(options.versions, std::move(terms), ready);
}

void Server::State::received(Viewer& viewer, Record record) {
  if (!viewer.joined) return shakeHands(viewer, record);
  if (record.kind == RecordKind::Message) {
    const std::size_t bytes = record.body.size();
    report(ViewerMessage{viewer.id, std::move(record.body)}, bytes);
    const std::lock_guard lock(mutex);
    if (inbox > options.limits.inboxBytes) viewer.channel->pauseReading();
    return;
  }
  if (record.kind == RecordKind::Refusal) {
    const auto refusal = readRefusal(record.body);
    return viewer.channel->close(refusal ? fmt::format("the viewer left: {}", refusal->why)
                                         : fmt::format("cut off: {}", refusal.error().message));
  }
  const std::string why = fmt::format("a {} after the handshake", nameOf(record.kind));
  viewer.channel->closeAfter(encode(Refusal{RefusalReason::Protocol, options.versions, why}),
                             fmt::format("cut off: {}", why));
}

void Server::State::shakeHands(Viewer& viewer, const Record& record) {
  HandshakeStep step = viewer.handshake->receive(record);
  if (step.refused) {
    const std::string reason =
        fmt::format("{}: {}", step.byPeer ? "the viewer refused" : "refused", step.refused->why);
    if (step.byPeer) return viewer.channel->close(reason);
    return viewer.channel->closeAfter(std::move(step.send), reason);
  }
  if (!step.done) {
    if (!step.send.empty()) (void)viewer.channel->send(std::move(step.send));
    return;
  }
  const auto refuse = [&](RefusalReason reason, const std::string& why) {
    viewer.channel->closeAfter(encode(Refusal{reason, options.versions, why}),
                               fmt::format("refused: {}", why));
  };
  const auto others = std::ranges::count_if(viewers, [](const auto& entry) { return entry.second.joined; });
  if (static_cast<std::size_t>(others) >= options.viewers)
    return refuse(RefusalReason::Busy, fmt::format("the server has {} viewers, as many as it may", others));
  if (const auto pinned = pin(viewer); !pinned)
    return refuse(RefusalReason::Certificate,
                  "the server could not keep the pairing: " + pinned.error().message);
  auto video = ViewerVideo::make(viewer.ready, {options.frameInterval, 0.8, options.packetBytes});
  if (!video) return refuse(RefusalReason::Closing, video.error().message);
  viewer.video.emplace(std::move(*video));
  viewer.pace = std::make_unique<asio::steady_timer>(io);
  viewer.joined = true;
  {
    const std::lock_guard lock(mutex);
    joined.emplace(viewer.id, std::pair(viewer.channel, SendStatistics{}));
  }
  (void)viewer.channel->send(std::move(step.send));
  viewer.channel->establish();
  log(fmt::format(
      "viewer {} ({}): connected{}", viewer.id, viewer.channel->peer(),
      viewer.binding ? ", certificate " + showFingerprint(viewer.binding->viewerCertificate) : ""));
  report(ViewerJoined{viewer.id, viewer.channel->peer(), viewer.binding.has_value(),
                      viewer.binding ? showFingerprint(viewer.binding->viewerCertificate) : "",
                      viewer.handshake->version()});
}

Result<void> Server::State::pin(const Viewer& viewer) {
  return viewer.binding ? pins->addViewer(viewer.binding->viewerCertificate) : Result<void>();
}

void Server::State::left(ViewerId id, const std::string& reason) {
  const auto found = viewers.find(id);
  if (found == viewers.end()) return;
  log(fmt::format("{} {} ({}): {}", found->second.joined ? "viewer" : "connection", id,
                  found->second.channel->peer(), reason));
  if (found->second.joined) {
    report(ViewerLeft{id, reason});
    const std::lock_guard lock(mutex);
    joined.erase(id);
  }
  // The channel may be in the midst of a call into here; what it uses goes after that.
  asio::post(io, [this, id] {
    viewers.erase(id);
    if (stopping && viewers.empty()) io.stop();
  });
}

void Server::State::report(ServerEvent event, std::size_t bytes) {
  const std::lock_guard lock(mutex);
  events.push_back(std::move(event));
  inbox += bytes;
}

std::vector<ServerEvent> Server::State::poll() {
  std::vector<ServerEvent> taken;
  bool paused = false;
  {
    const std::lock_guard lock(mutex);
    taken.swap(events);
    paused = inbox > options.limits.inboxBytes;
    inbox = 0;
  }
  if (paused)
    asio::post(io, [this] {
      for (auto& [id, viewer] : viewers) viewer.channel->resumeReading();
    });
  return taken;
}

Result<std::shared_ptr<Channel>> Server::State::channelOf(ViewerId id) const {
  const std::lock_guard lock(mutex);
  const auto found = joined.find(id);
  if (found == joined.end()) return fail("viewer {}: is not connected", id);
  return found->second.first;
}

std::vector<ViewerStatus> Server::State::status() const {
  std::vector<ViewerStatus> all;
  const std::lock_guard lock(mutex);
  for (const auto& [id, entry] : joined)
    all.push_back({id, entry.first->pendingBytes(), entry.first->roundTripMs(), entry.second});
  return all;
}

void Server::State::dismiss(ViewerId id, const std::string& why) {
  const auto found = viewers.find(id);
  if (found == viewers.end()) return;
  found->second.channel->closeAfter(encode(Refusal{RefusalReason::Closing, options.versions, why}),
                                    "dismissed: " + why);
}

void Server::State::receiveHellos() {
  socket.async_wait(udp::socket::wait_read, [this](asio::error_code error) {
    if (stopping || error == asio::error::operation_aborted) return;
    // As many as there are, but not for ever: other work waits.
    std::array<std::uint8_t, 256> datagram{};
    for (int i = 0; i < 64; ++i) {
      udp::endpoint from;
      const std::size_t size = socket.receive_from(asio::buffer(datagram), from, 0, error);
      if (error) break;
      heardHello(std::span(datagram).first(size), from);
    }
    receiveHellos();
  });
}

void Server::State::heardHello(std::span<const std::uint8_t> datagram, const udp::endpoint& from) {
  const auto hello = readVideoHello(datagram);
  if (!hello) return;
  const auto found = std::ranges::find_if(viewers, [&](const auto& entry) {
    return entry.second.video && entry.second.ready.session == hello->session;
  });
  if (found == viewers.end()) return;
  Viewer& viewer = found->second;
  // The video goes to the machine that the TCP channel leads to, and to no other.
  asio::error_code error;
  const auto peer = asio::ip::make_address(viewer.channel->peerIp(), error);
  if (error || plainAddress(from.address()) != plainAddress(peer)) return;
  const auto now = Clock::now();
  const bool wasOpen = viewer.videoOpen && viewer.video->open(now);
  if (!viewer.video->accept(datagram, now)) return;
  viewer.path = from;
  viewer.videoOpen = true;
  if (!wasOpen) report(ViewerVideoOpen{viewer.id});
}

void Server::State::pushVideo(ViewerId id, std::uint32_t frame, const Bytes& accessUnit) {
  const auto found = viewers.find(id);
  if (found == viewers.end() || !found->second.video) return;
  Viewer& viewer = found->second;
  const auto now = Clock::now();
  if (!viewer.video->open(now)) {
    ++viewer.video->statistics.unopened;
  } else if (const auto pushed = viewer.video->push(accessUnit, frame, now); !pushed) {
    log(fmt::format("viewer {}: {}", id, pushed.error().message));
  }
  pace(viewer);
}

void Server::State::pace(Viewer& viewer) {
  const auto now = Clock::now();
  while (true) {
    auto packet = viewer.video->take(now);
    if (!packet) {
      log(fmt::format("viewer {}: {}", viewer.id, packet.error().message));
      continue;
    }
    if (!*packet) break;
    asio::error_code error;
    if (viewer.video->open(now)) socket.send_to(asio::buffer(**packet), viewer.path, 0, error);
    if (error) ++viewer.video->statistics.unsent;
  }
  {
    const std::lock_guard lock(mutex);
    if (const auto entry = joined.find(viewer.id); entry != joined.end())
      entry->second.second = viewer.video->statistics;
  }
  const auto due = viewer.video->nextDue();
  if (!due) return;
  viewer.pace->expires_at(*due);
  viewer.pace->async_wait([this, id = viewer.id](asio::error_code error) {
    if (error || stopping) return;
    if (const auto found = viewers.find(id); found != viewers.end()) pace(found->second);
  });
}

Server::Server(std::shared_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() { state_->stop(); }

Result<std::unique_ptr<Server>> Server::start(ServerOptions options) {
  auto state = std::make_shared<State>(std::move(options));
  if (const auto prepared = state->prepare(); !prepared) return tl::unexpected(prepared.error());
  if (const auto listening = state->listen(); !listening) return tl::unexpected(listening.error());
  state->run();
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Result<void> Server::check(ServerOptions options) {
  State state(std::move(options));
  if (auto prepared = state.prepare(); !prepared) return prepared;
  return state.listen();
}

const Address& Server::address() const { return state_->address; }
const std::string& Server::fingerprint() const { return state_->shownFingerprint; }
std::vector<ServerEvent> Server::poll() { return state_->poll(); }
std::vector<ViewerStatus> Server::viewers() const { return state_->status(); }

Result<void> Server::send(ViewerId viewer, std::span<const std::uint8_t> message) {
  if (message.size() > state_->options.limits.messageBytes)
    return fail("a message of {} bytes: at most {} may be sent", message.size(),
                state_->options.limits.messageBytes);
  const auto channel = state_->channelOf(viewer);
  if (!channel) return tl::unexpected(channel.error());
  return (*channel)->send(encodeMessage(message));
}

Result<void> Server::sendVideo(ViewerId viewer, std::uint32_t frame,
                               std::shared_ptr<const Bytes> accessUnit) {
  if (const auto channel = state_->channelOf(viewer); !channel) return tl::unexpected(channel.error());
  asio::post(state_->io, [state = state_.get(), viewer, frame, accessUnit = std::move(accessUnit)] {
    state->pushVideo(viewer, frame, *accessUnit);
  });
  return {};
}

void Server::dismiss(ViewerId viewer, const std::string& why) {
  asio::post(state_->io, [state = state_.get(), viewer, why] { state->dismiss(viewer, why); });
}

}  // namespace tessera::transport
