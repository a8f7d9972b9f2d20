#include "codec/wire/message.hpp"

#include <array>
#include <cmath>
#include <zstd.h>

#include "codec/wire/bytes.hpp"

namespace tessera::wire {

namespace {

struct KindEntry {
  Kind kind;
  const char* name;
  std::size_t most;
};
constexpr std::size_t kText = 2 + kMostTextBytes;
constexpr std::size_t kCamera = 104;
constexpr std::size_t kLight = 52;
constexpr std::size_t kPathKey = 64;
constexpr std::array<KindEntry, 10> kKinds = {
    {{Kind::Hello, "hello", 9 + kText},
     {Kind::Refusal, "refusal", 5 + kText},
     {Kind::Setup, "setup", 24 + kCamera + kText},
     {Kind::Frame, "frame", 28 + kCamera + kLight* kMostLights},
     {Kind::Geometry, "geometry", std::size_t{64} << 20},
     {Kind::Mask, "mask", 24 + ZSTD_COMPRESSBOUND(std::size_t{kMostMaskSide} * kMostMaskSide)},
     {Kind::Path, "path", 4 + kPathKey* kMostPathKeys + kText},
     {Kind::Acknowledge, "acknowledge", 16},
     {Kind::Pose, "pose", 16 + kCamera},
     {Kind::AskIFrame, "ask for an I-frame", 4}}};

const KindEntry* entryOf(Kind kind) {
  for (const KindEntry& entry : kKinds)
    if (entry.kind == kind) return &entry;
  return nullptr;
}

/// Leaves and fences are mostly runs: a hundredth, as a rule.
std::vector<std::uint8_t> pack(std::span<const std::uint8_t> plain) {
  constexpr int kLevel = 9;
  std::vector<std::uint8_t> packed(ZSTD_compressBound(plain.size()));
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), kLevel);
  packed.resize(ZSTD_isError(size) != 0 ? 0 : size);
  return packed;
}

/// Empty where the bytes do not unpack to just so many.
std::vector<std::uint8_t> unpack(std::span<const std::uint8_t> packed, std::size_t count) {
  // Said in front, so that a few bytes that would unpack to many take no memory.
  if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != count) return {};
  std::vector<std::uint8_t> plain(count);
  if (ZSTD_decompress(plain.data(), count, packed.data(), packed.size()) != count) return {};
  return plain;
}

void write(ByteWriter& out, const Camera& camera) {
  for (int i = 0; i < 3; ++i) out.f64(camera.eye[i]);
  for (int i = 0; i < 4; ++i) out.f64(camera.orientation[i]);
  for (int i = 0; i < 4; ++i) out.f64(camera.slopes[i]);
  out.f64(camera.zNear);
  out.u32(camera.width);
  out.u32(camera.height);
}
void write(ByteWriter& out, const glm::vec3& v) {
  for (int i = 0; i < 3; ++i) out.f32(v[i]);
}
void pad(ByteWriter& out, int count) {
  for (int i = 0; i < count; ++i) out.u8(0);
}
std::string_view cut(const std::string& text) { return std::string_view(text).substr(0, kMostTextBytes); }

struct Writer {
  ByteWriter& out;
  void operator()(const Hello& m) const {
    out.u32(kMagic);
    out.u16(m.versions.oldest);
    out.u16(m.versions.newest);
    out.u8(static_cast<std::uint8_t>(m.role));
    out.text(cut(m.token));
  }
  void operator()(const Refusal& m) const {
    out.u8(static_cast<std::uint8_t>(m.reason));
    out.u16(m.versions.oldest);
    out.u16(m.versions.newest);
    out.text(cut(m.why));
  }
  void operator()(const StreamSetup& m) const {
    out.u16(m.version);
    out.u8(static_cast<std::uint8_t>(m.method));
    out.u8(static_cast<std::uint8_t>(m.chroma));
    out.u8(static_cast<std::uint8_t>(m.matrix));
    out.u8(m.fullRange ? 1 : 0);
    out.u16(m.paths);
    for (const std::uint32_t value : {m.width, m.height, m.fpsNumerator, m.fpsDenominator}) out.u32(value);
    write(out, m.start);
    out.text(cut(m.video));
  }
  void operator()(const FrameHeader& m) const {
    out.u32(m.frame);
    out.u8(static_cast<std::uint8_t>((m.iFrame ? 1 : 0) | (m.atlasReset ? 2 : 0)));
    pad(out, 3);
    out.u32(m.pose);
    out.f64(m.time);
    out.f32(m.background);
    write(out, m.camera);
    out.u32(static_cast<std::uint32_t>(m.lights.size()));
    for (const SentLight& light : m.lights) {
      out.u8(static_cast<std::uint8_t>(light.type));
      pad(out, 3);
      for (const glm::vec3& v : {light.position, light.direction, light.radiance}) write(out, v);
      for (const float v : {light.range, light.innerCone, light.outerCone}) out.f32(v);
    }
  }
  void operator()(const Geometry& m) const {
    out.u32(m.frame);
    out.raw(m.changes);
  }
  void operator()(const MaskImage& m) const {
    out.u16(m.number);
    out.u16(0);
    out.u32(m.width);
    out.u32(m.height);
    out.u8(static_cast<std::uint8_t>(m.across));
    out.u8(static_cast<std::uint8_t>(m.up));
    pad(out, 2);
    out.f32(m.cutoff);
    const std::vector<std::uint8_t> packed = pack(m.alpha);
    out.u32(static_cast<std::uint32_t>(packed.size()));
    out.raw(packed);
  }
  void operator()(const Path& m) const {
    out.u32(static_cast<std::uint32_t>(m.keys.size()));
    for (const PathKey& key : m.keys) {
      out.f64(key.time);
      for (const glm::dvec3& v : {key.eye, key.target})
        for (int i = 0; i < 3; ++i) out.f64(v[i]);
      out.f64(key.fovY);
    }
    out.text(cut(m.name));
  }
  void operator()(const Acknowledge& m) const {
    out.u32(m.geometryFrame);
    out.u32(m.atlasFrame);
    out.f64(m.time);
  }
  void operator()(const Pose& m) const {
    out.u32(m.number);
    out.u32(0);
    out.f64(m.time);
    write(out, m.camera);
  }
  void operator()(const AskIFrame& m) const { out.u32(m.lastFrame); }
};

// Reads values and remembers the first one that is none.
class Checked {
 public:
  Checked(Kind kind, std::span<const std::uint8_t> body) : in(body), kind_(kind) {}
  ByteReader in;

  template <class Value>
  void refuse(const char* what, const Value& value) {
    if (wrong_.empty()) wrong_ = fmt::format("{}: {} as {}", nameOf(kind_), value, what);
  }
  /// An enumeration from 1 to `last`.
  template <class Enum>
  Enum oneOf(const char* what, Enum last) {
    const std::uint8_t value = in.u8();
    if (value < 1 || value > static_cast<std::uint8_t>(last)) refuse(what, int{value});
    return static_cast<Enum>(value);
  }
  double finite(const char* what) { return checked(what, in.f64()); }
  float finite32(const char* what) { return checked(what, in.f32()); }
  void zero(int count) {
    for (int i = 0; i < count; ++i)
      if (const std::uint8_t value = in.u8(); value != 0) refuse("a byte that is to be zero", int{value});
  }
  std::uint32_t between(const char* what, std::uint32_t least, std::uint32_t most) {
    const std::uint32_t value = in.u32();
    if (value < least || value > most) refuse(what, value);
    return value;
  }
  Versions versions() {
    Versions v;
    v.oldest = in.u16();
    v.newest = in.u16();
    if (v.oldest == 0 || v.oldest > v.newest) refuse("oldest version", v.oldest);
    return v;
  }
  glm::vec3 vector(const char* what) {
    glm::vec3 v;
    for (int i = 0; i < 3; ++i) v[i] = finite32(what);
    return v;
  }
  Camera camera() {
    Camera c;
    for (int i = 0; i < 3; ++i) c.eye[i] = finite("eye");
    for (int i = 0; i < 4; ++i) c.orientation[i] = finite("orientation");
    for (int i = 0; i < 4; ++i) c.slopes[i] = finite("slope");
    c.zNear = finite("near plane");
    c.width = between("width of a picture", 1, 65535);
    c.height = between("height of a picture", 1, 65535);
    const double length = glm::dot(c.orientation, c.orientation);
    if (!(std::abs(length - 1.0) < 1e-3)) refuse("squared length of an orientation", length);
    if (!(c.slopes.x < c.slopes.y) || !(c.slopes.z < c.slopes.w)) refuse("left or bottom slope", c.slopes.x);
    if (!(c.zNear > 0.0)) refuse("near plane", c.zNear);
    return c;
  }
  PathKey pathKey() {
    PathKey key;
    key.time = finite("time of a key");
    for (int i = 0; i < 3; ++i) key.eye[i] = finite("eye");
    for (int i = 0; i < 3; ++i) key.target[i] = finite("target");
    key.fovY = finite("angle of view");
    if (key.eye == key.target) refuse("target and eye on axis x alike", key.eye.x);
    if (!(key.fovY > 0.0 && key.fovY < 180.0)) refuse("angle of view", key.fovY);
    return key;
  }
  template <class M>
  Result<Message> done(M&& message) {
    if (in.failed()) return fail("{}: it ends early", nameOf(kind_));
    if (in.left() > 0) return fail("{}: {} bytes too many", nameOf(kind_), in.left());
    if (!wrong_.empty()) return fail("{}", wrong_);
    return Message(std::forward<M>(message));
  }

 private:
  template <class T>
  T checked(const char* what, T value) {
    if (!std::isfinite(value)) refuse(what, value);
    return value;
  }
  Kind kind_;
  std::string wrong_;
};

}  // namespace

std::string nameOf(Kind kind) {
  const KindEntry* entry = entryOf(kind);
  return entry != nullptr ? entry->name : fmt::format("unknown ({})", static_cast<int>(kind));
}
bool known(Kind kind) { return entryOf(kind) != nullptr; }
std::size_t mostBytes(Kind kind) {
  const KindEntry* entry = entryOf(kind);
  return entry != nullptr ? entry->most : 0;
}

bool sends(Role role, Kind kind) {
  switch (kind) {
    case Kind::Hello:
    case Kind::Refusal:
      return true;
    case Kind::Setup:
    case Kind::Frame:
    case Kind::Geometry:
    case Kind::Mask:
    case Kind::Path:
      return role == Role::Server;
    case Kind::Acknowledge:
    case Kind::Pose:
    case Kind::AskIFrame:
      return role == Role::Viewer;
  }
  return false;
}

Kind kindOf(const Message& message) { return kKinds[message.index()].kind; }

Result<std::vector<std::uint8_t>> encode(const Message& message) {
  ByteWriter body;
  std::visit(Writer{body}, message);
  const Kind kind = kindOf(message);
  if (body.bytes().size() > mostBytes(kind))
    return fail("{}: its {} bytes are more than {}", nameOf(kind), body.bytes().size(), mostBytes(kind));
  ByteWriter out;
  out.u32(static_cast<std::uint32_t>(body.bytes().size()));
  out.u8(static_cast<std::uint8_t>(kind));
  pad(out, 3);
  out.raw(body.bytes());
  return out.take();
}

Result<Message> decode(Kind kind, std::span<const std::uint8_t> body) {
  if (!known(kind)) return fail("message of kind {}: there is none", static_cast<int>(kind));
  if (body.size() > mostBytes(kind))
    return fail("{}: its {} bytes are more than {}", nameOf(kind), body.size(), mostBytes(kind));
  Checked c(kind, body);
  switch (kind) {
    case Kind::Hello: {
      Hello m;
      if (const std::uint32_t magic = c.in.u32(); magic != kMagic)
        c.refuse("the number that a hello starts with", magic);
      m.versions = c.versions();
      m.role = c.oneOf("role", Role::Viewer);
      m.token = c.in.text();
      return c.done(std::move(m));
    }
    case Kind::Refusal: {
      Refusal m;
      m.reason = c.oneOf("reason", RefusalReason::Closing);
      m.versions = c.versions();
      m.why = c.in.text();
      return c.done(std::move(m));
    }
    case Kind::Setup: {
      StreamSetup m;
      m.version = c.in.u16();
      m.method = c.oneOf("method", Method::Tess);
      m.chroma = c.oneOf("chroma", Chroma::C444);
      m.matrix = c.oneOf("matrix", Matrix::Bt709);
      const std::uint8_t range = c.in.u8();
      if (range > 1) c.refuse("full range", int{range});
      m.fullRange = range == 1;
      m.paths = c.in.u16();
      if (m.paths > kMostPaths) c.refuse("number of paths", m.paths);
      m.width = c.between("width of the atlas", 1, 32767);
      m.height = c.between("height of the atlas", 1, 65535);
      m.fpsNumerator = c.between("numerator of the frame rate", 1, 1000000);
      m.fpsDenominator = c.between("denominator of the frame rate", 1, 1000000);
      m.start = c.camera();
      m.video = c.in.text();
      return c.done(std::move(m));
    }
    case Kind::Frame: {
      FrameHeader m;
      m.frame = c.between("number of a frame", 1, 0xffffffffu);
      const std::uint8_t flags = c.in.u8();
      if (flags > 3) c.refuse("flags", int{flags});
      m.iFrame = (flags & 1) != 0;
      m.atlasReset = (flags & 2) != 0;
      c.zero(3);
      m.pose = c.in.u32();
      m.time = c.finite("time");
      m.background = c.finite32("share of the background");
      if (!(m.background >= 0.0f && m.background <= 1.0f)) c.refuse("share of the background", m.background);
      m.camera = c.camera();
      const std::uint32_t lights = c.between("number of lights", 0, kMostLights);
      for (std::uint32_t i = 0; i < lights && !c.in.failed(); ++i) {
        SentLight light;
        light.type = c.oneOf("type of a light", FrameLight::Spot);
        c.zero(3);
        light.position = c.vector("position of a light");
        light.direction = c.vector("direction of a light");
        light.radiance = c.vector("radiance of a light");
        light.range = c.finite32("range of a light");
        light.innerCone = c.finite32("inner cone of a light");
        light.outerCone = c.finite32("outer cone of a light");
        m.lights.push_back(light);
      }
      return c.done(std::move(m));
    }
    case Kind::Geometry: {
      Geometry m;
      m.frame = c.between("number of a frame", 1, 0xffffffffu);
      const auto changes = c.in.raw(c.in.left());
      m.changes.assign(changes.begin(), changes.end());
      return c.done(std::move(m));
    }
    case Kind::Mask: {
      MaskImage m;
      m.number = c.in.u16();
      c.zero(2);
      m.width = c.between("width of a mask", 1, kMostMaskSide);
      m.height = c.between("height of a mask", 1, kMostMaskSide);
      m.across = c.oneOf("wrap", Wrap::Mirror);
      m.up = c.oneOf("wrap", Wrap::Mirror);
      c.zero(2);
      m.cutoff = c.finite32("cutoff");
      const std::uint32_t packed = c.in.u32();
      const auto bytes = c.in.raw(packed);
      if (c.in.failed()) return c.done(std::move(m));  // says so
      m.alpha = unpack(bytes, std::size_t{m.width} * m.height);
      if (m.alpha.empty()) c.refuse("bytes of alpha that are not those of its size", bytes.size());
      return c.done(std::move(m));
    }
    case Kind::Path: {
      Path m;
      const std::uint32_t keys = c.between("number of keys", 1, kMostPathKeys);
      for (std::uint32_t i = 0; i < keys && !c.in.failed(); ++i) m.keys.push_back(c.pathKey());
      for (std::size_t i = 1; i < m.keys.size(); ++i)
        if (!(m.keys[i].time > m.keys[i - 1].time)) c.refuse("time of a key after another", m.keys[i].time);
      m.name = c.in.text();
      return c.done(std::move(m));
    }
    case Kind::Acknowledge: {
      Acknowledge m;
      m.geometryFrame = c.in.u32();
      m.atlasFrame = c.in.u32();
      m.time = c.finite("time");
      return c.done(m);
    }
    case Kind::Pose: {
      Pose m;
      m.number = c.between("number of a pose", 1, 0xffffffffu);
      c.zero(4);
      m.time = c.finite("time");
      m.camera = c.camera();
      return c.done(m);
    }
    case Kind::AskIFrame:
      return c.done(AskIFrame{c.in.u32()});
  }
  return fail("message of kind {}: there is none", static_cast<int>(kind));
}

}  // namespace tessera::wire
