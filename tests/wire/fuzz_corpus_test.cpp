// The fuzzer's inputs: what two small servers and a viewer say. TESSERA_WRITE_CORPUS names a folder to write
// them to, as after a change of the format; else they are read as a peer reads them, so that the corpus
// cannot go stale.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "codec/wire/framing.hpp"
#include "codec/wire/handshake.hpp"
#include "codec/wire/message_order.hpp"
#include "codec/wire/visible_mirror.hpp"
#include "tests/wire/random_world.hpp"
#include "tests/wire/some_messages.hpp"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::uint8_t> inputOf(std::uint8_t choice, const std::vector<Message>& messages) {
  std::vector<std::uint8_t> bytes = {choice};
  for (const Message& message : messages) {
    const auto encoded = encode(message);
    bytes.insert(bytes.end(), encoded->begin(), encoded->end());
  }
  return bytes;
}

std::vector<std::uint8_t> serverInput(Method method, std::uint8_t choice) {
  StreamSetup setup = someSetup();
  setup.method = method;
  std::vector<Message> messages = {Hello{kSpoken, Role::Server, ""}, setup, somePath(), someMask()};
  RandomWorld world(method, 21, 50);
  VisibleDelta delta(world.source);
  for (std::uint32_t frame = 1; frame <= 4; ++frame) {
    world.step();
    messages.emplace_back(someFrame(frame));
    messages.emplace_back(Geometry{frame, delta.next(world.frame())});
  }
  return inputOf(choice, messages);
}

std::vector<std::pair<std::string, std::vector<std::uint8_t>>> inputs() {
  return {{"server_rect", serverInput(Method::Rect, 0)},
          {"server_tess", serverInput(Method::Tess, 5)},
          {"viewer", inputOf(2, {Hello{kSpoken, Role::Viewer, "token"}, somePose(1), Acknowledge{1, 2, 3.0},
                                 AskIFrame{2}, Refusal{RefusalReason::Closing, kSpoken, "bye"}})}};
}

TEST(FuzzCorpus, IsOfThisFormat) {
  const char* folder = std::getenv("TESSERA_WRITE_CORPUS");
  for (const auto& [name, expected] : inputs()) {
    const fs::path path =
        fs::path(folder != nullptr ? folder : TESSERA_SOURCE_DIR "/tests/fuzz/corpus/wire") / name;
    if (folder != nullptr) {
      std::ofstream(path, std::ios::binary)
          .write(reinterpret_cast<const char*>(expected.data()),
                 static_cast<std::streamsize>(expected.size()));
      continue;
    }
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    ASSERT_GT(text.size(), 1u) << path;
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    MessageParser parser;
    parser.feed(std::span(bytes).subspan(1));
    MessageOrder order((bytes[0] & 2) != 0 ? Role::Viewer : Role::Server);
    VisibleMirror mirror((bytes[0] & 1) != 0 ? Method::Tess : Method::Rect, {4096, 2304});
    int count = 0;
    for (;; ++count) {
      const auto message = parser.next();
      ASSERT_TRUE(message) << name << ": " << message.error().message;
      if (!*message) break;
      ASSERT_TRUE(order.accept(**message)) << name;
      if (const Geometry* geometry = std::get_if<Geometry>(&**message)) {
        const auto applied = mirror.apply(geometry->changes);
        ASSERT_TRUE(applied) << name << ": " << applied.error().message;
      }
    }
    EXPECT_GE(count, 5) << name;
    EXPECT_EQ(parser.pending(), 0u) << name;
  }
}

}  // namespace
}  // namespace tessera::test
