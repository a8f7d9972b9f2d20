#include "engine/lens/lens.hpp"

#include <algorithm>
#include <cmath>

#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

constexpr double kLargestK = 10.0;
constexpr double kLeastSlope =
    0.01;  // picture per output radius; flatter, and float32 cannot invert it to 1e-5

/// The least slope of d (1 + k1 d^2 + k2 d^4) over d in 0..1: at an end, or where its own slope in d^2 is 0.
double leastSlope(const Lens& lens) {
  const auto slope = [&](double square) { return 1.0 + square * (3.0 * lens.k1 + 5.0 * lens.k2 * square); };
  double least = std::min(1.0, slope(1.0));
  if (lens.k2 > 0.0) least = std::min(least, slope(std::clamp(-0.3 * lens.k1 / lens.k2, 0.0, 1.0)));
  return least;
}

double largestChannel(const Lens& lens) {
  return std::max({lens.channelScale.x, lens.channelScale.y, lens.channelScale.z});
}

}  // namespace

Result<void> check(const Lens& lens) {
  for (const auto& [name, value] : {std::pair{"k1", lens.k1}, std::pair{"k2", lens.k2}})
    if (!(std::abs(value) <= kLargestK))
      return fail("lens: {} {} is outside [-{}, {}]", name, value, kLargestK, kLargestK);
  for (int i = 0; i < 3; ++i)
    if (!(lens.channelScale[i] >= 0.5 && lens.channelScale[i] <= 2.0))
      return fail("lens: scale {} of channel {} is outside [0.5, 2]", lens.channelScale[i], i);
  if (leastSlope(lens) < kLeastSlope)
    return fail("lens: k1 {}, k2 {} fold the picture: d (1 + k1 d^2 + k2 d^4) does not rise over 0..1",
                lens.k1, lens.k2);
  return {};
}

double lensFill(const Lens& lens) { return (1.0 + lens.k1 + lens.k2) * largestChannel(lens); }

Result<LensPass> LensPass::create(gl::ProgramCache& programs) {
  auto program = programs.get({"pass/distort.comp"});
  if (!program) return tl::unexpected(program.error());
  LensPass pass;
  pass.program_ = *program;
  return pass;
}

void LensPass::draw(const gl::Texture& picture, const gl::Texture& encoded, const Lens& lens) const {
  program_->use();
  picture.bind(UNIT_PICTURE);
  gl::api().BindImageTexture(0, encoded.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
  const glm::vec3 numbers(lens.k1, lens.k2, lensFill(lens));
  const glm::vec3 channels(lens.channelScale);
  gl::api().ProgramUniform3fv(program_->get(), LOCATION_LENS, 1, &numbers.x);
  gl::api().ProgramUniform3fv(program_->get(), LOCATION_CHANNELS, 1, &channels.x);
  gl::dispatchOver(picture.width(), picture.height());
}

}  // namespace tessera
