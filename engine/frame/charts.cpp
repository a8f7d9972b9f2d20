#include "engine/frame/charts.hpp"

namespace tessera {

Result<std::vector<glsl::TexelChart>> chartsOf(const Scene& scene, const DrawScene& draw) {
  SceneState start;
  evaluate(scene, 0.0, start);
  std::vector<ChartShape> shapes;
  shapes.reserve(draw.patchInstances);
  for (std::uint32_t p = 0; p < draw.patchInstances; ++p) {
    const std::uint32_t index = draw.instanceOfPatch[p];
    const Instance& instance = draw.instances[index];
    const glsl::PatchGeometry& g =
        draw.patches[draw.patchOffset[instance.primitive] + p - draw.patchBase[index]];
    const glm::dmat4& world = start.world[instance.node];
    const auto corner = [&](std::uint32_t vertex) {
      return glm::dvec3(world * glm::dvec4(scene.vertices.position[vertex], 1.0));
    };
    shapes.push_back(
        {patchExtent({corner(g.v0), corner(g.v1), corner(g.v2), corner(g.v3), corner(g.v4)}, g.triangles),
         g.triangles == 1});
  }
  return layOutCharts(shapes);
}

}  // namespace tessera
