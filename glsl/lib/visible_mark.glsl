// The visible list, and how an element comes into it once: it is appended by whoever marks it first.
layout(std430, binding = BIND_VISIBLE) buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_VISIBLE_MARK) coherent buffer Marks { uint marks[]; };
#ifdef PIXELS
layout(std430, binding = BIND_VISIBLE_PIXELS) buffer Pixels { uint pixelsOf[]; };
#endif
layout(location = LOCATION_FRAME) uniform uint uFrame;

#ifdef TRIANGLES
uint elementOf(uint id) { return id - 4u; }  // see triangleNumber
#else
uint elementOf(uint id) { return (id >> 2u) - 1u; }
#endif

// pixels: that show it here; counted with PIXELS.
void markVisible(uint element, uint pixels) {
#ifdef PIXELS
  atomicAdd(pixelsOf[element], pixels);
#endif
  if (marks[element] == uFrame) return;
  if (atomicExchange(marks[element], uFrame) == uFrame) return;
  visibleIds[atomicAdd(visibleCount, 1u)] = element;
}
