// The pictures that everything is compared with: forward's of each frame, of one eye or two, as they are and
// behind the lens.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "apps/tessera/compare/drawing.hpp"

namespace tessera::app {

class References {
 public:
  /// Finds out which of `methods` look through a lens: theirs are the pictures behind it that references
  /// need.
  explicit References(std::span<const Method> methods);

  /// The lens behind which this method's pictures are wanted too; none for a method that is no reference.
  [[nodiscard]] std::optional<Lens> lensFor(const Method& method) const;
  /// Keeps what a reference method has drawn of a frame; of other methods nothing.
  void keep(const Method& method, std::size_t frame, const Drawn& drawn);
  /// What a method's pictures of a frame are compared with, an eye each; empty where no reference was kept.
  [[nodiscard]] const std::vector<Image>& of(const Method& method, std::size_t frame) const;

 private:
  std::map<bool, Lens> lenses_;                                                // by whether it is for stereo
  std::map<std::pair<bool, bool>, std::vector<std::vector<Image>>> pictures_;  // stereo, lens: by frame, eye
};

}  // namespace tessera::app
