// Command-line options that several subcommands share, and what they resolve to.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "engine/tessera.hpp"

namespace tessera::app {

/// How a subcommand ends.
enum class Exit : int { Ok = 0, Failed = 1, BadInput = 2 };

struct ContextChoice {
  std::string name = "auto";  // auto, osmesa, egl
};
struct SizeChoice {
  std::string text = "1280x720";
};
struct CameraChoice {
  std::string camera;               // name, index or auto
  std::vector<double> eye, target;  // three numbers each
  std::optional<double> fovY;       // degrees
  std::string path;                 // file, or the name of a path of the stage
  std::string pathUnlessChosen;     // that of the stage which is taken where none of these is chosen
  int frames = 0;                   // 0: one picture, or all of the path at `fps`
  double fps = 30.0;
};
struct StageChoice {
  std::string file;
};
/// Values of AtlasChoice::gather.
const std::vector<std::string>& gatherNames();
/// Values of AtlasChoice::format.
const std::vector<std::string>& atlasFormatNames();

/// What fills an atlas: rectangles, the tessellation gatherer with both of its ways to sample or one, or
/// Texel Shading.
enum class Sampling : std::uint8_t { Rect, Tess, LPack, Oversample, Texel };

struct AtlasChoice {
  Sampling sampling = Sampling::Rect;
  std::string gather;  // empty: the engine's default
  bool plainDecode = false;
  double slanted = 0.0;  // longest edge to height; 0: the engine's default
  double megapixels = 8.0;
  double bias = 0.0;
  bool pressureBias = true;
  double biasFloor = 0.0;
  double textureBias = ShadeOptions().textureBias;
  std::string strategy = "S0";
  bool merge = true;
  int superblock = 0;        // texels a side; 0: the engine's default, as for what follows
  int smallestBlock = 0;     // texels a side
  int largestBlock = 0;      // texels a side
  int largestAspect = 0;     // width to height
  double highWater = 0.0;    // share of the atlas
  double hysteresis = -2.0;  // log2; below -1: the default
  std::string format = "srgb8";
  double splitEdges = -1.0;  // negative: the engine's default
  bool pairs = true;         // false: each triangle is a patch of its own
};

struct SpatialChoice {
  std::optional<std::string> foveate;  // empty, or "x,y"
  std::string gaze;                    // file
  std::optional<std::string> lens;     // empty, or "k1,k2"
};

/// How a frame's potentially visible set is predicted.
struct PredictionChoice {
  std::string mode;  // empty: the visible set of the one view
  double latencyMs = 1e3 * PvsOptions().latency;
  int steps = PvsOptions().steps;
  double marginDegrees = glm::degrees(PvsOptions().margin);
};
/// Values of PredictionChoice::mode.
const std::map<std::string, Prediction>& predictions();

void addContext(CLI::App& command, ContextChoice& choice);
void addSize(CLI::App& command, SizeChoice& choice);
void addCamera(CLI::App& command, CameraChoice& choice);
void addStage(CLI::App& command, StageChoice& choice);
void addAtlas(CLI::App& command, AtlasChoice& choice);
void addSpatial(CLI::App& command, SpatialChoice& choice);
void addPrediction(CLI::App& command, PredictionChoice& choice);
/// --lens, and what it does beside drawing through one.
void addLens(CLI::App& command, std::optional<std::string>& choice, const std::string& beside = "");

/// Fails with the first number given that is not finite: CLI11's range checks let NaN pass.
Result<void> checkFinite(const CLI::App& command);
Result<std::unique_ptr<gl::Context>> openContext(const ContextChoice& choice);
/// "1280x720" to width and height; each 1 to 16384.
Result<glm::ivec2> parseSize(const std::string& text);
/// "a,b" as two numbers; `option` is what the error calls it.
Result<glm::dvec2> parsePair(const char* option, const std::string& text);
/// Nothing without a choice; fails where check() of the lens does.
Result<std::optional<Lens>> lensOf(const std::optional<std::string>& choice);
/// The engine's options for an atlas of about `megapixels` (2^20 texels each).
Result<EngineOptions> engineOptions(const AtlasChoice& choice);
/// How its texels are shaded.
ShadeOptions shadeOptions(const AtlasChoice& choice);
/// Nothing without a choice; fails where check() of the options does.
Result<std::optional<PvsOptions>> pvsOptionsOf(const PredictionChoice& choice);
Result<std::optional<Stage>> loadStageOf(const StageChoice& choice);
/// As loadStageOf; without a choice, the stage that the project ships for a scene of this file name, if there
/// is one.
Result<std::optional<Stage>> loadStageFor(const StageChoice& choice, const std::filesystem::path& scene);
/// The folder of assets: TESSERA_ASSETS_DIR in the environment, else the one beside the sources, else the
/// installed.
std::filesystem::path assetsFolder();

/// Foveation and lens of a run.
struct SpatialReuse {
  PlaceOptions options;
  std::vector<GazeKey> gaze;  // empty: options.foveation has the one place
  /// What place() takes at a time, seconds.
  [[nodiscard]] PlaceOptions at(double time) const;
};
Result<SpatialReuse> spatialOf(const SpatialChoice& choice);

/// Takes `pathUnlessChosen` where the stage has it and no path, camera or eye is chosen. Sets `fps`, unless
/// it is above 0 already, so that `frames` of them cover the whole path, however few; 30 without one.
Result<void> coverPath(CameraChoice& choice, const Stage* stage);
/// The views of a run, one a frame.
Result<std::vector<TimedView>> viewsOf(const CameraChoice& choice, const Scene& scene, const Stage* stage,
                                       glm::ivec2 size);

}  // namespace tessera::app
