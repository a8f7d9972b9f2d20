// Shadow maps: one depth layer for a directional or spot light, six for a point light.
layout(binding = UNIT_SHADOW) uniform sampler2DArrayShadow uShadow;
layout(std140, binding = BIND_SHADOWS) uniform Shadows { ShadowGpu shadows[kMaxShadowLayers]; };

uint cubeFace(vec3 d) {
  vec3 a = abs(d);
  if (a.x >= a.y && a.x >= a.z) return d.x >= 0.0 ? 0u : 1u;
  if (a.y >= a.z) return d.y >= 0.0 ? 2u : 3u;
  return d.z >= 0.0 ? 4u : 5u;
}

// The share of the light that reaches the point: 0 in shadow, 1 lit. `n` is the geometric side of the surface.
float lightReaching(uint index, vec3 position, vec3 n) {
  uint layer = lights[index].shadowLayer;
  vec3 toPoint = position - lights[index].position.xyz;
  bool cube = lights[index].type == kLightPoint;
  vec4 texel = shadows[layer].texel;  // the same for all faces of a cube
  float reach = texel.y > 0.0 ? length(toPoint) : 1.0;
  // Moving the point off the surface by about a shadow texel keeps it clear of its own depth (normal offset).
  vec3 offset = n * ((1.5 + float(frame.shadowReach)) * texel.x * reach);
  vec3 p = position + offset;
  // The face of the moved point: near a cube's edges the surface's own may not see it.
  if (cube) layer += cubeFace(toPoint + offset);
  vec4 clip = shadows[layer].viewProjection * vec4(p, 1.0);
  if (clip.w <= 0.0) return 1.0;
  vec3 c = clip.xyz / clip.w;
  if (c.z > 1.0) return 1.0;
  // A cube has no outside: what lies past a face's edge does so by rounding, and the texture clamps it.
  if (!cube && (abs(c.x) > 1.0 || abs(c.y) > 1.0)) return 1.0;
  vec2 at = c.xy * 0.5 + 0.5;
  if (frame.shadowReach == 0u) return texture(uShadow, vec4(at, float(layer), c.z));
  // One loop: two in each other smash the stack of lavapipe's tessellation shaders (Mesa 22.3).
  int side = 2 * int(frame.shadowReach) + 1;
  vec2 texelSide = 1.0 / vec2(textureSize(uShadow, 0).xy);
  float sum = 0.0;
  for (int i = 0; i < side * side; ++i) {
    vec2 off = vec2(i % side, i / side) - float(frame.shadowReach);
    sum += texture(uShadow, vec4(at + off * texelSide, float(layer), c.z));
  }
  return sum / float(side * side);
}
