// RGB to the luma and chroma of video and back: BT.709 (ITU-R BT.709-6, sec. 3), full range, 8 bits a value, on
// display-encoded values. Integers throughout: BT.709's weights have four decimals, so every value is a fraction
// with a known denominator, and what is given is that fraction rounded to the nearest integer, halves up.
// A round trip without subsampling is off by at most 1.
#ifndef TESSERA_GLSL_SHARED_YUV_H
#define TESSERA_GLSL_SHARED_YUV_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN

SHARED_CONST int kYuvLargest = 255;
SHARED_CONST int kChromaZero = 128;  // grey
// Y = (2126 R + 7152 G + 722 B) / 10000, Cb = (B - Y) / 1.8556 + 128, Cr = (R - Y) / 1.5748 + 128
SHARED_CONST int kLumaDenominator = 10000;
SHARED_CONST int kBlueChromaDenominator = 18556;
SHARED_CONST int kRedChromaDenominator = 15748;
// G = Y - (4185031 (Cr - 128) + 1674679 (Cb - 128)) / 8940000: the first line solved for G, cut by 8
SHARED_CONST int kGreenDenominator = 8940000;
SHARED_CONST int kGreenOfRedChroma = 4185031;
SHARED_CONST int kGreenOfBlueChroma = 1674679;

SHARED_FN int yuvClamp(int value) { return value < 0 ? 0 : (value > kYuvLargest ? kYuvLargest : value); }

// r, g, b in 0..255; so is the result.
SHARED_FN int lumaOf(int r, int g, int b) {
  return (2126 * r + 7152 * g + 722 * b + kLumaDenominator / 2) / kLumaDenominator;
}

// Chroma of the mean of `texels` texels, [1, 64], of which r, g and b are the sums: rounded once. The bias keeps
// the dividend positive, where division rounds down.
SHARED_FN int blueChromaOf(int r, int g, int b, int texels) {
  int bias = kChromaZero * kBlueChromaDenominator + kBlueChromaDenominator / 2;
  return yuvClamp((9278 * b - 2126 * r - 7152 * g + bias * texels) / (kBlueChromaDenominator * texels));
}
SHARED_FN int redChromaOf(int r, int g, int b, int texels) {
  int bias = kChromaZero * kRedChromaDenominator + kRedChromaDenominator / 2;
  return yuvClamp((7874 * r - 7152 * g - 722 * b + bias * texels) / (kRedChromaDenominator * texels));
}

// luma and chroma in 0..255; so is the result: colours that no display has are cut to the nearest value a channel.
SHARED_FN int redOf(int luma, int redChroma) {
  int bias = 2 * kChromaZero;
  return yuvClamp(luma - bias +
                  (kRedChromaDenominator * (redChroma - kChromaZero) + kLumaDenominator / 2 +
                   bias * kLumaDenominator) / kLumaDenominator);
}
SHARED_FN int greenOf(int luma, int blueChroma, int redChroma) {
  int bias = kChromaZero;
  return yuvClamp(luma - bias +
                  (bias * kGreenDenominator + kGreenDenominator / 2 -
                   kGreenOfRedChroma * (redChroma - kChromaZero) -
                   kGreenOfBlueChroma * (blueChroma - kChromaZero)) / kGreenDenominator);
}
SHARED_FN int blueOf(int luma, int blueChroma) {
  int bias = 2 * kChromaZero;
  return yuvClamp(luma - bias +
                  (kBlueChromaDenominator * (blueChroma - kChromaZero) + kLumaDenominator / 2 +
                   bias * kLumaDenominator) / kLumaDenominator);
}

// Three planes in one buffer of words of four bytes, the first byte the lowest: the header, luma, blue chroma (U),
// red chroma (V), rows from the top, each row padded to whole words. `side` is of the square of texels that share a
// chroma value: 1 (4:4:4) or 2 (4:2:0, sited at the square's centre).
struct YuvHeader {
  uint frame;  // lowest 32 bits of its number
  uint width;  // of luma
  uint height;
  uint side;
};
#ifdef __cplusplus
static_assert(sizeof(YuvHeader) == 16);
#endif
SHARED_CONST uint kYuvHeaderWords = 4u;

SHARED_FN uint yuvChromaSize(uint size, uint side) { return (size + side - 1u) / side; }
SHARED_FN uint yuvStride(uint width) { return (width + 3u) / 4u; }  // words a row
// Words before each plane, 0 to 2; of 3: the words of all, without the header.
SHARED_FN uint yuvPlane(uint plane, uint width, uint height, uint side) {
  uint luma = yuvStride(width) * height;
  uint chroma = yuvStride(yuvChromaSize(width, side)) * yuvChromaSize(height, side);
  return plane == 0u ? 0u : luma + (plane - 1u) * chroma;
}

TESSERA_SHARED_END
#endif
