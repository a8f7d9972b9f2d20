#include "engine/scene/gltf.hpp"

#include <algorithm>
#include <cfloat>
#include <new>
#include <stdexcept>

#include "engine/scene/gltf_build.hpp"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Calls `one(primitive, m, p)` for the JSON of every primitive.
template <class J, class One>
void forEachPrimitive(J& json, const One& one) {
  if (!json.contains("meshes")) return;
  auto& meshes = json["meshes"];
  for (std::size_t m = 0; m < meshes.size(); ++m)
    for (std::size_t p = 0; p < meshes[m]["primitives"].size(); ++p) one(meshes[m]["primitives"][p], m, p);
}

/// tinygltf's reading of the JSON. It gets neither buffers nor images: those are read by readBuffers and
/// buildImages, which check where they read; what it takes as a given has been checked by checkGltfSchema.
/// The accessors of indices are put in afterwards, since tinygltf refuses those without buffer view, which
/// may be sparse.
Result<tinygltf::Model> parseModel(const GltfDocument& document) {
  nlohmann::json json = document.json;
  json.erase("buffers");
  json.erase("images");
  forEachPrimitive(json, [](auto& primitive, std::size_t, std::size_t) { primitive.erase("indices"); });
  const std::string text = json.dump();
  tinygltf::TinyGLTF parser;
  tinygltf::Model model;
  std::string error;
  std::string warning;
  if (!parser.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                  static_cast<unsigned int>(text.size()), "", tinygltf::NO_REQUIRE))
    return fail("{}: {}", document.file, printable(error));
  forEachPrimitive(document.json, [&](const auto& primitive, std::size_t m, std::size_t p) {
    model.meshes[m].primitives[p].indices = primitive.value("indices", -1);
  });
  return model;
}

glm::dvec3 corner(const Box& box, unsigned i) {
  return {(i & 1U) != 0 ? box.max.x : box.min.x, (i & 2U) != 0 ? box.max.y : box.min.y,
          (i & 4U) != 0 ? box.max.z : box.min.z};
}

/// World boxes of all instances at time 0; what overflows a float is refused.
Result<void> computeBounds(const std::string& file, Scene& scene) {
  SceneState state;
  evaluate(scene, 0.0, state);
  for (const Instance& instance : scene.instances) {
    const Box& box = scene.primitives[instance.primitive].bounds;
    for (unsigned i = 0; i < 8; ++i) {
      const glm::dvec3 p(state.world[instance.node] * glm::dvec4(corner(box, i), 1.0));
      if (const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
          !(largest <= double{FLT_MAX}))
        return fail("{}: node '{}' places a vertex at ({}, {}, {})", file, scene.nodes[instance.node].name,
                    p.x, p.y, p.z);
      scene.bounds.add(p);
    }
  }
  return {};
}

Result<void> build(const GltfInput& input, const fs::path& folder, const GltfOptions& options, Scene& scene) {
  const auto step = [&](const char* name) {
    if (options.progress) options.progress(name);
  };
  step("materials and nodes");
  if (auto ok = buildMaterials(input, scene); !ok) return ok;
  if (auto ok = buildCamerasAndLights(input, scene); !ok) return ok;
  const auto nodes = buildNodes(input, scene);
  if (!nodes) return tl::unexpected(nodes.error());
  step("geometry");
  if (auto ok = buildMeshes(input, scene); !ok) return ok;
  if (auto ok = buildInstances(input, scene); !ok) return ok;
  if (auto ok = buildAnimations(input, *nodes, scene); !ok) return ok;
  if (auto ok = computeBounds(input.file, scene); !ok) return ok;
  step("images");
  if (auto ok = buildImages(input, folder, options.loadImages, scene); !ok) return ok;
  if (scene.triangleCount() == 0) return fail("{}: scene: 0 triangles", input.file);
  return {};
}

Result<Scene> load(const fs::path& path, const GltfOptions& options) {
  if (options.progress) options.progress("file");
  const auto document = readGltfDocument(path);
  if (!document) return tl::unexpected(document.error());
  const auto buffers = readBuffers(*document, path.parent_path());
  if (!buffers) return tl::unexpected(buffers.error());
  const auto model = parseModel(*document);
  if (!model) return tl::unexpected(model.error());
  const auto accessors = GltfAccessors::check(document->file, *model, *buffers);
  if (!accessors) return tl::unexpected(accessors.error());

  Scene scene;
  scene.file = document->file;
  GltfWarnings warnings;
  const GltfInput input{document->file, *document, *model, *accessors, warnings};
  if (auto ok = build(input, path.parent_path(), options, scene); !ok) return tl::unexpected(ok.error());
  scene.warnings = document->warnings;
  const std::vector<std::string> lines = warnings.lines();
  scene.warnings.insert(scene.warnings.end(), lines.begin(), lines.end());
  return scene;
}

}  // namespace

void GltfWarnings::add(const std::string& what, const std::string& element) {
  const auto found = std::ranges::find(entries_, what, &Entry::what);
  if (found != entries_.end())
    ++found->more;
  else
    entries_.push_back({what, element, 0});
}

std::vector<std::string> GltfWarnings::lines() const {
  std::vector<std::string> out;
  for (const Entry& entry : entries_)
    out.push_back(entry.more == 0
                      ? fmt::format("{} ({})", entry.what, entry.element)
                      : fmt::format("{} ({} and {} more)", entry.what, entry.element, entry.more));
  return out;
}

Result<Scene> loadGltf(const fs::path& path, const GltfOptions& options) {
  // Every size is capped before it is allocated, but the machine may have less than the caps allow.
  try {
    // Messages quote names, and names may hold anything.
    auto scene = load(path, options);
    if (!scene) return tl::unexpected(Error{oneLine(std::move(scene.error().message))});
    for (std::string& warning : scene->warnings) warning = oneLine(std::move(warning));
    return scene;
  } catch (const std::bad_alloc&) {
    return fail("{}: does not fit into memory", path.string());
  }
}

}  // namespace tessera
