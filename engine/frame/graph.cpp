#include "engine/frame/graph.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <glad/gl.h>

#include "engine/frame/features.hpp"

namespace tessera {

void FrameGraph::keep(std::span<const std::string> outputs) {
  std::set<std::string> needed(outputs.begin(), outputs.end());
  std::vector<Pass> kept;
  for (auto pass = passes_.rbegin(); pass != passes_.rend(); ++pass) {
    const bool wanted = std::any_of(pass->writes.begin(), pass->writes.end(),
                                    [&](const Use& use) { return needed.count(use.resource) > 0; });
    if (!wanted) continue;
    for (const Use& use : pass->reads) needed.insert(use.resource);
    kept.push_back(*pass);
  }
  std::reverse(kept.begin(), kept.end());
  passes_ = std::move(kept);
}

const Pass* FrameGraph::find(const std::string& name) const {
  const auto found =
      std::find_if(passes_.begin(), passes_.end(), [&](const Pass& p) { return p.name == name; });
  return found == passes_.end() ? nullptr : &*found;
}

std::string FrameGraph::graphviz() const {
  std::string text = "digraph frame {\n  rankdir=LR;\n  node [shape=box];\n";
  std::map<std::string, std::vector<std::string>> stages;
  for (const Pass& pass : passes_) stages[pass.stage].push_back(pass.name);
  for (const auto& [stage, names] : stages) {
    text += fmt::format("  subgraph \"cluster_{0}\" {{\n    label=\"{0}\";\n", stage);
    for (const std::string& name : names) text += fmt::format("    \"{}\";\n", name);
    text += "  }\n";
  }
  std::map<std::string, std::string> writer;
  for (const Pass& pass : passes_) {
    for (const Use& use : pass.reads)
      if (const auto from = writer.find(use.resource); from != writer.end() && from->second != pass.name)
        text += fmt::format("  \"{}\" -> \"{}\" [label=\"{}\"];\n", from->second, pass.name, use.resource);
    for (const Use& use : pass.writes) writer[use.resource] = pass.name;
  }
  return text + "}\n";
}

namespace {

std::uint32_t barrierBit(Access access) {
  switch (access) {
    case Access::Storage:
      return GL_SHADER_STORAGE_BARRIER_BIT;
    case Access::Image:
      return GL_SHADER_IMAGE_ACCESS_BARRIER_BIT;
    case Access::Texture:
      return GL_TEXTURE_FETCH_BARRIER_BIT;
    case Access::Target:
      return GL_FRAMEBUFFER_BARRIER_BIT;
    case Access::Indirect:
      return GL_COMMAND_BARRIER_BIT;
    case Access::Vertex:
      return GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_ELEMENT_ARRAY_BARRIER_BIT;
  }
  return GL_ALL_BARRIER_BITS;
}

}  // namespace

std::uint32_t BarrierTracker::before(const Pass& pass) {
  std::uint32_t bits = 0;
  auto need = [&](const Use& use) {
    const auto found = pending_.find(use.resource);
    if (found == pending_.end()) return;
    const std::uint32_t bit = barrierBit(use.access);
    if ((found->second & bit) != bit) bits |= bit;
  };
  for (const Use& use : pass.reads) need(use);
  for (const Use& use : pass.writes) need(use);
  // A barrier is for all resources at once.
  if (bits != 0)
    for (auto& [resource, issued] : pending_) issued |= bits;
  for (const Use& use : pass.writes) {
    if (use.access == Access::Storage || use.access == Access::Image)
      pending_[use.resource] = 0;
    else
      pending_.erase(use.resource);
  }
  return bits;
}

FrameGraph planFrame(const SceneFeatures& features, const FrameRequest& request) {
  FrameGraph graph;
  const auto storage = [](const char* name) { return Use{name, Access::Storage}; };
  // What a lit pass reads of the shadow map only exists when a light casts.
  std::vector<Use> shadowRead;
  if (features.shadows) {
    graph.add({"shadow", "shadow", {}, {{"shadow-map", Access::Target}}});
    shadowRead.push_back({"shadow-map", Access::Texture});
  }
  const bool blended = request.blended && features.blend;
  const bool atlas = request.rect && (features.opaque || blended);
  if (atlas) {
    graph.add({"id", "visibility", {}, {{"ids", Access::Target}, {"id-depth", Access::Target}}});
    graph.add({"mark", "visibility", {{"ids", Access::Texture}}, {storage("visible-set")}});
    if (blended)
      graph.add({"mark-blended",
                 "visibility",
                 {{"id-depth", Access::Target}, storage("visible-set")},
                 {storage("visible-set")}});
    graph.add({"levels",
               "place",
               {storage("visible-set"), {"visible-set", Access::Indirect}},
               {storage("patch-levels")}});
    graph.add({"memory",
               "place",
               {storage("visible-set"),
                storage("patch-levels"),
                storage("patch-state"),
                {"visible-set", Access::Indirect}},
               {storage("patch-state")}});
    graph.add({"emit",
               "place",
               {storage("visible-set"), storage("patch-state"), {"visible-set", Access::Indirect}},
               {storage("draw-vertices"), storage("draw-commands")}});
    std::vector<Use> reads = {
        {"draw-vertices", Access::Vertex}, storage("draw-vertices"), {"draw-commands", Access::Indirect}};
    reads.insert(reads.end(), shadowRead.begin(), shadowRead.end());
    graph.add({"gather", "shade", reads, {{"atlas", Access::Target}}});
    if (request.displayGeometry)
      graph.add({"display",
                 "display",
                 {{"atlas", Access::Texture},
                  {"draw-vertices", Access::Vertex},
                  storage("draw-vertices"),
                  {"draw-commands", Access::Indirect}},
                 {{"rect-color", Access::Target}, {"rect-depth", Access::Target}}});
    if (request.displayDeferred)
      graph.add({"display-deferred",
                 "display",
                 {{"atlas", Access::Texture},
                  {"ids", Access::Texture},
                  {"id-depth", Access::Target},
                  storage("draw-vertices")},
                 {{"rect-color", Access::Image}}});
  }
  std::vector<std::string> outputs;
  if (request.rect) {
    if (features.blend) {
      std::vector<Use> reads = shadowRead;
      reads.push_back({request.displayDeferred ? "id-depth" : "rect-depth", Access::Target});
      reads.push_back({"rect-color", Access::Target});
      graph.add({"rect-transparent", "display", reads, {{"rect-color", Access::Target}}});
    }
    outputs.emplace_back("rect-color");
  }
  if (request.forward) {
    std::vector<Use> reads = shadowRead;
    if (features.opaque) {
      if (request.depthPrepass) {
        graph.add({"depth-prepass", "forward", {}, {{"forward-depth", Access::Target}}});
        reads.push_back({"forward-depth", Access::Target});
      }
      graph.add({"forward",
                 "forward",
                 reads,
                 {{"forward-color", Access::Target}, {"forward-depth", Access::Target}}});
    }
    if (features.blend) {
      reads = shadowRead;
      reads.push_back({"forward-depth", Access::Target});
      reads.push_back({"forward-color", Access::Target});
      graph.add({"forward-transparent", "forward", reads, {{"forward-color", Access::Target}}});
    }
    outputs.emplace_back("forward-color");
    if (request.upsample) {
      graph.add({"upsample-rows",
                 "forward",
                 {{"forward-color", Access::Texture}},
                 {{"upsampled-rows", Access::Image}}});
      graph.add({"upsample-columns",
                 "forward",
                 {{"upsampled-rows", Access::Texture}},
                 {{"upsampled-color", Access::Image}}});
      outputs.emplace_back("upsampled-color");
    }
    if (request.warp) {
      graph.add({"warp",
                 "forward",
                 {{"forward-color", Access::Texture}, {"forward-depth", Access::Texture}},
                 {{"warped-color", Access::Target}}});
      outputs.emplace_back("warped-color");
    }
  }
  if (request.lens) {
    std::vector<Use> reads;
    for (const std::string& picture : outputs) reads.push_back({picture, Access::Texture});
    if (!reads.empty()) {
      graph.add({"distort", "display", reads, {{"lens-color", Access::Image}}});
      outputs.emplace_back("lens-color");
    }
  }
  graph.keep(outputs);
  return graph;
}

}  // namespace tessera
