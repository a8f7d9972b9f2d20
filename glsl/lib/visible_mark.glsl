// The visible list, and how an element comes into it once: it is appended by whoever marks it first.
layout(std430, binding = BIND_VISIBLE) buffer Visible { uint visibleCount; uint visibleIds[]; };
layout(std430, binding = BIND_VISIBLE_MARK) coherent buffer Marks { uint marks[]; };
layout(location = LOCATION_FRAME) uniform uint uFrame;

#ifdef TRIANGLES
uint elementOf(uint id) { return id - 4u; }  // see triangleNumber
#else
uint elementOf(uint id) { return (id >> 2u) - 1u; }
#endif

void markVisible(uint element) {
  if (marks[element] == uFrame) return;
  if (atomicExchange(marks[element], uFrame) == uFrame) return;
  visibleIds[atomicAdd(visibleCount, 1u)] = element;
}
