// Writes a shaded texel, in the encoding of the atlas. ENCODED: display-encoded values.
#ifdef ENCODED
vec4 atlasValue(vec4 color) { return vec4(encodeSrgb(color.r), encodeSrgb(color.g), encodeSrgb(color.b), color.a); }
#else
vec4 atlasValue(vec4 color) { return color; }
#endif
