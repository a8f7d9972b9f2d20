// The dialect that compiles as C++20 and as GLSL: no swizzles, no GLSL keywords as names, float literals without f.
#ifndef TESSERA_GLSL_SHARED_DIALECT_H
#define TESSERA_GLSL_SHARED_DIALECT_H

#ifdef __cplusplus
#include <bit>
#include <cmath>
#include <cstdint>

#include <glm/glm.hpp>
namespace tessera::glsl {
using glm::mat3;
using glm::mat4;
using glm::uvec2;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = std::uint32_t;
}  // namespace tessera::glsl
#define TESSERA_SHARED_BEGIN namespace tessera::glsl {
#define TESSERA_SHARED_END }
#define SHARED_FN inline
#define SHARED_CONST inline constexpr
#else
#define TESSERA_SHARED_BEGIN
#define TESSERA_SHARED_END
#define SHARED_FN
#define SHARED_CONST const
#endif

#endif
