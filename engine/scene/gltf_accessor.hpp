// Checked access to the accessors of a glTF file: after `check` has passed, reading cannot fail.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.hpp"
#include "engine/scene/gltf_resource.hpp"
#include "engine/scene/gltf_tinygltf.hpp"

namespace tessera {

class GltfAccessors {
 public:
  /// Checks every buffer view and accessor of the model, used or not: extents within what they are cut from,
  /// strides, alignment, and the indices of sparse accessors. An accessor without buffer view may have 2^24
  /// elements at most. `model` and `buffers` must outlive the result.
  static Result<GltfAccessors> check(const std::string& file, const tinygltf::Model& model,
                                     std::span<const GltfBuffer> buffers);

  /// Components an element: 1 to 16.
  [[nodiscard]] std::size_t components(int accessor) const;
  [[nodiscard]] std::size_t count(int accessor) const;
  [[nodiscard]] const tinygltf::Accessor& description(int accessor) const;
  /// The bytes of a buffer view; none if its buffer has none.
  [[nodiscard]] std::span<const std::uint8_t> view(int bufferView) const;

  /// Elements as floats, `components` an element; integers of a normalized accessor become [0, 1] or [-1, 1]
  /// (glTF 2.0 sec. 3.11). With `elements`, only those, in that order; each must be below `count`.
  [[nodiscard]] std::vector<float> floats(int accessor) const;
  [[nodiscard]] std::vector<float> floats(int accessor, std::span<const std::uint32_t> elements) const;
  /// Elements of an accessor of unsigned integers (asserted), one component an element.
  [[nodiscard]] std::vector<std::uint32_t> integers(int accessor) const;

 private:
  GltfAccessors(const tinygltf::Model& model, std::span<const GltfBuffer> buffers)
      : model_(&model), buffers_(buffers) {}

  [[nodiscard]] Result<void> checkOne(const std::string& what, const tinygltf::Accessor& accessor) const;
  [[nodiscard]] Result<void> checkSparse(const std::string& what, const tinygltf::Accessor& accessor) const;
  [[nodiscard]] Result<void> checkData(const std::string& what, int bufferView) const;
  template <class Out>
  [[nodiscard]] std::vector<Out> readAll(int accessor) const;

  const tinygltf::Model* model_;
  std::span<const GltfBuffer> buffers_;
};

}  // namespace tessera
