// Any bytes from a peer: the first says to whom, and how they are cut. On a secure channel no bytes may ever
// do: the key is not in them.
#include <algorithm>
#include <cstdlib>

#include "codec/transport/handshake.hpp"
#include "codec/transport/video_hello.hpp"

namespace {

using namespace tessera::transport;

template <class Handshake>
void talk(Handshake& handshake, bool secure, std::span<const std::uint8_t> bytes, std::size_t piece) {
  RecordParser parser(4096);
  bool over = false;
  while (!bytes.empty()) {
    const std::size_t size = std::min(piece, bytes.size());
    parser.feed(bytes.first(size));
    bytes = bytes.subspan(size);
    while (true) {
      const auto record = parser.next();
      if (!record) return;
      if (!*record) break;
      if ((*record)->body.size() > 4096) std::abort();
      if (over) {
        (void)readPing((*record)->body);
        (void)readRefusal((*record)->body);
        continue;
      }
      const HandshakeStep step = handshake.receive(**record);
      if (step.done && secure) std::abort();
      if (step.done) parser.allowMessages();
      over = step.done || step.refused;
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const SecureTerms terms{*PairingKey::make("a-token-for-the-fuzzer"), {}};
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  const std::size_t piece = 1 + data[0] / 8;
  const int side = data[0] % 8;
  Ready ready{1, {}, 2, {}};
  if (side == 0) {
    ServerHandshake server({1, 3}, {}, ready);
    talk(server, false, bytes, piece);
  } else if (side == 1) {
    ready.srtpKey.emplace();
    ServerHandshake server({1, 3}, terms, ready);
    talk(server, true, bytes, piece);
  } else if (side == 2) {
    ClientHandshake viewer({1, 3}, {});
    talk(viewer, false, bytes, piece);
  } else if (side == 3) {
    ClientHandshake viewer({1, 3}, terms);
    talk(viewer, true, bytes, piece);
  } else if (isSigned(bytes, terms.key.bytes().first<32>())) {
    std::abort();
  }
  return 0;
}
