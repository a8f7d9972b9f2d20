// Any bytes as what a peer sends: the parser, the order of messages, and a mirror that takes whatever
// geometry comes. The first byte says who the peer is, which method its atlas has, and into how large pieces
// the stream falls.
#include <cmath>
#include <cstdlib>

#include "codec/wire/framing.hpp"
#include "codec/wire/message_order.hpp"
#include "codec/wire/visible_mirror.hpp"

namespace {

using namespace tessera::wire;

// Everything in the arrays can be drawn.
void check(const VisibleMirror& mirror) {
  const std::size_t elements =
      mirror.method() == Method::Rect ? mirror.patches().size() : mirror.tess().size();
  for (const auto& t : mirror.triangles()) {
    if (t.owner == tessera::glsl::kNoOwner) continue;
    for (const std::uint32_t vertex : {t.v0, t.v1, t.v2})
      if (vertex >= mirror.vertices().size()) std::abort();
    if (tessera::glsl::ownerElement(t.owner) >= elements) std::abort();
  }
  for (const auto& v : mirror.vertices())
    if (!std::isfinite(v.x + v.y + v.z) || (v.object >= mirror.objects().size() && v.object != 0))
      std::abort();
  for (const std::uint32_t piece : mirror.pieces())
    if (piece != kNone && piece >= elements) std::abort();
  for (const auto& t : mirror.tess())
    if (t.firstPiece != 0 && t.firstPiece + 256 > mirror.pieces().size()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::uint8_t choice = data[0];
  const std::span<const std::uint8_t> stream(data + 1, size - 1);
  const Method method = (choice & 1) != 0 ? Method::Tess : Method::Rect;
  const Role peer = (choice & 2) != 0 ? Role::Viewer : Role::Server;
  // Without the role, geometry is reached by whatever the fuzzer makes of a stream.
  MessageParser parser = (choice & 8) != 0 ? MessageParser(peer) : MessageParser();
  MessageOrder order(peer);
  VisibleMirror mirror(method, {4096, 2304});
  const std::size_t piece = (choice & 4) != 0 ? 7 : 4096;
  for (std::size_t at = 0; at < stream.size(); at += piece) {
    parser.feed(stream.subspan(at, std::min(piece, stream.size() - at)));
    for (;;) {
      const auto message = parser.next();
      if (!message && message.error().message.empty()) std::abort();
      if (!message || !*message) break;
      if (const auto good = order.accept(**message); !good && good.error().message.empty()) std::abort();
      // What came encodes to what it was.
      if (const auto again = encode(**message); !again) std::abort();
      const Geometry* geometry = std::get_if<Geometry>(&**message);
      if (geometry == nullptr) continue;
      if (const auto applied = mirror.apply(geometry->changes); !applied && applied.error().message.empty())
        std::abort();
      check(mirror);
    }
  }
  return 0;
}
