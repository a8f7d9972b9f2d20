#include "codec/transport/client.hpp"

#include <algorithm>
#include <array>
#include <asio/connect.hpp>
#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <asio/post.hpp>
#include <mutex>
#include <optional>
#include <thread>

#include "codec/transport/channel.hpp"
#include "codec/transport/crypto.hpp"
#include "codec/transport/handshake.hpp"
#include "codec/transport/pins.hpp"
#include "codec/transport/srtp.hpp"
#include "codec/transport/video_hello.hpp"

namespace tessera::transport {

namespace {
using asio::ip::tcp;
using asio::ip::udp;
}  // namespace

class Client::State {
 public:
  explicit State(ClientOptions given)
      : options(std::move(given)),
        work(asio::make_work_guard(io)),
        resolver(io),
        connecting(io),
        socket(io),
        retry(io),
        hello(io),
        deadline(io),
        datagram(1 << 16),
        backoff(options.firstBackoff) {}

  Result<void> prepare();
  void run();
  void stop();
  std::vector<ClientEvent> poll();
  std::shared_ptr<Channel> connectedChannel() const;
  ClientStatus status() const;

  ClientOptions options;
  asio::io_context io;

 private:
  void connect();
  void tryEndpoints(const tcp::resolver::results_type& found);
  void opened();
  void received(Record record);
  void shakeHands(const Record& record);
  void join(const Ready& ready);
  void lost(const std::string& reason);
  void sayHello();
  void receiveVideo();
  void takeDatagram(std::size_t size);
  void takeFrames();
  void report(ClientEvent event, std::size_t bytes = 0);
  void log(const std::string& line) const {
    if (options.log) options.log(line);
  }

  asio::executor_work_guard<asio::io_context::executor_type> work;
  tcp::resolver resolver;
  tcp::socket connecting;
  udp::socket socket;
  asio::steady_timer retry;  // also the limit of a try to connect
  asio::steady_timer hello;
  asio::steady_timer deadline;  // of a frame under way
  std::thread thread;
  std::optional<PairingKey> key;
  Identity identity;
  std::optional<Pins> pins;
  std::unique_ptr<asio::ssl::context> tls;
  std::shared_ptr<Channel> channel;
  std::optional<ClientHandshake> handshake;
  std::optional<Binding> binding;
  std::optional<RtpReceiver> video;
  std::optional<Srtp> srtp;
  std::uint64_t helloNumber = 0;
  Bytes datagram;
  std::chrono::milliseconds backoff;
  std::uint64_t connections = 0;  // that were made
  bool final = false;             // trying again cannot help
  bool joined = false;
  Clock::time_point joinedAt{};
  bool stopping = false;

  mutable std::mutex mutex;  // of what follows
  std::vector<ClientEvent> events;
  std::size_t inbox = 0;   // bytes of messages in them
  std::size_t frames = 0;  // of video in them
  std::shared_ptr<Channel> connected;
  VideoStatistics statistics;
};

Result<void> Client::State::prepare() {
  if (options.token.empty()) return {};
  auto made = PairingKey::make(options.token);
  if (!made) return tl::unexpected(made.error());
  key = *made;
  if (options.folder.empty()) return fail("a pairing token needs a folder for the certificate");
  auto own = loadOrMakeIdentity(options.folder);
  if (!own) return tl::unexpected(own.error());
  identity = std::move(*own);
  auto known = Pins::load(options.folder / "paired");
  if (!known) return tl::unexpected(known.error());
  pins = std::move(*known);
  auto context = makeTlsContext(identity);
  if (!context) return tl::unexpected(context.error());
  tls = std::move(*context);
  return {};
}

void Client::State::run() {
  asio::post(io, [this] { connect(); });
  thread = std::thread([this] { io.run(); });
}

void Client::State::stop() {
  asio::post(io, [this] {
    stopping = true;
    asio::error_code ignored;
    resolver.cancel();
    connecting.close(ignored);
    socket.close(ignored);
    if (!channel) return io.stop();
    channel->closeAfter(encode(Refusal{RefusalReason::Closing, options.versions, "the viewer was closed"}),
                        "closed");
    retry.expires_after(std::chrono::milliseconds(300));
    retry.async_wait([this](asio::error_code) { io.stop(); });
  });
  if (thread.joinable()) thread.join();
}

void Client::State::connect() {
  resolver.async_resolve(options.server.host, std::to_string(options.server.port),
                         tcp::resolver::numeric_service,
                         [this](asio::error_code error, const tcp::resolver::results_type& found) {
                           if (stopping) return;
                           if (error)
                             return lost(fmt::format("{}: {}", describe(options.server), error.message()));
                           tryEndpoints(found);
                         });
}

void Client::State::tryEndpoints(const tcp::resolver::results_type& found) {
  std::vector<tcp::endpoint> endpoints;
  for (const auto& entry : found)
    if (!options.token.empty() || plainAllowed(entry.endpoint().address().to_string(), options.treatAsRemote))
      endpoints.push_back(entry.endpoint());
  if (endpoints.empty()) {
    final = true;
    return lost(
        fmt::format("{}: not of this machine: plain TCP is refused, connecting there needs a pairing token",
                    describe(options.server)));
  }
  retry.expires_after(options.limits.handshake);
  retry.async_wait([this](asio::error_code error) {
    asio::error_code ignored;
    if (!error) connecting.close(ignored);
  });
  connecting = tcp::socket(io);
  asio::async_connect(connecting, endpoints, [this](asio::error_code error, const tcp::endpoint&) {
    retry.cancel();
    if (stopping) return;
    if (error) return lost(fmt::format("{}: {}", describe(options.server), error.message()));
    channel = std::make_shared<Channel>(std::move(connecting), options.limits);
    channel->open(tls.get(), Side::Viewer,
                  {[this] { opened(); }, [this](Record record) { received(std::move(record)); },
                   [this](const std::string& reason) { lost(reason); }});
  });
}

void Client::State::opened() {
  std::optional<SecureTerms> terms;
  binding.reset();
  if (SSL* connection = channel->tls()) {
    const auto bound = bindingOf(connection, Side::Viewer, identity.fingerprint);
    if (!bound) return channel->close(bound.error().message);
    binding = *bound;
    const std::string name = describe(options.server);
    const auto pinned = pins->serverAt(name);
    if (pinned && *pinned != binding->serverCertificate) {
      final = true;
      return channel->close(fmt::format(
          "the certificate of {} changed: paired with {}, now {}; if that is meant, remove its line from {}",
          name, showFingerprint(*pinned), showFingerprint(binding->serverCertificate),
          pins->file().string()));
    }
    if (!pinned && !options.pairNew) {
      final = true;
      return channel->close(fmt::format("the certificate {} of {} is not paired with this viewer",
                                        showFingerprint(binding->serverCertificate), name));
    }
    terms = SecureTerms{*key, *binding};
  }
  handshake.emplace(options.versions, std::move(terms));
  (void)channel->send(handshake->begin());
}

void Client::State::received(Record record) {
  if (!joined) return shakeHands(record);
  if (record.kind == RecordKind::Message) {
    const std::size_t bytes = record.body.size();
    report(ServerMessage{std::move(record.body)}, bytes);
    const std::lock_guard lock(mutex);
    if (inbox > options.limits.inboxBytes) channel->pauseReading();
    return;
  }
  if (record.kind == RecordKind::Refusal) {
    const auto refusal = readRefusal(record.body);
    if (!refusal) return channel->close(fmt::format("cut off: {}", refusal.error().message));
    final = isFinal(refusal->reason);
    return channel->close(fmt::format("the server ended it: {}", refusal->why));
  }
  channel->close(fmt::format("cut off: a {} after the handshake", nameOf(record.kind)));
}

void Client::State::shakeHands(const Record& record) {
  HandshakeStep step = handshake->receive(record);
  if (step.refused) {
    final = isFinal(step.refused->reason);
    const std::string reason =
        fmt::format("{}: {}", step.byPeer ? "the server refused" : "refused", step.refused->why);
    if (step.byPeer) return channel->close(reason);
    return channel->closeAfter(std::move(step.send), reason);
  }
  if (!step.send.empty()) (void)channel->send(std::move(step.send));
  if (step.done) join(handshake->ready());
}

void Client::State::join(const Ready& ready) {
  bool paired = false;
  if (binding) {
    const std::string name = describe(options.server);
    paired = !pins->serverAt(name);
    if (const auto kept = pins->addServer(name, binding->serverCertificate); !kept) {
      final = true;
      return channel->close("the pairing could not be kept: " + kept.error().message);
    }
  }
  srtp.reset();
  if (ready.srtpKey) {
    auto made = Srtp::make(ready.source, *ready.srtpKey);
    if (!made) return channel->close(made.error().message);
    srtp = std::move(*made);
  }
  asio::error_code error;
  const udp::endpoint server(asio::ip::make_address(channel->peerIp(), error), options.server.port);
  socket = udp::socket(io);
  if (!error) socket.open(server.protocol(), error);
  asio::error_code ignored;
  socket.set_option(asio::socket_base::receive_buffer_size(4 << 20), ignored);
  // Connected: the system drops what others send.
  if (!error) socket.connect(server, error);
  if (!error) socket.non_blocking(true, error);
  if (error) return channel->close(fmt::format("no UDP to the server: {}", error.message()));
  video.emplace(ready.source, options.receive);
  helloNumber = 0;
  ++connections;
  joined = true;
  joinedAt = Clock::now();
  {
    const std::lock_guard lock(mutex);
    connected = channel;
    statistics = {};
  }
  channel->establish();
  log(fmt::format("connected to {}", describe(options.server)));
  report(Connected{binding.has_value(), binding ? showFingerprint(binding->serverCertificate) : "", paired,
                   handshake->version()});
  sayHello();
  receiveVideo();
}

void Client::State::lost(const std::string& reason) {
  // A server that takes and dismisses a client again and again is not asked ten times a second.
  if (joined && Clock::now() - joinedAt > options.longestBackoff) backoff = options.firstBackoff;
  joined = false;
  asio::error_code ignored;
  socket.close(ignored);
  hello.cancel();
  deadline.cancel();
  const bool again = options.reconnect && !final && !stopping;
  log(fmt::format("{}{}", reason, again ? fmt::format("; next try in {} ms", backoff.count()) : ""));
  report(Disconnected{reason, again});
  {
    const std::lock_guard lock(mutex);
    connected.reset();
  }
  // The channel may be in the midst of a call into here; what it uses goes after that.
  asio::post(io, [this, old = std::move(channel)] {
    if (stopping) io.stop();
  });
  channel.reset();
  if (!again) return;
  retry.expires_after(backoff);
  retry.async_wait([this](asio::error_code error) {
    if (!error && !stopping) connect();
  });
  backoff = std::min(2 * backoff, options.longestBackoff);
}

void Client::State::sayHello() {
  if (!joined) return;
  const auto bytes =
      encode(VideoHello{handshake->ready().session, ++helloNumber}, handshake->ready().helloKey);
  asio::error_code ignored;
  socket.send(asio::buffer(bytes), 0, ignored);
  hello.expires_after(options.hello);
  hello.async_wait([this](asio::error_code error) {
    if (!error) sayHello();
  });
}

void Client::State::receiveVideo() {
  socket.async_wait(udp::socket::wait_read, [this, of = connections](asio::error_code error) {
    if (!joined || of != connections || error == asio::error::operation_aborted) return;
    // As many as there are, but not for ever: other work waits.
    for (int i = 0; i < 512; ++i) {
      const std::size_t size = socket.receive(asio::buffer(datagram), 0, error);
      if (error == asio::error::would_block) break;
      // A refusal of an earlier datagram that the system remembers, say: nothing was read, and more may be
      // there.
      if (!error) takeDatagram(size);
    }
    takeFrames();
    receiveVideo();
  });
}

void Client::State::takeDatagram(std::size_t size) {
  Bytes packet(datagram.begin(), datagram.begin() + static_cast<std::ptrdiff_t>(size));
  if (srtp)
    if (!srtp->unprotect(packet)) return;
  (void)video->push(packet, Clock::now());
}

void Client::State::takeFrames() {
  while (auto frame = video->next(Clock::now())) report(VideoFrame{std::move(*frame)});
  {
    const std::lock_guard lock(mutex);
    statistics = video->statistics();
  }
  const auto due = video->nextDeadline();
  if (!due) return;
  deadline.expires_at(*due);
  deadline.async_wait([this](asio::error_code error) {
    if (!error && joined) takeFrames();
  });
}

void Client::State::report(ClientEvent event, std::size_t bytes) {
  const std::lock_guard lock(mutex);
  if (auto* came = std::get_if<VideoFrame>(&event)) {
    if (frames >= options.videoInbox) {
      const auto oldest = std::ranges::find_if(
          events, [](const auto& old) { return std::holds_alternative<VideoFrame>(old); });
      events.erase(oldest);
      --frames;
      // What is the oldest now follows a loss.
      const auto next = std::ranges::find_if(
          events, [](const auto& old) { return std::holds_alternative<VideoFrame>(old); });
      if (next != events.end()) {
        std::get<VideoFrame>(*next).frame.lostBefore = true;
      } else {
        came->frame.lostBefore = true;
      }
    }
    ++frames;
  }
  inbox += bytes;
  events.push_back(std::move(event));
}

std::vector<ClientEvent> Client::State::poll() {
  std::vector<ClientEvent> taken;
  bool paused = false;
  {
    const std::lock_guard lock(mutex);
    taken.swap(events);
    paused = inbox > options.limits.inboxBytes;
    inbox = 0;
    frames = 0;
  }
  if (paused)
    asio::post(io, [this] {
      if (channel) channel->resumeReading();
    });
  return taken;
}

std::shared_ptr<Channel> Client::State::connectedChannel() const {
  const std::lock_guard lock(mutex);
  return connected;
}

ClientStatus Client::State::status() const {
  const std::lock_guard lock(mutex);
  if (!connected) return {false, 0, 0.0, statistics};
  return {true, connected->pendingBytes(), connected->roundTripMs(), statistics};
}

Client::Client(std::shared_ptr<State> state) : state_(std::move(state)) {}

Client::~Client() { state_->stop(); }

Result<std::unique_ptr<Client>> Client::start(ClientOptions options) {
  auto state = std::make_shared<State>(std::move(options));
  if (const auto prepared = state->prepare(); !prepared) return tl::unexpected(prepared.error());
  state->run();
  return std::unique_ptr<Client>(new Client(std::move(state)));
}

std::vector<ClientEvent> Client::poll() { return state_->poll(); }
ClientStatus Client::status() const { return state_->status(); }

Result<void> Client::send(std::span<const std::uint8_t> message) {
  if (message.size() > state_->options.limits.messageBytes)
    return fail("a message of {} bytes: at most {} may be sent", message.size(),
                state_->options.limits.messageBytes);
  const auto channel = state_->connectedChannel();
  if (!channel) return fail("not connected to {}", describe(state_->options.server));
  return channel->send(encodeMessage(message));
}

}  // namespace tessera::transport
