// Regions of interest. No libavcodec.
#pragma once

namespace tessera {

/// A part of the picture whose errors count more or less than others'.
struct Region {
  int x = 0;  // texels, within the picture
  int y = 0;
  int width = 0;
  int height = 0;
  /// What a squared error there counts, against one where no region is, [1/64, 64]. The quantizer moves by
  /// -3 log2 of it: a squared error doubles with every three steps (its step doubles with six).
  double importance = 1.0;
};

}  // namespace tessera
