// When memory is reset, and how the target S of level selection adapts: the same for the GPU and for the quadtree on the
// CPU. Based on Mueller 2021, sec. 3.5, last paragraph: S is cut when memory runs out or passes the high-water mark, and
// grows slowly after a quiet time. Ours are the soft mark (below the high-water mark S shrinks before a reset is needed,
// so that S finds the size that memory can hold) and the reset when the camera jumps.
#ifndef TESSERA_GLSL_SHARED_PRESSURE_H
#define TESSERA_GLSL_SHARED_PRESSURE_H
#include "shared/dialect.h"
TESSERA_SHARED_BEGIN
#ifdef __cplusplus
using glm::max;
using glm::min;
#endif

struct PressureConfig {
  float highWater;       // load, in texels, beyond which memory is reset
  float softWater;       // live texels beyond which S shrinks gently
  float targetStart;     // S of the first frame, texels
  float targetLargest;   // S never grows past this, texels
  float targetSmallest;  // S is never cut below this, texels
  float targetCut;       // factor on S at a cut
  float targetGrowth;    // factor on S in a frame after the quiet time; its inverse above the soft mark
  uint quietFrames;      // frames without pressure after which S grows
  uint resets;           // 1: memory is reset under pressure; 0: never
  uint adapts;           // 1: S is cut and grows; 0: it stays
};

struct PressureState {
  float target;     // S, texels
  uint quiet;       // frames since the last one under pressure
  uint sinceReset;  // frames since the last reset
  uint sinceCut;    // frames since S was last cut
  uint wait;        // frames that must lie between two resets that pressure asks for
  uint pending;     // 1: a reset is due, and held back
  uint reset;       // 1: memory is reset in the frame that begins
};

// What the last frame left, and what the frame that begins asks for. Texels are those without the record rows.
struct PressureInput {
  bool failed;   // the last frame had a request that got no block, or a smaller one than it asked for
  bool waiting;  // it had a patch that kept a smaller block of an earlier frame
  float load;    // texels that it left cut into blocks and not merged back
  float room;    // all others
  float live;    // texels in use, 0 to leave the soft mark out
  float fresh;   // texels that patches ask for which it did not see, at its bias
  bool limits;   // S was what set its bias
  bool held;     // no reset may happen now, whoever asks
  bool asked;    // the caller wants a reset
};

// Resets by pressure that follow each other without a calm frame between wait twice as long each time, up to this: where
// memory is too small for the demand, a reset every frame would buy nothing but flicker.
SHARED_CONST uint kLongestResetWait = 64u;
// Frames that a cut of S gets to show its effect, unless memory was packed afresh and is still too small.
SHARED_CONST uint kCutInterval = 8u;
// S rests while the live texels lie between the soft mark and this share of it: else it would swing, and levels with it.
SHARED_CONST float kRestShare = 0.97;
// A camera jumps when it asks for more than this share of S anew.
SHARED_CONST float kJumpShare = 0.25;

SHARED_FN PressureState pressureAtStart(PressureConfig config) {
  PressureState state;
  state.target = config.targetStart;
  state.quiet = 0u;
  state.sinceReset = 0u;
  state.sinceCut = kCutInterval;
  state.wait = 1u;
  state.pending = 0u;
  state.reset = 0u;
  return state;
}

// A camera that jumps: a good part of what it asks for is new and does not fit beside what the last frame left. Packing
// all afresh then moves little that would have stayed, and spares the new from want of memory.
SHARED_FN bool cameraJumps(PressureInput frame, float target) {
  return frame.load > float(0) && frame.fresh > frame.room && frame.fresh > kJumpShare * target;
}

// Opens a frame. While a reset is due and held back, S is cut for new failures only: what is over the mark or waits is
// for the reset to mend, and a smaller S would blur the picture for nothing.
SHARED_FN PressureState stepPressure(PressureState state, PressureConfig config, PressureInput frame) {
  bool mayReset = config.resets != 0u && !frame.held;
  bool adapts = config.adapts != 0u;
  bool lasting = frame.waiting || frame.load > config.highWater;
  bool pressure = frame.failed || lasting;
  uint since = state.sinceReset + 1u;
  bool wanted = pressure && config.resets != 0u && since >= state.wait;
  bool due = wanted || frame.asked;
  bool reset = due && !frame.held;

  bool excused = frame.held && state.pending != 0u && !frame.failed;
  bool cut = pressure && adapts && !excused && (state.sinceReset == 0u || state.sinceCut >= kCutInterval);
  state.sinceCut = cut ? 0u : min(state.sinceCut + 1u, kCutInterval);
  if (cut) state.target = max(state.target * config.targetCut, config.targetSmallest);
  if (pressure) {
    if (reset && wanted) state.wait = min(state.wait + state.wait, kLongestResetWait);
    state.quiet = 0u;
  } else {
    state.wait = 1u;
    state.quiet = min(state.quiet + 1u, config.quietFrames + 1u);
    if (adapts && frame.live > config.softWater)
      state.target = max(state.target / config.targetGrowth, config.targetSmallest);
    else if (adapts && frame.limits && state.quiet > config.quietFrames && frame.live < config.softWater * kRestShare)
      state.target = min(state.target * config.targetGrowth, config.targetLargest);
  }
  if (!reset && mayReset && cameraJumps(frame, state.target)) {
    reset = true;
    state.target = min(state.target, config.targetStart);
  }
  state.pending = due && frame.held ? 1u : 0u;
  state.sinceReset = reset ? 0u : min(since, 0x7fffffffu);
  state.reset = reset ? 1u : 0u;
  return state;
}

TESSERA_SHARED_END
#ifdef __cplusplus
static_assert(sizeof(tessera::glsl::PressureConfig) == 40);
static_assert(sizeof(tessera::glsl::PressureState) == 28);
#endif
#endif
