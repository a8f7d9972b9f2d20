// Every message of the meta channel, and how it lies in bytes. All numbers are little-endian, floats IEEE
// 754, texts a u16 length and UTF-8 bytes. `frame` numbers count up from 1; 0 is none yet.
//
//   header          u32 bytes that follow it, u8 kind, u8[3] zero
//   1 hello         u32 kMagic, u16 oldest, u16 newest version spoken, u8 role, text token
//   2 refusal       u8 reason, u16 oldest, u16 newest version that the refusing side speaks, text why
//   3 setup         u16 version, u8 method, u8 chroma, u8 matrix, u8 full range, u16 paths, u32 atlas width,
//                   height, u32 fps numerator, denominator, start camera, text video
//   4 frame         u32 frame, u8 flags, u8[3] zero, u32 pose, f64 time, camera, u32 lights, then each:
//                   u8 type, u8[3] zero, f32[3] position, f32[3] direction, f32[3] radiance, f32 range,
//                   f32 inner, f32 outer cone
//   5 geometry      u32 frame, then what VisibleDelta::next gives
//   6 mask          u16 number, u16 zero, u32 width, height, u8 wrap across, up, u8[2] zero, f32 cutoff,
//                   u8[width * height] alpha, rows from the top
//   7 path          u32 keys, then each: f64 time, f64[3] eye, f64[3] target, f64 angle; text name
//   16 acknowledge  u32 geometry frame, u32 atlas frame, f64 the viewer's time
//   17 pose         u32 number, u32 zero, f64 the viewer's time, camera
//   18 ask for an I-frame   u32 last atlas frame that decoded
//   camera          f64[3] eye, f64[4] orientation, f64[4] slopes, f64 near, u32 width, height: 104 bytes
//
// 1 and 2 go both ways, 3 to 7 to the viewer, 16 to 18 to the server.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "codec/wire/geometry.hpp"
#include "codec/wire/versions.hpp"
#include "engine/core/result.hpp"

namespace tessera::wire {

inline constexpr std::uint32_t kMagic = 0x41525354;  // "TSRA" as it lies in bytes
inline constexpr std::size_t kHeaderBytes = 8;
inline constexpr std::size_t kMostTextBytes = 4096;
inline constexpr std::size_t kMostLights = 256;
inline constexpr std::uint32_t kMostMaskSide = 4096;
inline constexpr std::size_t kMostPaths = 256;
inline constexpr std::size_t kMostPathKeys = 100'000;

enum class Kind : std::uint8_t {
  Hello = 1,
  Refusal = 2,
  Setup = 3,
  Frame = 4,
  Geometry = 5,
  Mask = 6,
  Path = 7,
  Acknowledge = 16,
  Pose = 17,
  AskIFrame = 18
};
/// "hello", or "unknown (7)".
std::string nameOf(Kind kind);
bool known(Kind kind);
/// Bytes that a message of this kind may have after its header.
std::size_t mostBytes(Kind kind);

enum class Role : std::uint8_t { Server = 1, Viewer = 2 };
/// Whether a side of this role may send messages of this kind at all.
bool sends(Role role, Kind kind);

struct Hello {
  Versions versions;
  Role role = Role::Viewer;
  std::string token;  // empty where none is asked for
};

enum class RefusalReason : std::uint8_t {
  Version = 1,
  Token = 2,
  Role = 3,
  Protocol = 4,
  Busy = 5,
  Closing = 6
};
struct Refusal {
  RefusalReason reason = RefusalReason::Protocol;
  Versions versions;
  std::string why;  // one line for a user
};

enum class Chroma : std::uint8_t { C420 = 1, C444 = 2 };
enum class Matrix : std::uint8_t { Bt601 = 1, Bt709 = 2 };
struct StreamSetup {
  std::uint16_t version = 1;  // spoken from here on
  Method method = Method::Rect;
  Chroma chroma = Chroma::C420;
  Matrix matrix = Matrix::Bt709;
  bool fullRange = false;
  std::uint32_t width = 0;  // of the atlas texture, see AtlasSize
  std::uint32_t height = 0;
  std::uint32_t fpsNumerator = 30;  // > 0
  std::uint32_t fpsDenominator = 1;
  std::uint16_t paths = 0;  // [0, kMostPaths]; so many Path messages come before the first frame
  Camera start;             // where a viewer begins that was not told another place
  std::string video;        // how the video is reached: a session description (RFC 8866)
};

enum class FrameLight : std::uint8_t { Directional = 1, Point = 2, Spot = 3 };
struct SentLight {
  FrameLight type = FrameLight::Point;
  glm::vec3 position{0.0f};                // relative to the camera's eye
  glm::vec3 direction{0.0f, 0.0f, -1.0f};  // the way light travels
  glm::vec3 radiance{0.0f};                // linear
  float range = 0.0f;                      // 0: unlimited
  float innerCone = 0.0f;                  // radians
  float outerCone = 0.0f;
};
/// What a frame of the atlas was shaded for.
struct FrameHeader {
  std::uint32_t frame = 0;
  bool iFrame = false;      // the atlas frame of this number is one
  bool atlasReset = false;  // every place may have moved
  /// Number of the newest Pose of the viewer that is told, of those that the frame was made from; 0: of none.
  std::uint32_t pose = 0;
  double time = 0.0;  // the scene's, seconds
  /// Of the pixels of the views that the frame was made for, the share that shows nothing, [0, 1].
  float background = 0.0f;
  Camera camera;
  std::vector<SentLight> lights;  // at most kMostLights
};

struct Geometry {
  std::uint32_t frame = 0;
  std::vector<std::uint8_t> changes;  // for VisibleMirror::apply
};

enum class Wrap : std::uint8_t { Repeat = 1, Clamp = 2, Mirror = 3 };
/// Alpha of a material. Of a masked one what is below the cutoff is a hole; of elements that are also blended
/// (kStyleTransparent) it is the share that they cover, and nothing reads the cutoff.
struct MaskImage {
  std::uint16_t number = 0;  // see styleMask in glsl/shared/streamed.h
  std::uint32_t width = 0;   // [1, kMostMaskSide]
  std::uint32_t height = 0;
  Wrap across = Wrap::Repeat;
  Wrap up = Wrap::Repeat;
  float cutoff = 0.5f;
  std::vector<std::uint8_t> alpha;  // width x height, rows from the top; sent packed by zstd
};

/// Where a camera is at a time of its path.
struct PathKey {
  double time = 0.0;  // seconds
  glm::dvec3 eye{0.0};
  glm::dvec3 target{0.0, 0.0, -1.0};  // another point than the eye
  double fovY = 60.0;                 // degrees, (0, 180)
};
/// A flight that the server's stage has, for a viewer to choose by its name.
struct Path {
  std::string name;
  std::vector<PathKey> keys;  // [1, kMostPathKeys], their times rise
};

struct Acknowledge {
  std::uint32_t geometryFrame = 0;
  std::uint32_t atlasFrame = 0;
  double time = 0.0;  // seconds of the viewer's clock
};
struct Pose {
  std::uint32_t number = 0;
  double time = 0.0;  // seconds of the viewer's clock, when it was taken
  Camera camera;
};
struct AskIFrame {
  std::uint32_t lastFrame = 0;
};

using Message = std::variant<Hello, Refusal, StreamSetup, FrameHeader, Geometry, MaskImage, Path, Acknowledge,
                             Pose, AskIFrame>;
Kind kindOf(const Message& message);

/// Header and body. A text past kMostTextBytes is cut there. Fails where the body would be past mostBytes():
/// a message that the other side would refuse is never sent.
Result<std::vector<std::uint8_t>> encode(const Message& message);
/// A body without its header. Fails for one that is too short or too long, and for any value that is none.
Result<Message> decode(Kind kind, std::span<const std::uint8_t> body);

}  // namespace tessera::wire
