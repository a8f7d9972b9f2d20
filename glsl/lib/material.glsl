// The material of the batch that is drawn: one record, bound as a range of the buffer of all materials.
layout(std140, binding = BIND_MATERIAL) uniform Material { MaterialGpu material; };
