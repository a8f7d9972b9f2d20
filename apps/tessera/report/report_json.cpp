#include "apps/tessera/report/report_json.hpp"

#include <cmath>

#include "apps/tessera/report/report_atlas.hpp"
#include "apps/tessera/report/report_figures.hpp"
#include "engine/measure/metrics.hpp"

namespace tessera {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json timingJson(const Statistics& s) {
  return {{"median", number(s.median)},
          {"p95", number(s.p95)},
          {"min", number(s.min)},
          {"spread", number(s.spread)},
          {"count", s.count}};
}

Json contextJson(const ReportContext& c) {
  return {{"backend", c.backend}, {"renderer", c.renderer}, {"gl", c.gl},          {"glsl", c.glsl},
          {"timer", c.timer},     {"commit", c.commit},     {"command", c.command}};
}

namespace {

Json methodJson(const ReportScene& scene, const ReportMethod& m) {
  Json passes = Json::array();
  for (const ReportPass& pass : m.passes)
    passes.push_back({{"name", pass.name}, {"ms", timingJson(pass.ms)}});
  Json views = Json::array();
  for (const double view : m.mssimViews) views.push_back(number(view));
  Json json = {{"name", m.name},
               {"reference", m.reference},
               {"views", m.views},
               {"mssim", number(m.mssim)},
               {"mssim_views", views},
               {"mssim_acuity", number(m.mssimAcuity)},
               {"dssim", number(dssim(m.mssim))},
               {"psnr_db", number(m.psnrDb)},
               {"flip", number(m.flip)},
               {"samples_shaded", number(m.samplesShaded)},
               {"shaded_per_target_pixel", number(shadedPerTargetPixel(scene, m))},
               {"shaded_per_picture_pixel", number(shadedPerPicturePixel(scene, m))},
               {"shaded_against_reference", number(shadedAgainstReference(scene, m))},
               {"invocations", number(m.invocations)},
               {"invocations_per_target_pixel",
                number(m.invocations / (static_cast<double>(scene.width) * scene.height))},
               {"samples_allocated", number(m.samplesAllocated)},
               {"atlas_texels_used", number(m.atlasTexelsUsed)},
               {"visible_patches", number(m.visiblePatches)},
               {"visible_triangles", number(m.visibleTriangles)},
               {"covered_pixels", number(m.coveredPixels)},
               {"out_of_memory", number(m.outOfMemory)},
               {"resets", number(m.resets)},
               {"holes", number(m.holes)},
               {"non_finite_texels", number(m.nonFiniteTexels)},
               {"levels_share", number(passShare(m, "levels"))},
               {"memory_share", number(passShare(m, "memory"))},
               {"passes", std::move(passes)},
               {"frame_ms", timingJson(m.frameMs)},
               {"gather_ms", timingJson(m.gatherMs)},
               {"display_ms", timingJson(m.displayMs)},
               {"samples_passed", number(m.samplesPassed)},
               {"samples_partly_in_view", number(m.samplesPartlyInView)},
               {"ns_per_passed", number(m.nsPerPassed)},
               {"ns_per_sample", number(m.nsPerSample)}};
  json.update(atlasJson(scene, m));
  return json;
}

Json sceneJson(const ReportScene& scene) {
  Json methods = Json::array();
  for (const ReportMethod& method : scene.methods) methods.push_back(methodJson(scene, method));
  Json pvs = Json::array();
  for (const ReportPvsRow& row : scene.pvs) {
    pvs.push_back(pvsJson(scene, row));
    pvs.back().update(methodJson(scene, row.method));
  }
  return {{"file", scene.file},
          {"note", scene.note},
          {"triangles", scene.triangles},
          {"instances", scene.instances},
          {"materials", scene.materials},
          {"lights", scene.lights},
          {"size", {scene.width, scene.height}},
          {"frames", scene.frames},
          {"atlas_reference", scene.atlasReference},
          {"methods", std::move(methods)},
          {"pvs", std::move(pvs)},
          {"crops", cropsJson(scene)}};
}

}  // namespace

std::string toJson(const Report& report) {
  Json scenes = Json::array();
  for (const ReportScene& scene : report.scenes) scenes.push_back(sceneJson(scene));
  Json figures = Json::array();
  for (const ReportFigure& figure : report.figures) figures.push_back(figureJson(report, figure));
  const Json root = {{"schema", 1},
                     {"context", contextJson(report.context)},
                     {"scenes", std::move(scenes)},
                     {"figures", std::move(figures)}};
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tessera
