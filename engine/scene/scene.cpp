#include "engine/scene/scene.hpp"

namespace tessera {

std::uint64_t Scene::triangleCount() const {
  std::uint64_t count = 0;
  for (const Instance& instance : instances) count += primitives[instance.primitive].indexCount / 3;
  return count;
}

bool mirrors(const glm::dmat4& world) { return glm::determinant(glm::dmat3(world)) < 0.0; }

}  // namespace tessera
