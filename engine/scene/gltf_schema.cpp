// What checkGltfSchema knows about glTF 2.0, as tables: one row a property that the loader reads.
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "engine/scene/gltf_document.hpp"

namespace tessera {
namespace {

using Json = nlohmann::json;

enum class Kind : std::uint8_t {
  Integer,    // in [min, max]
  Number,     // in [min, max]
  Boolean,    //
  String,     // one of `words` (separated by spaces) if there are any
  Index,      // of an element of the array `target`
  Numbers,    // an array of `length` numbers in [min, max]; any length if 0
  Indices,    // an array of indices
  IndexMap,   // an object whose values are indices
  IndexMaps,  // an array of those
  Strings,    // an array of strings
  Object,     // with `fields`
  Objects,    // an array of objects with `fields`
};

struct Field {
  const char* name = "";
  Kind kind = Kind::Object;
  bool required = false;
  double min = 0.0;
  double max = 0.0;
  const char* words = "";  // String: what it may be. Index...: the target array. Objects: what one is called
  std::size_t length = 0;
  std::span<const Field> fields{};
};

constexpr double kMaxInt = 2147483647.0;          // what tinygltf keeps as int
constexpr double kMaxBytes = 9007199254740992.0;  // 2^53: sizes and offsets; what they span is checked later

constexpr Field integer(const char* name, double min, double max, bool required = false) {
  return {.name = name, .kind = Kind::Integer, .required = required, .min = min, .max = max};
}
constexpr Field number(const char* name, double min = -FLT_MAX, double max = FLT_MAX, bool required = false) {
  return {.name = name, .kind = Kind::Number, .required = required, .min = min, .max = max};
}
constexpr Field numbers(const char* name, std::size_t length, double min = -FLT_MAX, double max = FLT_MAX) {
  return {.name = name, .kind = Kind::Numbers, .min = min, .max = max, .length = length};
}
constexpr Field boolean(const char* name) { return {.name = name, .kind = Kind::Boolean}; }
constexpr Field string(const char* name, const char* words = "", bool required = false) {
  return {.name = name, .kind = Kind::String, .required = required, .words = words};
}
constexpr Field index(const char* name, const char* target, bool required = false) {
  return {.name = name, .kind = Kind::Index, .required = required, .words = target};
}
constexpr Field indices(Kind kind, const char* name, const char* target, bool required = false) {
  return {.name = name, .kind = kind, .required = required, .words = target};
}
constexpr Field object(const char* name, std::span<const Field> fields, bool required = false) {
  return {.name = name, .kind = Kind::Object, .required = required, .fields = fields};
}
constexpr Field objects(const char* name, const char* one, std::span<const Field> fields,
                        bool required = false) {
  return {.name = name, .kind = Kind::Objects, .required = required, .words = one, .fields = fields};
}

constexpr double kHalfPi = 1.57079632679489661923;

constexpr Field kAsset[] = {string("version", "", true), string("minVersion")};

constexpr Field kBuffer[] = {integer("byteLength", 1, kMaxBytes, true), string("uri")};
constexpr Field kBufferView[] = {index("buffer", "buffers", true), integer("byteOffset", 0, kMaxBytes),
                                 integer("byteLength", 1, kMaxBytes, true), integer("byteStride", 4, 252)};

constexpr Field kSparseIndices[] = {index("bufferView", "bufferViews", true),
                                    integer("byteOffset", 0, kMaxInt),
                                    integer("componentType", 5121, 5125, true)};
constexpr Field kSparseValues[] = {index("bufferView", "bufferViews", true),
                                   integer("byteOffset", 0, kMaxInt)};
constexpr Field kSparse[] = {integer("count", 1, kMaxInt, true), object("indices", kSparseIndices, true),
                             object("values", kSparseValues, true)};
constexpr Field kAccessor[] = {index("bufferView", "bufferViews"),
                               integer("byteOffset", 0, kMaxBytes),
                               integer("componentType", 5120, 5126, true),
                               boolean("normalized"),
                               integer("count", 1, kMaxBytes, true),
                               string("type", "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4", true),
                               object("sparse", kSparse)};

constexpr Field kPrimitive[] = {indices(Kind::IndexMap, "attributes", "accessors", true),
                                index("indices", "accessors"), index("material", "materials"),
                                integer("mode", 0, 6), indices(Kind::IndexMaps, "targets", "accessors")};
constexpr Field kMesh[] = {objects("primitives", "primitive", kPrimitive, true)};

constexpr Field kNodeLight[] = {index("light", "lights", true)};
constexpr Field kNodeExtensions[] = {object("KHR_lights_punctual", kNodeLight)};
constexpr Field kNode[] = {index("camera", "cameras"),
                           indices(Kind::Indices, "children", "nodes"),
                           index("skin", "skins"),
                           numbers("matrix", 16),
                           index("mesh", "meshes"),
                           numbers("rotation", 4),
                           numbers("scale", 3),
                           numbers("translation", 3),
                           object("extensions", kNodeExtensions)};
constexpr Field kScene[] = {indices(Kind::Indices, "nodes", "nodes")};
constexpr Field kSkin[] = {index("inverseBindMatrices", "accessors"), index("skeleton", "nodes"),
                           indices(Kind::Indices, "joints", "nodes", true)};

constexpr Field kSampler[] = {integer("magFilter", 9728, 9729), integer("minFilter", 9728, 9987),
                              integer("wrapS", 10497, 33648), integer("wrapT", 10497, 33648)};
constexpr Field kImage[] = {string("uri"), string("mimeType"), index("bufferView", "bufferViews")};
constexpr Field kTexture[] = {index("sampler", "samplers"), index("source", "images")};

constexpr Field kTextureTransform[] = {numbers("offset", 2), number("rotation"), numbers("scale", 2),
                                       integer("texCoord", 0, kMaxInt)};
constexpr Field kSlotExtensions[] = {object("KHR_texture_transform", kTextureTransform)};
constexpr Field kSlot[] = {index("index", "textures", true), integer("texCoord", 0, kMaxInt), number("scale"),
                           number("strength", 0, 1), object("extensions", kSlotExtensions)};
constexpr Field kPbr[] = {numbers("baseColorFactor", 4, 0, 1), object("baseColorTexture", kSlot),
                          number("metallicFactor", 0, 1), number("roughnessFactor", 0, 1),
                          object("metallicRoughnessTexture", kSlot)};
constexpr Field kEmissiveStrength[] = {number("emissiveStrength", 0)};
constexpr Field kMaterialExtensions[] = {object("KHR_materials_unlit", {}),
                                         object("KHR_materials_emissive_strength", kEmissiveStrength)};
constexpr Field kMaterial[] = {object("pbrMetallicRoughness", kPbr),
                               object("normalTexture", kSlot),
                               object("occlusionTexture", kSlot),
                               object("emissiveTexture", kSlot),
                               numbers("emissiveFactor", 3, 0, 1),
                               string("alphaMode", "OPAQUE MASK BLEND"),
                               number("alphaCutoff", 0),
                               boolean("doubleSided"),
                               object("extensions", kMaterialExtensions)};

constexpr Field kPerspective[] = {number("yfov", FLT_MIN, FLT_MAX, true),
                                  number("znear", FLT_MIN, FLT_MAX, true), number("zfar", FLT_MIN)};
constexpr Field kOrthographic[] = {number("xmag", -FLT_MAX, FLT_MAX, true),
                                   number("ymag", -FLT_MAX, FLT_MAX, true), number("zfar", 0, FLT_MAX, true),
                                   number("znear", 0, FLT_MAX, true)};
constexpr Field kCamera[] = {string("type", "perspective orthographic", true),
                             object("perspective", kPerspective), object("orthographic", kOrthographic)};

constexpr Field kSpot[] = {number("innerConeAngle", 0, kHalfPi), number("outerConeAngle", 0, kHalfPi)};
constexpr Field kLight[] = {string("type", "directional point spot", true), numbers("color", 3, 0),
                            number("intensity", 0), number("range", FLT_MIN), object("spot", kSpot)};
constexpr Field kLights[] = {objects("lights", "light", kLight, true)};
constexpr Field kRootExtensions[] = {object("KHR_lights_punctual", kLights)};

constexpr Field kTarget[] = {index("node", "nodes"), string("path", "", true)};
constexpr Field kChannel[] = {integer("sampler", 0, kMaxInt, true), object("target", kTarget, true)};
constexpr Field kAnimationSampler[] = {index("input", "accessors", true), index("output", "accessors", true),
                                       string("interpolation", "LINEAR STEP CUBICSPLINE")};
constexpr Field kAnimation[] = {objects("channels", "channel", kChannel, true),
                                objects("samplers", "sampler", kAnimationSampler, true)};

constexpr Field kRoot[] = {
    object("asset", kAsset, true),
    indices(Kind::Strings, "extensionsRequired", ""),
    indices(Kind::Strings, "extensionsUsed", ""),
    objects("buffers", "buffer", kBuffer),
    objects("bufferViews", "bufferView", kBufferView),
    objects("accessors", "accessor", kAccessor),
    objects("meshes", "mesh", kMesh),
    objects("nodes", "node", kNode),
    index("scene", "scenes"),
    objects("scenes", "scene", kScene),
    objects("skins", "skin", kSkin),
    objects("samplers", "sampler", kSampler),
    objects("images", "image", kImage),
    objects("textures", "texture", kTexture),
    objects("materials", "material", kMaterial),
    objects("cameras", "camera", kCamera),
    object("extensions", kRootExtensions),
    objects("animations", "animation", kAnimation),
};

bool isWord(std::string_view words, std::string_view word) {
  while (!words.empty()) {
    const std::size_t end = words.find(' ');
    if (words.substr(0, end) == word) return true;
    words.remove_prefix(end == std::string_view::npos ? words.size() : end + 1);
  }
  return false;
}

/// Walks the tables and the document side by side.
class Checker {
 public:
  Checker(std::string file, const Json& root) : file_(std::move(file)), root_(root) {}

  /// `where` is the element so far ("mesh 3, primitive 0"), `path` the objects inside it ("sparse.indices.").
  Result<void> check(std::span<const Field> fields, Json& json, const std::string& where,
                     const std::string& path) const {
    for (const Field& field : fields) {
      const auto found = json.find(field.name);
      if (found == json.end()) {
        if (field.required) return fail("{} is missing", place(where, path + field.name));
        continue;
      }
      if (auto ok = checkField(field, *found, where, path + field.name); !ok) return ok;
    }
    return {};
  }

 private:
  [[nodiscard]] std::string place(const std::string& where, const std::string& path) const {
    return where.empty() ? fmt::format("{}: {}", file_, path) : fmt::format("{}: {}: {}", file_, where, path);
  }

  [[nodiscard]] tl::unexpected<Error> wrongType(const std::string& place, const Json& json,
                                                const char* expected) const {
    return fail("{} is not {}: {}", place, expected,
                printable(json.is_structured() ? json.type_name() : json.dump()));
  }

  [[nodiscard]] std::size_t targetCount(std::string_view target) const {
    if (target == "lights") {
      static const Json::json_pointer pointer("/extensions/KHR_lights_punctual/lights");
      return root_.contains(pointer) ? root_.at(pointer).size() : 0;
    }
    const auto found = root_.find(target);
    return found == root_.end() || !found->is_array() ? 0 : found->size();
  }

  Result<void> checkInteger(const std::string& place, Json& json, double min, double max) const {
    if (!json.is_number()) return wrongType(place, json, "an integer");
    const auto value = json.get<double>();
    if (value != std::floor(value)) return wrongType(place, json, "an integer");
    if (!(value >= min && value <= max))
      return fail("{} {} is not in [{}, {}]", place, json.dump(), min, max);
    if (json.is_number_float()) json = static_cast<std::int64_t>(value);
    return {};
  }

  Result<void> checkNumber(const std::string& place, const Json& json, double min, double max) const {
    if (!json.is_number()) return wrongType(place, json, "a number");
    const auto value = json.get<double>();
    if (!(value >= min && value <= max))
      return fail("{} {} is not in [{}, {}]", place, json.dump(), min, max);
    return {};
  }

  Result<void> checkIndex(const std::string& place, Json& json, const char* target) const {
    if (auto ok = checkInteger(place, json, 0, kMaxInt); !ok) return ok;
    const std::size_t count = targetCount(target);
    if (json.get<std::size_t>() >= count)
      return fail("{} {} is past {} {}", place, json.dump(), count, target);
    return {};
  }

  Result<void> checkIndexMap(const std::string& place, Json& json, const char* target) const {
    if (!json.is_object()) return wrongType(place, json, "an object");
    for (auto& [key, value] : json.items())
      if (auto ok = checkIndex(fmt::format("{}.{}", place, printable(key)), value, target); !ok) return ok;
    return {};
  }

  /// Calls `one(place, element)` for all elements of an array.
  template <class One>
  Result<void> each(const std::string& place, Json& json, const One& one) const {
    if (!json.is_array()) return wrongType(place, json, "an array");
    for (std::size_t i = 0; i < json.size(); ++i)
      if (auto ok = one(fmt::format("{}[{}]", place, i), json[i]); !ok) return ok;
    return {};
  }

  Result<void> checkField(const Field& field, Json& json, const std::string& where,
                          const std::string& path) const {
    const std::string at = place(where, path);
    switch (field.kind) {
      case Kind::Integer:
        return checkInteger(at, json, field.min, field.max);
      case Kind::Number:
        return checkNumber(at, json, field.min, field.max);
      case Kind::Boolean:
        if (!json.is_boolean()) return wrongType(at, json, "true or false");
        return {};
      case Kind::String:
        return checkString(at, json, field.words);
      case Kind::Index:
        return checkIndex(at, json, field.words);
      case Kind::Numbers:
        if (json.is_array() && field.length != 0 && json.size() != field.length)
          return fail("{} has {} numbers, not {}", at, json.size(), field.length);
        return each(at, json, [&](const std::string& place, Json& value) {
          return checkNumber(place, value, field.min, field.max);
        });
      case Kind::Indices:
        return each(at, json, [&](const std::string& place, Json& value) {
          return checkIndex(place, value, field.words);
        });
      case Kind::IndexMap:
        return checkIndexMap(at, json, field.words);
      case Kind::IndexMaps:
        return each(at, json, [&](const std::string& place, Json& value) {
          return checkIndexMap(place, value, field.words);
        });
      case Kind::Strings:
        return each(at, json,
                    [&](const std::string& place, Json& value) { return checkString(place, value, ""); });
      case Kind::Object:
        if (!json.is_object()) return wrongType(at, json, "an object");
        return check(field.fields, json, where, path + ".");
      case Kind::Objects:
        return checkObjects(field, json, where, path);
    }
    return {};
  }

  Result<void> checkString(const std::string& place, const Json& json, const char* words) const {
    if (!json.is_string()) return wrongType(place, json, "a string");
    if (*words != '\0' && !isWord(words, json.get_ref<const std::string&>()))
      return fail("{} {} is not one of {}", place, printable(json.dump()), words);
    return {};
  }

  Result<void> checkObjects(const Field& field, Json& json, const std::string& where,
                            const std::string& path) const {
    if (!json.is_array()) return wrongType(place(where, path), json, "an array");
    for (std::size_t i = 0; i < json.size(); ++i) {
      const std::string element = fmt::format("{}{}{} {}", where, where.empty() ? "" : ", ", field.words, i);
      if (!json[i].is_object()) return wrongType(fmt::format("{}: {}", file_, element), json[i], "an object");
      if (auto ok = check(field.fields, json[i], element, ""); !ok) return ok;
    }
    return {};
  }

  std::string file_;
  const Json& root_;
};

/// The rules that the tables cannot say: a multiple, and properties that another one asks for.
Result<void> checkPairs(const std::string& file, const Json& json) {
  const Json none = Json::array();
  const auto list = [&](const char* key) -> const Json& { return json.contains(key) ? json[key] : none; };
  for (std::size_t i = 0; i < list("bufferViews").size(); ++i) {
    const int stride = list("bufferViews")[i].value("byteStride", 4);
    if (stride % 4 != 0)
      return fail("{}: bufferView {}: byteStride {} is not a multiple of 4", file, i, stride);
  }
  for (std::size_t i = 0; i < list("cameras").size(); ++i) {
    const Json& camera = list("cameras")[i];
    const auto type = camera["type"].get<std::string>();
    if (!camera.contains(type)) return fail("{}: camera {}: {} is missing", file, i, type);
  }
  const Json::json_pointer lights("/extensions/KHR_lights_punctual/lights");
  for (std::size_t i = 0; json.contains(lights) && i < json[lights].size(); ++i) {
    const Json& light = json[lights][i];
    if (light["type"] == "spot" && !light.contains("spot"))
      return fail("{}: light {}: spot is missing", file, i);
  }
  return {};
}

}  // namespace

Result<void> checkGltfSchema(const std::string& file, nlohmann::json& json) {
  if (auto ok = Checker(file, json).check(kRoot, json, "", ""); !ok) return ok;
  return checkPairs(file, json);
}

}  // namespace tessera
