#include "engine/scene/gltf_accessor.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <type_traits>

namespace tessera {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kMaxUnbackedElements = std::size_t{1} << 24;

std::size_t componentSize(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

std::size_t componentCount(int type) {
  return static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
}

/// Bytes of one element. Columns of small matrices start at multiples of 4 (glTF 2.0 sec. 3.6.2.4); the last
/// one of an accessor need not be padded.
struct ElementSize {
  std::size_t padded;
  std::size_t last;
};

ElementSize elementSize(const tinygltf::Accessor& accessor) {
  const std::size_t size = componentSize(accessor.componentType);
  std::size_t rows = 0;
  if (accessor.type == TINYGLTF_TYPE_MAT2) rows = 2;
  if (accessor.type == TINYGLTF_TYPE_MAT3) rows = 3;
  if (accessor.type == TINYGLTF_TYPE_MAT4) rows = 4;
  if (rows == 0) return {size * componentCount(accessor.type), size * componentCount(accessor.type)};
  const std::size_t column = (rows * size + 3) / 4 * 4;
  return {rows * column, (rows - 1) * column + rows * size};
}

/// A run of `count` elements in a buffer view.
struct Run {
  int view = -1;
  std::size_t offset = 0;
  std::size_t count = 0;
  std::size_t size = 0;       // bytes of the last element
  std::size_t stride = 0;     // bytes from one element to the next
  std::size_t alignment = 1;  // of the first element in the buffer
};

std::size_t strideOf(const tinygltf::BufferView& view, std::size_t size) {
  return view.byteStride != 0 ? view.byteStride : size;
}

Run mainRun(const tinygltf::Model& model, const tinygltf::Accessor& accessor) {
  const ElementSize size = elementSize(accessor);
  const auto& view = model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
  return {accessor.bufferView, accessor.byteOffset,         accessor.count,
          size.last,           strideOf(view, size.padded), componentSize(accessor.componentType)};
}

Run sparseIndexRun(const tinygltf::Accessor& accessor) {
  const std::size_t size = componentSize(accessor.sparse.indices.componentType);
  return {accessor.sparse.indices.bufferView,
          static_cast<std::size_t>(accessor.sparse.indices.byteOffset),
          static_cast<std::size_t>(accessor.sparse.count),
          size,
          size,
          size};
}

Run sparseValueRun(const tinygltf::Accessor& accessor) {
  const ElementSize size = elementSize(accessor);
  return {accessor.sparse.values.bufferView,
          static_cast<std::size_t>(accessor.sparse.values.byteOffset),
          static_cast<std::size_t>(accessor.sparse.count),
          size.last,
          size.padded,
          componentSize(accessor.componentType)};
}

/// All values are below 2^53 by the schema, the stride below 253: no product of two overflows 64 bits unseen
/// once the count is known to be below the view's length.
Result<void> checkRun(const std::string& what, const tinygltf::Model& model, const Run& run) {
  const auto& view = model.bufferViews[static_cast<std::size_t>(run.view)];
  if (run.stride < run.size)
    return fail("{}: byteStride {} of bufferView {} is less than the {} bytes of an element", what,
                run.stride, run.view, run.size);
  if ((view.byteOffset + run.offset) % run.alignment != 0 || run.offset % run.alignment != 0)
    return fail("{}: byteOffset {} in bufferView {} at {} is not a multiple of {}", what, run.offset,
                run.view, view.byteOffset, run.alignment);
  if (run.stride % run.alignment != 0)
    return fail("{}: byteStride {} is not a multiple of {}", what, run.stride, run.alignment);
  if (run.count > view.byteLength || run.offset > view.byteLength ||
      run.offset + run.stride * (run.count - 1) + run.size > view.byteLength)
    return fail("{}: {} elements of {} bytes, stride {}, at {} are past the {} bytes of bufferView {}", what,
                run.count, run.size, run.stride, run.offset, view.byteLength, run.view);
  return {};
}

Result<void> checkViews(const std::string& file, const tinygltf::Model& model,
                        std::span<const GltfBuffer> buffers) {
  for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
    const auto& view = model.bufferViews[i];
    const std::size_t bytes = buffers[static_cast<std::size_t>(view.buffer)].length;
    if (view.byteOffset > bytes || view.byteLength > bytes - view.byteOffset)
      return fail("{}: bufferView {}: {} bytes at {} are past the {} bytes of buffer {}", file, i,
                  view.byteLength, view.byteOffset, bytes, view.buffer);
  }
  return {};
}

template <class In>
In load(const std::uint8_t* from) {
  In value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <class Out, class In>
Out convert(In value, bool normalized) {
  if constexpr (std::is_floating_point_v<Out> && std::is_integral_v<In>) {
    if (normalized) {
      // In double: the quotients of 16-bit values round once.
      const double quotient =
          static_cast<double>(value) / static_cast<double>(std::numeric_limits<In>::max());
      return static_cast<Out>(std::max(quotient, -1.0));
    }
  }
  return static_cast<Out>(value);
}

/// Reads the elements `at(0)`, `at(1)`, ... of a run into out; `at` gives the element's number.
template <class In, class Out, class At>
void readRun(const std::uint8_t* first, const Run& run, std::size_t components, bool normalized,
             std::size_t count, const At& at, Out* out) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* element = first + at(i) * run.stride;
    for (std::size_t c = 0; c < components; ++c)
      *out++ = convert<Out>(load<In>(element + c * sizeof(In)), normalized);
  }
}

template <class Out, class At>
std::vector<Out> readRun(Bytes view, const Run& run, int type, std::size_t components, bool normalized,
                         std::size_t count, const At& at) {
  std::vector<Out> out(count * components);
  const std::uint8_t* first = view.data() + run.offset;
  const auto read = [&]<class In>(In) {
    readRun<In>(first, run, components, normalized, count, at, out.data());
  };
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      read(std::int8_t{});
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      read(std::uint8_t{});
      break;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      read(std::int16_t{});
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      read(std::uint16_t{});
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      read(std::uint32_t{});
      break;
    default:
      read(float{});
      break;
  }
  return out;
}

constexpr auto kInOrder = [](std::size_t i) { return i; };

std::vector<std::uint32_t> readSparseIndices(Bytes view, const tinygltf::Accessor& accessor) {
  const Run run = sparseIndexRun(accessor);
  return readRun<std::uint32_t>(view, run, accessor.sparse.indices.componentType, 1, false, run.count,
                                kInOrder);
}

}  // namespace

std::size_t GltfAccessors::components(int accessor) const {
  return componentCount(description(accessor).type);
}
std::size_t GltfAccessors::count(int accessor) const { return description(accessor).count; }
const tinygltf::Accessor& GltfAccessors::description(int accessor) const {
  return model_->accessors[static_cast<std::size_t>(accessor)];
}

std::span<const std::uint8_t> GltfAccessors::view(int bufferView) const {
  const auto& view = model_->bufferViews[static_cast<std::size_t>(bufferView)];
  const std::span<const std::uint8_t> bytes = buffers_[static_cast<std::size_t>(view.buffer)].bytes;
  return bytes.empty() ? bytes : bytes.subspan(view.byteOffset, view.byteLength);
}

Result<void> GltfAccessors::checkOne(const std::string& what, const tinygltf::Accessor& accessor) const {
  if (componentSize(accessor.componentType) == 0)
    return fail("{}: componentType {} is not supported", what, accessor.componentType);
  if (accessor.bufferView >= 0) {
    if (auto ok = checkRun(what, *model_, mainRun(*model_, accessor)); !ok) return ok;
    if (auto ok = checkData(what, accessor.bufferView); !ok) return ok;
  } else if (accessor.count > kMaxUnbackedElements) {
    return fail("{}: count {} without bufferView is past the limit of {}", what, accessor.count,
                kMaxUnbackedElements);
  }
  return accessor.sparse.isSparse ? checkSparse(what + ", sparse", accessor) : Result<void>{};
}

Result<void> GltfAccessors::checkSparse(const std::string& what, const tinygltf::Accessor& accessor) const {
  const auto& sparse = accessor.sparse;
  const int type = sparse.indices.componentType;
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    return fail("{} indices: componentType {} is not an unsigned integer", what, type);
  if (static_cast<std::size_t>(sparse.count) > accessor.count)
    return fail("{}: count {} is past the {} elements", what, sparse.count, accessor.count);
  if (auto ok = checkRun(what + " indices", *model_, sparseIndexRun(accessor)); !ok) return ok;
  if (auto ok = checkRun(what + " values", *model_, sparseValueRun(accessor)); !ok) return ok;
  for (const int view : {sparse.indices.bufferView, sparse.values.bufferView})
    if (auto ok = checkData(what, view); !ok) return ok;
  const auto indices = readSparseIndices(view(sparse.indices.bufferView), accessor);
  for (std::size_t k = 0; k < indices.size(); ++k) {
    if (indices[k] >= accessor.count)
      return fail("{}: index {} is past {} elements", what, indices[k], accessor.count);
    if (k > 0 && indices[k] <= indices[k - 1])
      return fail("{}: index {} does not follow {}", what, indices[k], indices[k - 1]);
  }
  return {};
}

Result<void> GltfAccessors::checkData(const std::string& what, int bufferView) const {
  const int buffer = model_->bufferViews[static_cast<std::size_t>(bufferView)].buffer;
  if (buffers_[static_cast<std::size_t>(buffer)].bytes.empty())
    return fail("{}: buffer {} has no data: its uri is missing", what, buffer);
  return {};
}

Result<GltfAccessors> GltfAccessors::check(const std::string& file, const tinygltf::Model& model,
                                           std::span<const GltfBuffer> buffers) {
  if (auto ok = checkViews(file, model, buffers); !ok) return tl::unexpected(ok.error());
  const GltfAccessors accessors(model, buffers);
  for (std::size_t i = 0; i < model.accessors.size(); ++i)
    if (auto ok = accessors.checkOne(fmt::format("{}: accessor {}", file, i), model.accessors[i]); !ok)
      return tl::unexpected(ok.error());
  return accessors;
}

template <class Out>
std::vector<Out> GltfAccessors::readAll(int index) const {
  const tinygltf::Accessor& accessor = description(index);
  const std::size_t width = components(index);
  std::vector<Out> out;
  if (accessor.bufferView >= 0) {
    const Run run = mainRun(*model_, accessor);
    out = readRun<Out>(view(run.view), run, accessor.componentType, width, accessor.normalized, run.count,
                       kInOrder);
  } else {
    out.resize(accessor.count * width);
  }
  if (accessor.sparse.isSparse) {
    const Run run = sparseValueRun(accessor);
    const auto values = readRun<Out>(view(run.view), run, accessor.componentType, width, accessor.normalized,
                                     run.count, kInOrder);
    const auto indices = readSparseIndices(view(accessor.sparse.indices.bufferView), accessor);
    for (std::size_t k = 0; k < indices.size(); ++k)
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(k * width), width,
                  out.begin() + static_cast<std::ptrdiff_t>(indices[k] * width));
  }
  return out;
}

std::vector<float> GltfAccessors::floats(int accessor) const { return readAll<float>(accessor); }

std::vector<float> GltfAccessors::floats(int index, std::span<const std::uint32_t> elements) const {
  const tinygltf::Accessor& accessor = description(index);
  const std::size_t width = components(index);
  const auto at = [&](std::size_t i) { return elements[i]; };
  if (accessor.bufferView >= 0 && !accessor.sparse.isSparse) {
    const Run run = mainRun(*model_, accessor);
    return readRun<float>(view(run.view), run, accessor.componentType, width, accessor.normalized,
                          elements.size(), at);
  }
  const std::vector<float> all = readAll<float>(index);
  std::vector<float> out(elements.size() * width);
  for (std::size_t i = 0; i < elements.size(); ++i)
    std::copy_n(&all[elements[i] * width], width, &out[i * width]);
  return out;
}

std::vector<std::uint32_t> GltfAccessors::integers(int accessor) const {
  assert(description(accessor).componentType != TINYGLTF_COMPONENT_TYPE_FLOAT && components(accessor) == 1);
  return readAll<std::uint32_t>(accessor);
}

}  // namespace tessera
