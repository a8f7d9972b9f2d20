#include "apps/tessera/options.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include <fmt/ranges.h>

namespace tessera::app {

void addContext(CLI::App& command, ContextChoice& choice) {
  command.add_option("--context", choice.name, "GL context: auto, osmesa or egl")
      ->check(CLI::IsMember({"auto", "osmesa", "egl"}))
      ->capture_default_str();
}

void addSize(CLI::App& command, SizeChoice& choice) {
  command.add_option("--size", choice.text, "picture size in pixels, WxH")->capture_default_str();
}

void addCamera(CLI::App& command, CameraChoice& choice) {
  command.add_option("--camera", choice.camera,
                     "camera of the scene by name or index, or 'auto' to see all of it");
  command.add_option("--eye", choice.eye, "x,y,z of the eye in metres")->delimiter(',')->expected(3);
  command.add_option("--target", choice.target, "x,y,z looked at")->delimiter(',')->expected(3);
  command.add_option("--fov-y", choice.fovY, "vertical field of view in degrees, 0.1 to 175");
  std::string path = "camera path: a JSON file, or the name of a path of the stage";
  if (!choice.pathUnlessChosen.empty())
    path += "; " + choice.pathUnlessChosen + ", if the stage has it and no camera or eye is chosen";
  command.add_option("--path", choice.path, path);
  command.add_option("--frames", choice.frames, "number of frames along the path")
      ->check(CLI::Range(1, 1000000));
  command.add_option("--fps", choice.fps, "frames a second of the path")
      ->check(CLI::Range(0.001, 100000.0))
      ->capture_default_str();
}

void addStage(CLI::App& command, StageChoice& choice) {
  command.add_option("--stage", choice.file, "JSON file with lights, ambient and camera paths");
}

void addAtlas(CLI::App& command, AtlasChoice& choice) {
  command.add_option("--atlas-mpix", choice.megapixels, "atlas size in 2^20 texels")
      ->check(CLI::Range(0.0625, 128.0))
      ->capture_default_str();
  command
      .add_option("--bias", choice.bias,
                  "constant level bias: 1 halves the texels, -2 gives four times as many")
      ->check(CLI::Range(-8.0, 16.0))
      ->capture_default_str();
  command.add_flag("!--no-pressure-bias", choice.pressureBias,
                   "do not lower levels when the atlas gets full");
  command
      .add_option("--bias-floor", choice.biasFloor,
                  "lowest bias that room to spare may lead to: 0 none, -2 up to four times the texels")
      ->check(CLI::Range(-4.0, 0.0))
      ->capture_default_str();
  command
      .add_option("--texture-bias", choice.textureBias,
                  "added to the mip level of textures where texels are shaded: below 0 is sharper")
      ->check(CLI::Range(-2.0, 1.0))
      ->capture_default_str();
  command.add_option("--strategy", choice.strategy, "memory strategy: S0 (the one to use), S1, S2, S3")
      ->check(CLI::IsMember({"S0", "S1", "S2", "S3"}))
      ->capture_default_str();
  command.add_flag("!--no-merge", choice.merge, "do not merge free siblings");
  const auto powerOfTwo = [](const std::string& text) {
    const int value = std::atoi(text.c_str());
    return value > 0 && (value & (value - 1)) == 0 ? std::string() : text + " is not a power of two";
  };
  command
      .add_option(
          "--superblock", choice.superblock,
          "texels a side of a superblock, 2 to 1024; else 256, less where the atlas has not room for 16")
      ->check(CLI::Range(2, 1024))
      ->check(powerOfTwo);
  command
      .add_option("--smallest-block", choice.smallestBlock,
                  "texels that no side of a block is shorter than, 1 to 1024")
      ->check(CLI::Range(1, 1024))
      ->check(powerOfTwo);
  command.add_option("--largest-block", choice.largestBlock, "texels a side of the largest block, 2 to 1024")
      ->check(CLI::Range(2, 1024))
      ->check(powerOfTwo);
  command
      .add_option("--largest-aspect", choice.largestAspect, "width to height of a block at most, 2 to 1024")
      ->check(CLI::Range(2, 1024))
      ->check(powerOfTwo);
  command.add_option("--high-water", choice.highWater, "share of the atlas in use beyond which it is reset")
      ->check(CLI::Range(0.01, 1.0));
  command
      .add_option("--hysteresis", choice.hysteresis,
                  "how far past the border, in log2, a block's ideal size must be; -1: none")
      ->check(CLI::Range(-1.0, 2.0));
  command
      .add_option(
          "--gather", choice.gather,
          "how the tessellation gatherer spawns its samples: raster, tess, deferred (the tessellator notes "
          "them, compute shades them), or compute-N by groups of N threads (32, 64, 128, 256, 512); without "
          "it, what is fastest on the context by measurement")
      ->check(CLI::IsMember(gatherNames()));
  command.add_flag("--plain-decode", choice.plainDecode,
                   "decode Ls by the paper's formula, which bends lines by up to 0.15 of a sample step");
  command
      .add_option("--slanted", choice.slanted,
                  "longest edge to height beyond which a triangle is oversampled by method tess")
      ->check(CLI::Range(1.0, 1e6));
  command.add_option("--atlas-format", choice.format, "srgb8, rgb10a2, r11g11b10f or rgba16f")
      ->check(CLI::IsMember(atlasFormatNames()))
      ->capture_default_str();
  command.add_flag("!--no-pairs", choice.pairs, "each triangle is a patch of its own");
  command
      .add_option("--split-edges", choice.splitEdges,
                  "split edges longer than this share of the scene's diagonal; 0: never")
      ->check(CLI::Range(0.0, 1.0));
}

void addSpatial(CLI::App& command, SpatialChoice& choice) {
  command
      .add_option("--foveate", choice.foveate,
                  "shade less where the eye resolves less; x,y looked at as a share of the picture from its "
                  "top left, else its middle")
      ->expected(0, 1);
  command.add_option("--gaze", choice.gaze,
                     "foveate by a JSON file of places over time: [{time, x, y}, ...]");
  addLens(command, choice.lens, ", and shade less where it presses together");
}

void addLens(CLI::App& command, std::optional<std::string>& choice, const std::string& beside) {
  command.add_option("--lens", choice, "draw through a lens" + beside + "; k1,k2, else 0.22,0.24")
      ->expected(0, 1);
}

const std::map<std::string, Prediction>& predictions() {
  static const std::map<std::string, Prediction> names = {
      {"none", Prediction::None}, {"linear", Prediction::Linear}, {"reference", Prediction::Reference}};
  return names;
}

void addPrediction(CLI::App& command, PredictionChoice& choice) {
  auto* prediction =
      command
          .add_option(
              "--prediction", choice.mode,
              "shade what will be visible, too: none (the present view with its margin), linear (from "
              "the last two poses), reference (the path as it will be)")
          ->check(CLI::IsMember(predictions()));
  // A command that predicts by itself takes these alone.
  const auto further = [&](CLI::Option* option) {
    if (choice.mode.empty()) option->needs(prediction);
    option->capture_default_str();
  };
  further(command.add_option("--latency-ms", choice.latencyMs, "how far ahead is predicted")
              ->check(CLI::Range(0.0, 10000.0)));
  further(command
              .add_option("--steps", choice.steps,
                          "predicted views beside the present one, evenly over the latency")
              ->check(CLI::Range(1, 64)));
  further(command
              .add_option("--margin-deg", choice.marginDegrees,
                          "degrees that these views see further to each side, 0 to 45")
              ->check(CLI::Range(0.0, 45.0)));
}

Result<std::optional<PvsOptions>> pvsOptionsOf(const PredictionChoice& choice) {
  if (choice.mode.empty()) return std::optional<PvsOptions>();
  const PvsOptions options{.prediction = predictions().at(choice.mode),
                           .latency = 1e-3 * choice.latencyMs,
                           .steps = choice.steps,
                           .margin = glm::radians(choice.marginDegrees)};
  if (auto good = check(options); !good) return tl::unexpected(good.error());
  return std::optional<PvsOptions>(options);
}

Result<void> checkFinite(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    // "FLOAT", or "[FLOAT,...]", with the range behind it.
    if (option->get_type_name().find("FLOAT") == std::string::npos) continue;
    for (const std::string& value : option->results())
      if (!std::isfinite(std::strtod(value.c_str(), nullptr)))
        return fail("{} {}: not a finite number", option->get_name(), value);
  }
  return {};
}

Result<std::unique_ptr<gl::Context>> openContext(const ContextChoice& choice) {
  if (choice.name == "osmesa") return gl::Context::createOsMesa();
  if (choice.name == "egl") return gl::Context::createEgl();
  // A GPU is reached through EGL; without one OSMesa is the faster software path.
  auto egl = gl::Context::createEgl();
  if (egl && !(*egl)->info().software) return egl;
  auto osmesa = gl::Context::createOsMesa();
  if (osmesa) {
    if (egl) egl->reset();
    if (auto current = (*osmesa)->makeCurrent(); !current) return tl::unexpected(current.error());
    return osmesa;
  }
  if (egl) return egl;
  return fail("no OpenGL context: {}; {}", egl.error().message, osmesa.error().message);
}

Result<glm::ivec2> parseSize(const std::string& text) {
  glm::ivec2 size(0);
  const char* begin = text.data();
  const char* end = begin + text.size();
  const auto width = std::from_chars(begin, end, size.x);
  if (width.ec == std::errc() && width.ptr != end && (*width.ptr == 'x' || *width.ptr == 'X')) {
    const auto height = std::from_chars(width.ptr + 1, end, size.y);
    constexpr int kLargest = 16384;
    if (height.ec == std::errc() && height.ptr == end && size.x >= 1 && size.y >= 1 && size.x <= kLargest &&
        size.y <= kLargest)
      return size;
  }
  return fail("--size {}: not WxH with each from 1 to 16384", text);
}

Result<EngineOptions> engineOptions(const AtlasChoice& choice) {
  EngineOptions options;
  RectMemoryOptions& memory = options.atlas.memory;
  const double texels = choice.megapixels * 1048576.0;
  const auto log2Of = [](int value) { return std::bit_width(static_cast<unsigned>(value)) - 1; };
  if (choice.smallestBlock > 0) memory.smallestLog2 = log2Of(choice.smallestBlock);
  if (choice.largestBlock > 0) memory.largestLog2 = log2Of(choice.largestBlock);
  if (choice.largestAspect > 0) memory.aspectLog2 = log2Of(choice.largestAspect);
  if (choice.highWater > 0.0) memory.highWater = static_cast<float>(choice.highWater);
  if (choice.hysteresis >= -1.0) memory.hysteresis = static_cast<float>(choice.hysteresis);
  memory.strategy = static_cast<AtlasStrategy>(choice.strategy.back() - '0');
  memory.merge = choice.merge;
  memory.biasFloor = static_cast<float>(choice.biasFloor);
  memory.width = 1 << static_cast<int>(std::ceil(std::log2(std::sqrt(texels)) - 1e-9));
  const int rows = static_cast<int>(std::lround(texels / memory.width));
  memory.superblockLog2 = choice.superblock > 0
                              ? log2Of(choice.superblock)
                              : std::max(superblockLog2Of(memory.width, rows), memory.smallestLog2);
  const int superblock = 1 << memory.superblockLog2;
  memory.width = std::max(superblock, memory.width);
  memory.height =
      std::max(superblock, static_cast<int>(std::lround(texels / memory.width / superblock)) * superblock);
  memory.bias = static_cast<float>(choice.bias);
  memory.pressureBias = choice.pressureBias;
  TessMemoryOptions& tess = options.tess.memory;
  tess.width = memory.width;
  tess.height = memory.height;
  tess.bias = memory.bias;
  tess.biasFloor = memory.biasFloor;
  tess.pressureBias = memory.pressureBias;
  if (!choice.gather.empty()) {
    options.tess.spawn.gather = choice.gather == "raster"     ? TessGather::Raster
                                : choice.gather == "tess"     ? TessGather::Tess
                                : choice.gather == "deferred" ? TessGather::Deferred
                                                              : TessGather::Compute;
    if (options.tess.spawn.gather == TessGather::Compute)
      options.tess.spawn.group = std::atoi(choice.gather.c_str() + std::string_view("compute-").size());
  }
  options.tess.decode = choice.plainDecode ? TessDecode::Plain : TessDecode::Exact;
  if (choice.slanted > 0.0) tess.slanted = static_cast<float>(choice.slanted);
  if (choice.sampling == Sampling::LPack) tess.slanted = TessMemoryOptions::kNoneSlanted;
  if (choice.sampling == Sampling::Oversample) tess.slanted = TessMemoryOptions::kAllSlanted;
  TexelAtlasOptions& texel = options.texel;
  texel.width = memory.width;
  texel.height = memory.height;
  texel.bias = memory.bias;
  texel.biasFloor = memory.biasFloor;
  texel.pressureBias = memory.pressureBias;
  if (choice.sampling != Sampling::Rect)
    options.gatherer = choice.sampling == Sampling::Texel ? GathererKind::Texel : GathererKind::Tess;
  constexpr std::array kFormats = {AtlasFormat::Srgb8, AtlasFormat::Rgb10a2, AtlasFormat::R11g11b10f,
                                   AtlasFormat::Rgba16f};
  const auto& formats = atlasFormatNames();
  const auto format = std::find(formats.begin(), formats.end(), choice.format);
  if (format == formats.end())
    return fail("atlas format {}: not one of {}", choice.format, fmt::join(formats, ", "));
  options.atlas.format = kFormats.at(static_cast<std::size_t>(format - formats.begin()));
  options.tess.format = options.atlas.format;
  texel.format = options.atlas.format;
  if (choice.splitEdges >= 0.0) options.splitEdges = choice.splitEdges;
  options.patches = {.pair = choice.pairs, .triple = choice.pairs};
  return options;
}

const std::vector<std::string>& atlasFormatNames() {
  static const std::vector<std::string> names = {"srgb8", "rgb10a2", "r11g11b10f", "rgba16f"};
  return names;
}

const std::vector<std::string>& gatherNames() {
  static const std::vector<std::string> names = {"raster",     "tess",        "deferred",    "compute-32",
                                                 "compute-64", "compute-128", "compute-256", "compute-512"};
  return names;
}

ShadeOptions shadeOptions(const AtlasChoice& choice) {
  return {.textureBias = static_cast<float>(choice.textureBias)};
}

Result<glm::dvec2> parsePair(const char* option, const std::string& text) {
  glm::dvec2 pair(0.0);
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, pair.x);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == ',') {
    const auto second = std::from_chars(first.ptr + 1, end, pair.y);
    if (second.ec == std::errc() && second.ptr == end) return pair;
  }
  return fail("{} {}: not two numbers with a comma between", option, text);
}

PlaceOptions SpatialReuse::at(double time) const {
  PlaceOptions now = options;
  if (!gaze.empty()) now.foveation->gaze = sampleGaze(gaze, time);
  return now;
}

Result<SpatialReuse> spatialOf(const SpatialChoice& choice) {
  SpatialReuse reuse;
  if (choice.foveate || !choice.gaze.empty()) reuse.options.foveation.emplace();
  if (choice.foveate && !choice.foveate->empty()) {
    if (!choice.gaze.empty()) return fail("--foveate {} and --gaze exclude each other", *choice.foveate);
    auto place = parsePair("--foveate", *choice.foveate);
    if (!place) return tl::unexpected(place.error());
    reuse.options.foveation->gaze = *place;
  }
  if (!choice.gaze.empty()) {
    auto gaze = loadGaze(choice.gaze);
    if (!gaze) return tl::unexpected(gaze.error());
    reuse.gaze = std::move(*gaze);
  }
  auto lens = lensOf(choice.lens);
  if (!lens) return tl::unexpected(lens.error());
  reuse.options.lens = *lens;
  if (reuse.options.foveation)
    if (auto good = check(*reuse.options.foveation); !good) return tl::unexpected(good.error());
  return reuse;
}

Result<std::optional<Lens>> lensOf(const std::optional<std::string>& choice) {
  if (!choice) return std::optional<Lens>();
  Lens lens;
  if (!choice->empty()) {
    auto numbers = parsePair("--lens", *choice);
    if (!numbers) return tl::unexpected(numbers.error());
    lens.k1 = numbers->x;
    lens.k2 = numbers->y;
  }
  if (auto good = check(lens); !good) return tl::unexpected(good.error());
  return lens;
}

Result<std::optional<Stage>> loadStageOf(const StageChoice& choice) {
  if (choice.file.empty()) return std::optional<Stage>();
  auto stage = loadStage(choice.file);
  if (!stage) return tl::unexpected(stage.error());
  return std::optional<Stage>(std::move(*stage));
}

std::filesystem::path assetsFolder() {
  if (const char* folder = std::getenv("TESSERA_ASSETS_DIR"); folder != nullptr && *folder != '\0')
    return folder;
  if (std::error_code ignored; std::filesystem::is_directory(TESSERA_SOURCE_ASSETS, ignored))
    return TESSERA_SOURCE_ASSETS;
  return TESSERA_INSTALLED_ASSETS;
}

Result<std::optional<Stage>> loadStageFor(const StageChoice& choice, const std::filesystem::path& scene) {
  if (!choice.file.empty()) return loadStageOf(choice);
  const auto shipped = assetsFolder() / "stages" / scene.stem().concat(".json");
  std::error_code ignored;
  return loadStageOf({std::filesystem::is_regular_file(shipped, ignored) ? shipped.string() : ""});
}

namespace {

Result<std::size_t> cameraIndex(const Scene& scene, const std::string& wanted) {
  for (std::size_t i = 0; i < scene.cameras.size(); ++i)
    if (scene.cameras[i].name == wanted) return i;
  // A node's name is what many exporters give a camera.
  for (const Node& node : scene.nodes)
    if (node.camera != kNone && node.name == wanted) return node.camera;
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
  if (error == std::errc() && end == wanted.data() + wanted.size() && index < scene.cameras.size())
    return index;
  std::string names;
  for (const Camera& camera : scene.cameras) names += fmt::format(" '{}'", camera.name);
  return fail("--camera {}: {} has {} cameras:{}", wanted, scene.file, scene.cameras.size(), names);
}

const CameraPath* pathNamed(const Stage* stage, const std::string& name) {
  if (stage == nullptr) return nullptr;
  const auto found = std::find_if(stage->paths.begin(), stage->paths.end(),
                                  [&](const CameraPath& path) { return path.name == name; });
  return found == stage->paths.end() ? nullptr : &*found;
}

Result<CameraPath> pathOf(const CameraChoice& choice, const Stage* stage) {
  if (const CameraPath* path = pathNamed(stage, choice.path)) return *path;
  return loadCameraPath(choice.path);
}

double durationOf(const CameraPath& path) { return path.keys.back().time - path.keys.front().time; }

}  // namespace

Result<void> coverPath(CameraChoice& choice, const Stage* stage) {
  const bool chosen = !choice.path.empty() || !choice.camera.empty() || !choice.eye.empty();
  if (!chosen && pathNamed(stage, choice.pathUnlessChosen) != nullptr) choice.path = choice.pathUnlessChosen;
  double duration = 0.0;
  if (!choice.path.empty()) {
    auto path = pathOf(choice, stage);
    if (!path) return tl::unexpected(path.error());
    duration = durationOf(*path);
  }
  if (choice.fps <= 0.0) choice.fps = duration > 0.0 ? std::max(choice.frames - 1, 1) / duration : 30.0;
  return {};
}

Result<std::vector<TimedView>> viewsOf(const CameraChoice& choice, const Scene& scene, const Stage* stage,
                                       glm::ivec2 size) {
  const double zNear = defaultNear(scene);
  if (choice.fovY && !(*choice.fovY >= 0.1 && *choice.fovY <= 175.0))
    return fail("--fov-y {}: outside 0.1 to 175 degrees", *choice.fovY);
  if (choice.eye.empty() != choice.target.empty()) return fail("--eye and --target go together");
  const int given = static_cast<int>(!choice.camera.empty()) + static_cast<int>(!choice.eye.empty()) +
                    static_cast<int>(!choice.path.empty());
  if (given > 1) return fail("--camera, --eye with --target, and --path exclude each other");

  std::vector<TimedView> views;
  if (!choice.path.empty()) {
    auto path = pathOf(choice, stage);
    if (!path) return tl::unexpected(path.error());
    const double first = path->keys.front().time;
    const int frames =
        choice.frames > 0 ? choice.frames : static_cast<int>(std::floor(durationOf(*path) * choice.fps)) + 1;
    for (int i = 0; i < frames; ++i) {
      const double time = first + i / choice.fps;
      CameraKey key = sampleCamera(*path, time);
      if (choice.fovY) key.fovY = *choice.fovY;
      views.push_back({time, viewOf(key, size.x, size.y, zNear)});
    }
    return views;
  }
  View view;
  if (!choice.eye.empty()) {
    const glm::dvec3 eye(choice.eye[0], choice.eye[1], choice.eye[2]);
    const glm::dvec3 target(choice.target[0], choice.target[1], choice.target[2]);
    if (eye == target) return fail("--eye and --target are the same point");
    view = lookAt(eye, target, choice.fovY.value_or(60.0), size.x, size.y, zNear);
  } else if (choice.camera.empty() ? scene.cameras.empty() : choice.camera == "auto") {
    view = autoView(scene, size.x, size.y);
  } else {
    auto index = choice.camera.empty() ? Result<std::size_t>(0) : cameraIndex(scene, choice.camera);
    if (!index) return tl::unexpected(index.error());
    SceneState state;
    evaluate(scene, 0.0, state);
    view = viewOf(scene, state, *index, size.x, size.y, zNear);
  }
  if (choice.fovY) view.fovY = glm::radians(*choice.fovY);
  for (int i = 0; i < std::max(choice.frames, 1); ++i) views.push_back({i / choice.fps, view});
  return views;
}

}  // namespace tessera::app
