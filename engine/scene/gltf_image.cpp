// The images that materials use, decoded.
#include <array>
#include <atomic>
#include <optional>
#include <thread>

#include "engine/scene/gltf_build.hpp"
#include "engine/scene/gltf_resource.hpp"

namespace tessera {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint64_t kMaxImageFileBytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kMaxPixelBytes = std::uint64_t{1} << 32;
constexpr std::size_t kThreads = 2;

constexpr std::array kSlots{&Material::baseColor, &Material::metallicRoughness, &Material::normal,
                            &Material::occlusion, &Material::emissive};

/// The encoded bytes of an image: a view of a buffer, or owned when they come from a URI.
struct Encoded {
  std::vector<std::uint8_t> owned;
  Bytes bytes;
};

Result<Encoded> encodedBytes(const GltfInput& input, const std::string& what, const nlohmann::json& image,
                             const std::filesystem::path& folder) {
  Encoded encoded;
  if (image.contains("uri") == image.contains("bufferView"))
    return fail("{}: {}", what,
                image.contains("uri") ? "has both uri and bufferView" : "uri and bufferView are missing");
  if (image.contains("bufferView")) {
    encoded.bytes = input.accessors.view(image["bufferView"].get<int>());
    return encoded;
  }
  auto bytes = readUri(what, image["uri"].get<std::string>(), folder, kMaxImageFileBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  encoded.owned = std::move(*bytes);
  encoded.bytes = encoded.owned;
  return encoded;
}

/// By the first bytes, as glTF 2.0 sec. 3.9.2 has it.
bool isPngOrJpeg(Bytes bytes) {
  return bytes.size() >= 4 && ((bytes[0] == 0x89 && bytes[1] == 'P' && bytes[2] == 'N' && bytes[3] == 'G') ||
                               (bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff));
}

std::string nameOf(const nlohmann::json& image, std::size_t index) {
  const auto text = [&](const char* key) {
    return image.contains(key) && image[key].is_string() ? image[key].get<std::string>() : std::string();
  };
  if (const std::string name = text("name"); !name.empty()) return printable(name);
  if (const std::string uri = text("uri"); !uri.empty() && !uri.starts_with("data:")) return printable(uri);
  return fmt::format("image {}", index);
}

struct Job {
  std::string what;
  Encoded encoded;
};

/// Decodes all jobs; the first error in their order, whatever the order in which threads met them.
Result<void> decodeAll(const std::vector<Job>& jobs, std::vector<SceneImage>& images) {
  std::atomic<std::size_t> next{0};
  std::atomic<std::uint64_t> total{0};
  std::vector<std::optional<Error>> errors(jobs.size());
  const auto work = [&] {
    for (std::size_t i = next++; i < jobs.size(); i = next++) {
      try {
        auto image = decodeImage(jobs[i].encoded.bytes, jobs[i].what);
        if (!image)
          errors[i] = image.error();
        else if ((total += image->pixels.size()) > kMaxPixelBytes)
          errors[i] = Error{fmt::format("{}: the images' pixels are past the limit of {} bytes", jobs[i].what,
                                        kMaxPixelBytes)};
        else
          images[i].image = std::move(*image);
      } catch (const std::bad_alloc&) {
        errors[i] = Error{fmt::format("{}: does not fit into memory", jobs[i].what)};
      }
      if (errors[i]) next = jobs.size();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i + 1 < kThreads; ++i) threads.emplace_back(work);
    work();
  }
  for (const auto& error : errors)
    if (error) return tl::unexpected(*error);
  return {};
}

}  // namespace

Result<void> buildImages(const GltfInput& input, const std::filesystem::path& folder, bool decode,
                         Scene& scene) {
  const nlohmann::json list = input.document.json.value("images", nlohmann::json::array());
  std::vector<std::uint32_t> place(list.size(), kNone);
  for (const Material& material : scene.materials)
    for (const auto slot : kSlots)
      if ((material.*slot).used()) place[(material.*slot).image] = 0;

  std::vector<Job> jobs;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string name = nameOf(list[i], i);
    const std::string element = fmt::format("image {}", i);
    const std::string what =
        fmt::format("{}: {}{}", input.file, element, name == element ? "" : fmt::format(" '{}'", name));
    auto encoded = encodedBytes(input, what, list[i], folder);
    if (place[i] == kNone) {
      if (!encoded || !isPngOrJpeg(encoded->bytes))
        input.warnings.add("an image that no material uses cannot be read", element);
      continue;
    }
    if (!encoded) return tl::unexpected(encoded.error());
    place[i] = static_cast<std::uint32_t>(jobs.size());
    jobs.push_back({what, std::move(*encoded)});
    scene.images.push_back({name, {}});
  }
  for (Material& material : scene.materials)
    for (const auto slot : kSlots)
      if (auto& image = (material.*slot).image; image != kNone) image = place[image];
  if (!decode) return {};
  return decodeAll(jobs, scene.images);
}

}  // namespace tessera
