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
    if (has("gather")) {
      // The alpha test belongs to visibility and display: gather shades the whole block, masked or not.
      Permutation gather = p.shading;
      gather.mask = false;
      p.gather = get({"pass/gather.vert", "pass/shade.frag"}, definesOf(gather, {"GATHER"}));
      p.id = get({"pass/depth.vert", "pass/id.frag"}, definesOf(p.depth, {"WRITE_ID"}));
    }
    if (has("depth-prepass")) p.depthOnly = get({"pass/depth.vert", "pass/depth.frag"}, definesOf(p.depth));
    if (has("shadow"))
      p.shadow = get({"pass/depth.vert", "pass/depth.frag"}, definesOf(p.depth, {"SHADOW_LAYER"}));
    if (has("display")) p.display = get({"pass/display.vert", "pass/display.frag"}, definesOf(p.depth));
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
  if (has("display-deferred")) {
    gl::Defines defines;
    // The image is written as it is: a linear atlas must be encoded in the shader.
    if (options.atlas.format == AtlasFormat::Rgba16f) defines["LINEAR_ATLAS"] = "1";
    deferred = get({"pass/display_deferred.comp"}, defines);
  }
  if (has("upsample-rows")) upsampleRows = get({"pass/lanczos.comp"}, {});
  if (has("upsample-columns")) upsampleColumns = get({"pass/lanczos.comp"}, {{"COLUMNS", "1"}});
  if (has("warp")) warp = get({"pass/warp.vert", "pass/warp.frag"}, {});
  if (has("distort")) distort = get({"pass/distort.comp"}, {});
  if (!error.empty()) return fail("{}", error);
  return {};
}

bool Engine::State::drawsIdLayers() {
  // Deferred display reads the ids of one view.
  if (!context->info().vertexLayers || graph.find("display-deferred") != nullptr) return false;
  for (BatchPrograms& batch : batchPrograms) {
    if (batch.idLayers != nullptr) continue;
    auto program =
        programs.get({"pass/depth.vert", "pass/id.frag"}, definesOf(batch.depth, {"WRITE_ID", "LAYERS"}));
    if (!program) return false;
    batch.idLayers = *program;
  }
  return true;
}

Result<const gl::Program*> Engine::State::measureProgram(const PlaceOptions& placing) {
  gl::Defines defines;
  if (placing.foveation) defines["FOVEATE"] = "1";
  if (placing.lens) defines["LENS"] = "1";
  if (defines.empty()) return nullptr;
  return programs.get({"pass/rect_measure.comp"}, defines);
}

}  // namespace tessera
