#include "tests/transport/proxy.hpp"

#include <algorithm>
#include <array>
#include <asio/connect.hpp>
#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ip/udp.hpp>
#include <asio/post.hpp>
#include <asio/steady_timer.hpp>
#include <asio/write.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

namespace tessera::test {

namespace {

using asio::ip::tcp;
using asio::ip::udp;
using Clock = std::chrono::steady_clock;
using Bytes = std::vector<std::uint8_t>;

Clock::duration milliseconds(double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(value));
}
Clock::duration timeOnWire(std::size_t bytes, double megabitPerSecond) {
  if (megabitPerSecond <= 0.0) return {};
  return milliseconds(8e-3 * static_cast<double>(bytes) / megabitPerSecond);
}

/// One way of one TCP connection: reads only as fast as it passes on, so that a slow far end is felt by the
/// near one.
class Pipe : public std::enable_shared_from_this<Pipe> {
 public:
  Pipe(std::shared_ptr<tcp::socket> from, std::shared_ptr<tcp::socket> to, const Impairment& impairment)
      : from_(std::move(from)), to_(std::move(to)), impairment_(impairment), timer_(from_->get_executor()) {}

  void read() {
    if (reading_ || ended_ || waiting_ > kMostWaiting) return;
    reading_ = true;
    from_->async_read_some(asio::buffer(buffer_), [self = shared_from_this()](asio::error_code error,
                                                                              std::size_t n) {
      self->reading_ = false;
      if (error) {
        self->ended_ = true;
        return self->pass();
      }
      const auto now = Clock::now();
      self->wireFree_ = std::max(self->wireFree_, now) + timeOnWire(n, self->impairment_.megabitPerSecond);
      self->queue_.push_back(
          {self->wireFree_ + milliseconds(self->impairment_.delayMs),
           Bytes(self->buffer_.begin(), self->buffer_.begin() + static_cast<std::ptrdiff_t>(n))});
      self->waiting_ += n;
      self->pass();
      self->read();
    });
  }

 private:
  static constexpr std::size_t kMostWaiting = 1 << 18;
  struct Part {
    Clock::time_point due;
    Bytes bytes;
  };

  void pass() {
    if (passing_) return;
    if (queue_.empty()) {
      asio::error_code ignored;
      if (ended_) to_->shutdown(tcp::socket::shutdown_send, ignored);
      return;
    }
    passing_ = true;
    timer_.expires_at(queue_.front().due);
    timer_.async_wait([self = shared_from_this()](asio::error_code) {
      asio::async_write(*self->to_, asio::buffer(self->queue_.front().bytes),
                        [self](asio::error_code error, std::size_t n) {
                          self->passing_ = false;
                          self->waiting_ -= n;
                          self->queue_.pop_front();
                          asio::error_code ignored;
                          if (error) {
                            self->queue_.clear();
                            self->ended_ = true;
                            self->from_->close(ignored);
                            return;
                          }
                          self->pass();
                          self->read();
                        });
    });
  }

  std::shared_ptr<tcp::socket> from_, to_;
  const Impairment& impairment_;
  asio::steady_timer timer_;
  std::array<std::uint8_t, 16384> buffer_{};
  std::deque<Part> queue_;
  std::size_t waiting_ = 0;
  Clock::time_point wireFree_{};
  bool reading_ = false, passing_ = false, ended_ = false;
};

}  // namespace

class Proxy::State {
 public:
  State(const transport::Address& to, const Impairment& impairment, std::uint32_t seed)
      : work(asio::make_work_guard(io)), acceptor(io), front(io), now(impairment), random(seed) {
    const auto ip = asio::ip::make_address(to.host);
    targetTcp = {ip, to.port};
    targetUdp = {ip, to.port};
    bind();
    accept();
    receiveFront();
    thread = std::thread([this] { io.run(); });
  }
  ~State() {
    io.stop();
    thread.join();
  }

  void cut() {
    asio::error_code ignored;
    for (const auto& connection : connections)
      if (const auto open = connection.lock()) open->close(ignored);
    connections.clear();
  }

  asio::io_context io;
  asio::executor_work_guard<asio::io_context::executor_type> work;
  tcp::acceptor acceptor;
  udp::socket front;
  Impairment now;
  std::uint16_t port = 0;
  std::mutex mutex;
  ProxyStatistics statistics;

 private:
  /// A viewer's UDP address and the socket that stands for it towards the target.
  struct Flow {
    explicit Flow(asio::io_context& context) : back(context) {}
    udp::endpoint viewer;
    udp::socket back;
    Bytes buffer = Bytes(1 << 16);
    Clock::time_point wireFree[2] = {};
  };

  void bind() {
    const auto loopback = asio::ip::address_v4::loopback();
    for (int i = 0; i < 16; ++i) {
      asio::error_code error;
      acceptor.close(error);
      front.close(error);
      acceptor.open(tcp::v4());
      acceptor.bind({loopback, 0}, error);
      if (!error) acceptor.listen(16, error);
      if (error) continue;
      port = acceptor.local_endpoint().port();
      front.open(udp::v4());
      front.bind({loopback, port}, error);
      if (!error) return;
    }
    std::fputs("proxy: no port is free\n", stderr);
    std::abort();
  }

  void accept() {
    acceptor.async_accept([this](asio::error_code error, tcp::socket peer) {
      if (error) return;
      auto viewer = std::make_shared<tcp::socket>(std::move(peer));
      auto server = std::make_shared<tcp::socket>(io);
      server->async_connect(targetTcp, [this, viewer, server](asio::error_code failed) {
        if (failed) return;  // closes the viewer's
        asio::error_code ignored;
        viewer->set_option(tcp::no_delay(true), ignored);
        server->set_option(tcp::no_delay(true), ignored);
        connections.push_back(viewer);
        connections.push_back(server);
        std::make_shared<Pipe>(viewer, server, now)->read();
        std::make_shared<Pipe>(server, viewer, now)->read();
      });
      accept();
    });
  }

  void receiveFront() {
    front.async_receive_from(asio::buffer(buffer), from, [this](asio::error_code error, std::size_t n) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        auto& flow = flows[from];
        if (!flow) {
          flow = std::make_shared<Flow>(io);
          flow->viewer = from;
          flow->back.open(udp::v4());
          flow->back.set_option(asio::socket_base::receive_buffer_size(4 << 20));
          flow->back.connect(targetUdp);
          receiveBack(flow);
        }
        pass(flow, 0, Bytes(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(n)));
      }
      receiveFront();
    });
  }

  void receiveBack(const std::shared_ptr<Flow>& flow) {
    flow->back.async_receive(asio::buffer(flow->buffer), [this, flow](asio::error_code error, std::size_t n) {
      if (error == asio::error::operation_aborted) return;
      if (!error)
        pass(flow, 1, Bytes(flow->buffer.begin(), flow->buffer.begin() + static_cast<std::ptrdiff_t>(n)));
      receiveBack(flow);
    });
  }

  void pass(const std::shared_ptr<Flow>& flow, int way, Bytes bytes) {
    // The same number of draws for each, so that one decision does not shift the others.
    const double draws[] = {draw(), draw(), draw(), draw()};
    const auto present = Clock::now();
    auto due = present;
    bool twice = false;
    {
      const std::lock_guard lock(mutex);
      ++statistics.datagrams;
      if (draws[0] < now.loss) {
        ++statistics.lost;
        return;
      }
      auto& wireFree = flow->wireFree[way];
      const auto wireUntil = std::max(wireFree, present) + timeOnWire(bytes.size(), now.megabitPerSecond);
      if (wireUntil - present > milliseconds(now.queueMs)) {
        ++statistics.overflowed;
        return;
      }
      wireFree = wireUntil;
      due = wireUntil + milliseconds(now.delayMs + draws[1] * now.jitterMs);
      if (draws[2] < now.reorder) due += milliseconds(now.reorderMs);
      twice = draws[3] < now.duplicate;
      statistics.duplicated += twice ? 1 : 0;
    }
    if (twice) sendAt(due, flow, way, bytes);
    sendAt(due, flow, way, std::move(bytes));
  }

  void sendAt(Clock::time_point due, const std::shared_ptr<Flow>& flow, int way, Bytes bytes) {
    const auto send = [this, flow, way, bytes = std::move(bytes)] {
      asio::error_code ignored;
      if (way == 0) {
        flow->back.send(asio::buffer(bytes), 0, ignored);
      } else {
        front.send_to(asio::buffer(bytes), flow->viewer, 0, ignored);
      }
    };
    if (due <= Clock::now()) return send();
    auto timer = std::make_shared<asio::steady_timer>(io, due);
    timer->async_wait([timer, send](asio::error_code error) {
      if (!error) send();
    });
  }

  double draw() { return std::uniform_real_distribution<double>(0.0, 1.0)(random); }

  tcp::endpoint targetTcp;
  udp::endpoint targetUdp;
  udp::endpoint from;
  std::array<std::uint8_t, 1 << 16> buffer{};
  std::mt19937 random;
  std::map<udp::endpoint, std::shared_ptr<Flow>> flows;
  std::vector<std::weak_ptr<tcp::socket>> connections;
  std::thread thread;
};

Proxy::Proxy(const transport::Address& target, const Impairment& impairment, std::uint32_t seed)
    : state_(std::make_unique<State>(target, impairment, seed)) {}

Proxy::~Proxy() = default;

transport::Address Proxy::address() const { return {"127.0.0.1", state_->port}; }

void Proxy::impair(const Impairment& impairment) {
  asio::post(state_->io, [state = state_.get(), impairment] { state->now = impairment; });
}

void Proxy::cut() {
  asio::post(state_->io, [state = state_.get()] { state->cut(); });
}

ProxyStatistics Proxy::statistics() const {
  const std::lock_guard lock(state_->mutex);
  return state_->statistics;
}

}  // namespace tessera::test
