// A server and viewers in one process, and waiting for what they report.
#pragma once

#include <functional>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "codec/transport/client.hpp"
#include "codec/transport/server.hpp"

namespace tessera::test {

/// Far beyond what anything takes; only a test that fails waits for it.
inline constexpr std::chrono::seconds kPatience{20};

/// Lines of a log, from another thread.
class Log {
 public:
  std::function<void(const std::string&)> sink() {
    return [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      text_ += line + '\n';
    };
  }
  std::string text() const {
    const std::lock_guard lock(mutex_);
    return text_;
  }
  bool has(const std::string& part) const { return text().find(part) != std::string::npos; }

 private:
  mutable std::mutex mutex_;
  std::string text_;
};

template <class Condition>
bool waitFor(const Condition& condition, std::chrono::milliseconds patience = kPatience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// A server with everything that it reported.
struct TestServer {
  explicit TestServer(transport::ServerOptions options) {
    if (options.listen.port == 7400) options.listen.port = 0;
    options.log = log.sink();
    auto started = transport::Server::start(std::move(options));
    if (started) server = std::move(*started);
    if (!started) error = started.error().message;
  }
  void poll() {
    for (auto& event : server->poll()) {
      if (auto* one = std::get_if<transport::ViewerJoined>(&event)) joined.push_back(*one);
      if (auto* one = std::get_if<transport::ViewerVideoOpen>(&event)) videoOpen.push_back(one->viewer);
      if (auto* one = std::get_if<transport::ViewerMessage>(&event)) messages.push_back(std::move(*one));
      if (auto* one = std::get_if<transport::ViewerLeft>(&event)) left.push_back(*one);
    }
  }
  template <class Condition>
  bool until(const Condition& condition) {
    return waitFor([&] {
      poll();
      return condition();
    });
  }

  Log log;
  std::unique_ptr<transport::Server> server;
  std::string error;
  std::vector<transport::ViewerJoined> joined;
  std::vector<transport::ViewerId> videoOpen;
  std::vector<transport::ViewerMessage> messages;
  std::vector<transport::ViewerLeft> left;
};

struct TestViewer {
  explicit TestViewer(transport::ClientOptions options) {
    options.log = log.sink();
    auto started = transport::Client::start(std::move(options));
    if (started) client = std::move(*started);
    if (!started) error = started.error().message;
  }
  explicit TestViewer(const transport::Address& server) : TestViewer(at(server)) {}
  static transport::ClientOptions at(const transport::Address& server) {
    transport::ClientOptions options;
    options.server = server;
    return options;
  }
  void poll() {
    for (auto& event : client->poll()) {
      if (auto* one = std::get_if<transport::Connected>(&event)) connected.push_back(*one);
      if (auto* one = std::get_if<transport::Disconnected>(&event)) disconnected.push_back(*one);
      if (auto* one = std::get_if<transport::ServerMessage>(&event))
        messages.push_back(std::move(one->bytes));
      if (auto* one = std::get_if<transport::VideoFrame>(&event)) frames.push_back(std::move(one->frame));
    }
  }
  template <class Condition>
  bool until(const Condition& condition) {
    return waitFor([&] {
      poll();
      return condition();
    });
  }
  /// Why it was refused for good; empty where it was not.
  std::string refusal() {
    until([&] { return !connected.empty() || (!disconnected.empty() && !disconnected.back().retrying); });
    return connected.empty() && !disconnected.empty() ? disconnected.back().reason : "";
  }

  Log log;
  std::unique_ptr<transport::Client> client;
  std::string error;
  std::vector<transport::Connected> connected;
  std::vector<transport::Disconnected> disconnected;
  std::vector<transport::Bytes> messages;
  std::vector<transport::ReceivedFrame> frames;
};

}  // namespace tessera::test
