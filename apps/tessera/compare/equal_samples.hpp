// Biases by which other methods shade as many samples as rect does.
#pragma once

#include <vector>

#include "apps/tessera/compare/method.hpp"

namespace tessera::app {

/// What others are given as many samples as: the first that fills rectangles for one view; null if none does.
const Method* samplesReference(const std::vector<Method>& methods);

/// Sets the constant bias of each method that fills an atlas for one view, but for the reference's, so that
/// it places as many samples as that one does, within a tenth, over some of the views; names it in the
/// method's name, and prints what came of it: the nearest bias in [-8, 16] where none comes so near. Nothing
/// is shaded for this. Fails where a frame cannot be placed.
Result<void> equalizeSamples(Engine& engine, const std::vector<TimedView>& views, int warmup,
                             std::vector<Method>& methods);

}  // namespace tessera::app
