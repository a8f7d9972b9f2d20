// Which programs the plan needs.
#include "engine/frame/engine_state.hpp"

namespace tessera {

namespace {

gl::Defines definesOf(const Permutation& permutation, std::initializer_list<const char*> more = {}) {
  gl::Defines defines;
  for (const std::string& name : permutation.defines()) defines[name] = "1";
  for (const char* name : more) defines[name] = "1";
  return defines;
}

}  // namespace

Result<void> Engine::State::compile() {
  std::string error;
  const auto get = [&](std::initializer_list<std::string> paths,
                       const gl::Defines& defines) -> const gl::Program* {
    auto program = programs.get(paths, defines);
    if (program) return *program;
    if (error.empty()) error = program.error().message;
    return nullptr;
  };
  const auto has = [&](const char* name) { return graph.find(name) != nullptr; };
  for (const Batch& batch : draw.batches) {
    const Material& material = scene.materials[batch.material];
    BatchPrograms p;
    p.shading = permutationOf(material, batch.vertexColor, features);
    p.depth = depthPermutationOf(material, batch.vertexColor);
    if (has("forward")) p.forward = get({"pass/forward.vert", "pass/shade.frag"}, definesOf(p.shading));
    if (has("gather")) p.id = get({"pass/depth.vert", "pass/id.frag"}, definesOf(p.depth, {"WRITE_ID"}));
    if (has("depth-prepass")) p.depthOnly = get({"pass/depth.vert", "pass/depth.frag"}, definesOf(p.depth));
    if (has("shadow"))
      p.shadow = get({"pass/depth.vert", "pass/depth.frag"}, definesOf(p.depth, {"SHADOW_LAYER"}));
    batchPrograms.push_back(p);
  }
  if (features.blend)
    for (const Instance& instance : draw.blended) {
      const Primitive& primitive = scene.primitives[instance.primitive];
      BlendedPrograms p;
      p.shading = permutationOf(scene.materials[primitive.material], primitive.hasColor, features);
      p.forward = get({"pass/forward.vert", "pass/shade.frag"}, definesOf(p.shading));
      blendedPrograms.push_back(p);
    }
  if (has("upsample-rows")) upsampleRows = get({"pass/lanczos.comp"}, {});
  if (has("upsample-columns")) upsampleColumns = get({"pass/lanczos.comp"}, {{"COLUMNS", "1"}});
  if (has("distort")) distort = get({"pass/distort.comp"}, {});
  if (!error.empty()) return fail("{}", error);
  if (has("warp")) {
    constexpr std::array<Warp, 1> kMesh = {Warp::Mesh};
    auto made = ImageWarp::create(programs, kMesh);
    if (!made) return tl::unexpected(made.error());
    warp = std::move(*made);
  }
  return {};
}

Result<void> Engine::State::compileGatherer(const EngineOptions& wanted) {
  const bool triangles = wanted.gatherer == GathererKind::Tess;
  const bool charts = wanted.gatherer == GathererKind::Texel;
  const AtlasFormat format = triangles ? wanted.tess.format
                             : charts  ? wanted.texel.format
                                       : wanted.atlas.format;
  const auto has = [&](const char* name) { return graph.find(name) != nullptr; };
  struct Chosen {
    const gl::Program* gather = nullptr;
    std::vector<const gl::Program*> display;
  };
  std::vector<Chosen> chosen;
  for (const BatchPrograms& batch : batchPrograms) {
    Chosen c;
    if (has("gather")) {
      // The alpha test belongs to visibility and display: gather shades all of a place, masked or not.
      Permutation gather = batch.shading;
      gather.mask = false;
      TessAtlas::GatherProgram own = TessAtlas::gatherProgram(wanted.tess);
      own.defines.merge(definesOf(gather));
      gl::Defines ofTiles = definesOf(gather);
      if (format == AtlasFormat::Srgb8) ofTiles.emplace("ENCODED", "1");
      auto program =
          triangles ? programs.get(own.files, own.defines)
          : charts  ? programs.get({"pass/texel_gather.comp"}, ofTiles)
                    : programs.get({"pass/gather.vert", "pass/shade.frag"}, definesOf(gather, {"GATHER"}));
      if (!program) return tl::unexpected(program.error());
      c.gather = *program;
    }
    if (has("display")) {
      for (std::uint32_t list = 0; list < (triangles ? glsl::kDisplayLists : 1); ++list) {
        gl::Defines defines = definesOf(batch.depth);
        if (triangles) defines.merge(TessAtlas::displayDefines(wanted.tess));
        if (triangles) defines.emplace("LIST", std::to_string(list));
        if (charts) defines.emplace("CHARTS", "1");
        auto program = triangles ? programs.get({"pass/tess_display.vert", "pass/tess_display.frag"}, defines)
                                 : programs.get({"pass/display.vert", "pass/display.frag"}, defines);
        if (!program) return tl::unexpected(program.error());
        c.display.push_back(*program);
      }
    }
    chosen.push_back(c);
  }
  if (has("display-deferred")) {
    gl::Defines defines;
    if (triangles) defines = TessAtlas::displayDefines(wanted.tess);
    // The image is written as it is: a linear atlas must be encoded in the shader.
    if (format != AtlasFormat::Srgb8) defines["LINEAR_ATLAS"] = "1";
    if (triangles) defines.emplace("TRIANGLES", "1");
    if (charts) defines.emplace("CHARTS", "1");
    auto program = programs.get({"pass/display_deferred.comp"}, defines);
    if (!program) return tl::unexpected(program.error());
    deferred = *program;
  }
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    batchPrograms[i].gather = chosen[i].gather;
    batchPrograms[i].display = chosen[i].display;
  }
  return {};
}

bool Engine::State::drawsIdLayers() {
  if (!context->info().vertexLayers || !options.idLayers) return false;
  for (BatchPrograms& batch : batchPrograms) {
    if (batch.idLayers != nullptr) continue;
    auto program =
        programs.get({"pass/depth.vert", "pass/id.frag"}, definesOf(batch.depth, {"WRITE_ID", "LAYERS"}));
    if (!program) return options.idLayers = false;
    batch.idLayers = *program;
  }
  return true;
}

Result<const gl::Program*> Engine::State::measureProgram(const PlaceOptions& placing) {
  gl::Defines defines;
  if (placing.foveation) defines["FOVEATE"] = "1";
  if (placing.lens) defines["LENS"] = "1";
  if (defines.empty()) return nullptr;
  return programs.get({tess ? "pass/tess_measure.comp" : "pass/rect_measure.comp"}, defines);
}

}  // namespace tessera
