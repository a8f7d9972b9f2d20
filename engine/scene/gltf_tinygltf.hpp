// The one way this library includes tinygltf: without its file access, image codecs and exceptions, and under
// a namespace of its own, so that a host which links another tinygltf does not clash with it.
#pragma once

#define TINYGLTF_NOEXCEPTION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#define tinygltf tessera_tinygltf
#include <tiny_gltf.h>
#undef tinygltf

namespace tessera {
namespace tinygltf = ::tessera_tinygltf;
}  // namespace tessera
