// Tone mapping and the sRGB curve, for shading and for whoever checks it.
#ifndef TESSERA_GLSL_SHARED_TONE_H
#define TESSERA_GLSL_SHARED_TONE_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN

// An ACES-like film curve a channel: Narkowicz 2015's rational fit. x >= 0 scene-referred, result 0..1
// display-referred linear. Large x is cut first so that x * x stays finite in float32.
SHARED_FN float toneCurve(float x) {
  float y = x < 0.0 ? 0.0 : (x > 65504.0 ? 65504.0 : x);
  float mapped = (y * (2.51 * y + 0.03)) / (y * (2.43 * y + 0.59) + 0.14);
  return mapped > 1.0 ? 1.0 : mapped;
}

// IEC 61966-2-1, linear 0..1 to encoded 0..1.
SHARED_FN float encodeSrgb(float linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

// The other way round.
SHARED_FN float decodeSrgb(float encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

TESSERA_SHARED_END
#endif
