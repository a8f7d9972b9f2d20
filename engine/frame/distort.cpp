// The display through a lens.
#include "engine/frame/engine_state.hpp"

namespace tessera {

Result<void> Engine::distort(const Lens& lens) {
  State& s = *s_;
  if (auto good = check(lens); !good) return good;
  if (!s.distort) return fail("{}: the plan has no pass that draws through a lens", s.scene.file);
  if (!s.picture.color) return fail("{}: no picture was drawn yet to see through a lens", s.scene.file);
  const auto guard = s.guard();
  s.distorted.resize(s.picture.color.width(), s.picture.color.height(), nullptr);
  s.pass("distort", [&] { s.distort->draw(s.picture.color, s.distorted.encoded, lens); });
  State::afterPictureStore();
  s.throughLens = true;
  return {};
}

}  // namespace tessera
