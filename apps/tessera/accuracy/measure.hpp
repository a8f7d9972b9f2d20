// Measuring configurations on one scene, over the same frames, against a supersampled reference.
#pragma once

#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "apps/tessera/accuracy/knobs.hpp"
#include "apps/tessera/measured_scene.hpp"
#include "engine/tessera.hpp"

namespace tessera::app {

/// Of the reference, texels a side.
inline constexpr int kReferenceShadowSize = 4096;

struct MeasureOptions {
  int supersampling = 4;  // samples a pixel of the reference, a side
  int warmup = 1;         // frames drawn and thrown away before each run
};

/// What one run of a configuration over the frames gave: means over them.
struct RunResult {
  double ms = 0.0;
  double dssim = 0.0;
  double psnrDb = kNotMeasured;  // with pictures only, as what follows
  double flip = kNotMeasured;
  double samples = 0.0;
  double texels = 0.0;
  double bytes = 0.0;
  Image picture, error;  // of the frame that the page shows
};

class Measuring {
 public:
  /// `scene` must outlive it. Draws the references. `step` hears of progress.
  static Result<Measuring> create(gl::Context& context, const MeasuredScene& scene,
                                  const MeasureOptions& options,
                                  std::function<void(const std::string&)> step);
  /// Draws all frames. `thorough`: counts, pictures and all errors too.
  Result<RunResult> run(const Configuration& configuration, bool thorough);
  [[nodiscard]] const Image& reference() const { return references_[shown()]; }
  /// The frame that the page shows.
  [[nodiscard]] std::size_t shown() const { return references_.size() / 2; }

 private:
  Measuring(gl::Context& context, const MeasuredScene& scene, const MeasureOptions& options,
            std::function<void(const std::string&)> step)
      : context_(&context), scene_(&scene), options_(options), step_(std::move(step)) {}
  Result<Engine*> engineFor(const Configuration& configuration);
  Result<void> frame(Engine& engine, const Configuration& configuration, std::size_t f, bool thorough,
                     RunResult& result, std::vector<double>& decibels) const;

  gl::Context* context_;
  const MeasuredScene* scene_;
  MeasureOptions options_;
  std::function<void(const std::string&)> step_;
  // By what an engine cannot change after it is made: edges split at load, patches of several triangles,
  // forms.
  std::map<std::tuple<double, bool, NumericForms>, std::unique_ptr<Engine>> engines_;
  std::vector<Image> references_;
};

}  // namespace tessera::app
