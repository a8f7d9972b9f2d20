#include "apps/tessera/compare/references.hpp"

#include <algorithm>

namespace tessera::app {

References::References(std::span<const Method> methods) {
  // Only one lens can be asked for: --lens, or the default.
  for (const Method& method : methods)
    if (method.spatial.options.lens) lenses_.insert({method.isStereo(), *method.spatial.options.lens});
}

std::optional<Lens> References::lensFor(const Method& method) const {
  const auto found = lenses_.find(method.isStereo());
  if (!method.isReference() || found == lenses_.end()) return std::nullopt;
  return found->second;
}

void References::keep(const Method& method, std::size_t frame, const Drawn& drawn) {
  if (!method.isReference()) return;
  for (const bool lens : {false, true}) {
    auto& frames = pictures_[{method.isStereo(), lens}];
    frames.resize(std::max(frames.size(), frame + 1));
    frames[frame] = lens ? drawn.behindLens : drawn.pictures;
  }
}

const std::vector<Image>& References::of(const Method& method, std::size_t frame) const {
  static const std::vector<Image> kNone;
  const auto found = pictures_.find({method.isStereo(), method.spatial.options.lens.has_value()});
  return found == pictures_.end() || frame >= found->second.size() ? kNone : found->second[frame];
}

}  // namespace tessera::app
