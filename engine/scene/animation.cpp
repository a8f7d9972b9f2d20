// Node animation: glTF 2.0 sec. 3.11 and appendix C (interpolation modes), evaluated in double.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/gtc/quaternion.hpp>

#include "engine/scene/scene.hpp"

namespace tessera {
namespace {

struct Pose {
  glm::dvec3 translation;
  glm::dquat rotation;
  glm::dvec3 scale;
};

/// `time` wrapped into [0, duration).
double loopTime(double time, double duration) {
  if (!(duration > 0.0)) return 0.0;
  const double wrapped = std::fmod(time, duration);
  return wrapped < 0.0 ? wrapped + duration : wrapped;
}

glm::dquat toQuaternion(const glm::dvec4& v) { return {v.w, v.x, v.y, v.z}; }

/// Unit length; the identity where there is no direction to keep, as when cubic tangents cancel the values.
glm::dquat normalised(const glm::dquat& q) {
  const double length = glm::length(q);
  return length > 1e-12 ? q / length : glm::dquat(1.0, 0.0, 0.0, 0.0);
}

/// Cubic Hermite between v0 and v1; the tangents are derivatives over time, so they scale with the interval.
glm::dvec4 hermite(const glm::dvec4& v0, const glm::dvec4& out0, const glm::dvec4& in1, const glm::dvec4& v1,
                   double interval, double s) {
  const double s2 = s * s;
  const double s3 = s2 * s;
  return (2.0 * s3 - 3.0 * s2 + 1.0) * v0 + interval * (s3 - 2.0 * s2 + s) * out0 +
         (3.0 * s2 - 2.0 * s3) * v1 + interval * (s3 - s2) * in1;
}

glm::dvec4 keyValue(const AnimationChannel& channel, std::size_t key) {
  return channel.interpolation == Interpolation::Cubic ? channel.values[3 * key + 1] : channel.values[key];
}

/// The channel's value at `time`, held before the first and after the last key. Rotations come back unit
/// length.
glm::dvec4 sampleChannel(const AnimationChannel& channel, double time) {
  const auto next = std::ranges::upper_bound(channel.times, time, {}, [](float t) { return double{t}; });
  if (next == channel.times.begin()) return keyValue(channel, 0);
  const auto key = static_cast<std::size_t>(next - channel.times.begin()) - 1;
  if (next == channel.times.end() || channel.interpolation == Interpolation::Step)
    return keyValue(channel, key);

  const double interval = double{channel.times[key + 1]} - double{channel.times[key]};
  const double s = (time - double{channel.times[key]}) / interval;
  if (channel.interpolation == Interpolation::Cubic) {
    return hermite(channel.values[3 * key + 1], channel.values[3 * key + 2], channel.values[3 * key + 3],
                   channel.values[3 * key + 4], interval, s);
  }
  const glm::dvec4 v0 = channel.values[key];
  const glm::dvec4 v1 = channel.values[key + 1];
  if (channel.property != AnimatedProperty::Rotation) return glm::mix(v0, v1, s);
  // glm::slerp takes the shorter way and falls back to a straight line for nearly equal ends.
  const glm::dquat q = glm::slerp(normalised(toQuaternion(v0)), normalised(toQuaternion(v1)), s);
  return {q.x, q.y, q.z, q.w};
}

void apply(const AnimationChannel& channel, double time, Pose& pose) {
  if (channel.times.empty()) return;
  const glm::dvec4 value = sampleChannel(channel, time);
  switch (channel.property) {
    case AnimatedProperty::Translation:
      pose.translation = glm::dvec3(value);
      break;
    case AnimatedProperty::Rotation:
      pose.rotation = normalised(toQuaternion(value));
      break;
    case AnimatedProperty::Scale:
      pose.scale = glm::dvec3(value);
      break;
  }
}

glm::dmat4 toMatrix(const Pose& pose) {
  const glm::dmat3 rotation = glm::mat3_cast(pose.rotation);
  return {glm::dvec4(rotation[0] * pose.scale.x, 0.0), glm::dvec4(rotation[1] * pose.scale.y, 0.0),
          glm::dvec4(rotation[2] * pose.scale.z, 0.0), glm::dvec4(pose.translation, 1.0)};
}

}  // namespace

void evaluate(const Scene& scene, double time, SceneState& state) {
  std::vector<Pose> poses;
  poses.reserve(scene.nodes.size());
  for (const Node& node : scene.nodes) poses.push_back({node.translation, node.rotation, node.scale});
  for (const Animation& animation : scene.animations) {
    const double local = loopTime(time, animation.duration);
    for (const AnimationChannel& channel : animation.channels) apply(channel, local, poses[channel.node]);
  }

  state.time = time;
  state.world.resize(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    const glm::dmat4 local = node.hasMatrix ? node.matrix : toMatrix(poses[i]);
    state.world[i] = node.parent == kNone ? local : state.world[node.parent] * local;
  }
}

std::vector<bool> movingNodes(const Scene& scene) {
  std::vector<bool> moving(scene.nodes.size(), false);
  for (const Animation& animation : scene.animations) {
    for (const AnimationChannel& channel : animation.channels) moving[channel.node] = true;
  }
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const std::uint32_t parent = scene.nodes[i].parent;
    if (parent != kNone && moving[parent]) moving[i] = true;
  }
  return moving;
}

bool Scene::animated() const {
  const std::vector<bool> moving = movingNodes(*this);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = nodes[i];
    const bool carries = node.mesh != kNone || node.light != kNone || node.camera != kNone;
    if (moving[i] && carries) return true;
  }
  return false;
}

}  // namespace tessera
