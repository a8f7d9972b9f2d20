// Node animations: key times and values, checked.
#include <algorithm>
#include <cmath>

#include "engine/scene/gltf_build.hpp"

namespace tessera {
namespace {

struct Property {
  const char* path;
  AnimatedProperty property;
  int type;  // of the output accessor
};

constexpr Property kProperties[] = {{"translation", AnimatedProperty::Translation, TINYGLTF_TYPE_VEC3},
                                    {"rotation", AnimatedProperty::Rotation, TINYGLTF_TYPE_VEC4},
                                    {"scale", AnimatedProperty::Scale, TINYGLTF_TYPE_VEC3}};

Interpolation toInterpolation(const std::string& name) {
  if (name == "STEP") return Interpolation::Step;
  return name == "CUBICSPLINE" ? Interpolation::Cubic : Interpolation::Linear;
}

Result<std::vector<float>> readTimes(const GltfInput& input, const std::string& what, int accessor) {
  const tinygltf::Accessor& description = input.accessors.description(accessor);
  if (description.type != TINYGLTF_TYPE_SCALAR || description.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
    return fail("{}: input accessor {} is not of float scalars", what, accessor);
  std::vector<float> times = input.accessors.floats(accessor);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || times[i] < 0.0f) return fail("{}: time {} is {}", what, i, times[i]);
  }
  return times;
}

/// Rotations may be stored as normalized integers, the others are floats (glTF 2.0 sec. 3.11).
bool validOutput(const tinygltf::Accessor& accessor, const Property& property) {
  if (accessor.type != property.type) return false;
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) return true;
  return property.property == AnimatedProperty::Rotation && accessor.normalized &&
         accessor.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

Result<std::vector<glm::vec4>> readValues(const GltfInput& input, const std::string& what, int accessor,
                                          const Property& property, Interpolation interpolation,
                                          std::size_t keys) {
  const tinygltf::Accessor& description = input.accessors.description(accessor);
  if (!validOutput(description, property))
    return fail("{}: output accessor {} does not hold a {}", what, accessor, property.path);
  const std::size_t perKey = interpolation == Interpolation::Cubic ? 3 : 1;
  if (description.count != keys * perKey)
    return fail("{}: output accessor {} has {} values for {} times", what, accessor, description.count, keys);
  const std::vector<float> floats = input.accessors.floats(accessor);
  const std::size_t width = input.accessors.components(accessor);
  std::vector<glm::vec4> values(description.count, glm::vec4(0.0f));
  for (std::size_t i = 0; i < floats.size(); ++i) {
    if (!std::isfinite(floats[i])) return fail("{}: value {} is {}", what, i / width, floats[i]);
    values[i / width][static_cast<int>(i % width)] = floats[i];
  }
  if (property.property == AnimatedProperty::Rotation)
    for (std::size_t i = perKey / 2; i < values.size(); i += perKey)
      if (glm::length(values[i]) < 1e-6f) return fail("{}: rotation {} has length 0", what, i);
  return values;
}

/// Removes keys that are not after the one before; returns whether there were any. Exporters write a time
/// twice.
bool dropUnorderedKeys(AnimationChannel& channel) {
  const std::size_t perKey = channel.values.size() / channel.times.size();
  std::size_t kept = 1;
  for (std::size_t i = 1; i < channel.times.size(); ++i) {
    if (channel.times[i] <= channel.times[kept - 1]) continue;
    channel.times[kept] = channel.times[i];
    for (std::size_t k = 0; k < perKey; ++k)
      channel.values[kept * perKey + k] = channel.values[i * perKey + k];
    ++kept;
  }
  const bool dropped = kept < channel.times.size();
  channel.times.resize(kept);
  channel.values.resize(kept * perKey);
  return dropped;
}

class AnimationBuilder {
 public:
  AnimationBuilder(const GltfInput& input, const std::vector<std::uint32_t>& nodes, const Scene& scene)
      : input_(input), nodes_(nodes), scene_(scene) {}

  Result<Animation> build(std::size_t index) const {
    const tinygltf::Animation& in = input_.model.animations[index];
    Animation out;
    out.name = in.name.empty() ? fmt::format("animation {}", index) : printable(in.name);
    for (std::size_t c = 0; c < in.channels.size(); ++c) {
      if (auto ok = addChannel(in, fmt::format("animation {}, channel {}", index, c), in.channels[c], out);
          !ok)
        return tl::unexpected(ok.error());
    }
    return out;
  }

 private:
  Result<void> addChannel(const tinygltf::Animation& in, const std::string& element,
                          const tinygltf::AnimationChannel& channel, Animation& out) const {
    const std::string what = fmt::format("{}: {}", input_.file, element);
    if (static_cast<std::size_t>(channel.sampler) >= in.samplers.size())
      return fail("{}: sampler {} is past {} samplers", what, channel.sampler, in.samplers.size());
    const auto* property = std::ranges::find(kProperties, channel.target_path, &Property::path);
    if (property == std::end(kProperties)) {
      input_.warnings.add(fmt::format("animation of '{}' is not applied", printable(channel.target_path)),
                          element);
      return {};
    }
    const tinygltf::AnimationSampler& sampler = in.samplers[static_cast<std::size_t>(channel.sampler)];
    AnimationChannel made;
    made.property = property->property;
    made.interpolation = toInterpolation(sampler.interpolation);
    auto times = readTimes(input_, what, sampler.input);
    if (!times) return tl::unexpected(times.error());
    made.times = std::move(*times);
    auto values = readValues(input_, what, sampler.output, *property, made.interpolation, made.times.size());
    if (!values) return tl::unexpected(values.error());
    made.values = std::move(*values);
    if (dropUnorderedKeys(made))
      input_.warnings.add("keys that are not after the one before are left out", element);
    place(channel.target_node, element, std::move(made), out);
    return {};
  }

  /// Adds the channel if its node is drawn and free to move.
  void place(int target, const std::string& element, AnimationChannel made, Animation& out) const {
    made.node = nodes_[static_cast<std::size_t>(target)];
    if (made.node == kNone) return;
    if (scene_.nodes[made.node].hasMatrix) {
      input_.warnings.add("a node with a matrix is not animated", element);
      return;
    }
    const auto same = [&](const AnimationChannel& other) {
      return other.node == made.node && other.property == made.property;
    };
    if (std::ranges::any_of(out.channels, same)) {
      input_.warnings.add("a second channel for the same property is not applied", element);
      return;
    }
    out.duration = std::max(out.duration, double{made.times.back()});
    out.channels.push_back(std::move(made));
  }

  const GltfInput& input_;
  const std::vector<std::uint32_t>& nodes_;
  const Scene& scene_;
};

}  // namespace

Result<void> buildAnimations(const GltfInput& input, const std::vector<std::uint32_t>& nodes, Scene& scene) {
  const AnimationBuilder builder(input, nodes, scene);
  for (std::size_t i = 0; i < input.model.animations.size(); ++i) {
    auto animation = builder.build(i);
    if (!animation) return tl::unexpected(animation.error());
    if (!animation->channels.empty()) scene.animations.push_back(std::move(*animation));
  }
  return {};
}

}  // namespace tessera
