// Gathering by tessellation: a patch of one vertex a piece of work, see tess_spawn.tesc.
#define STAGE_VERTEX
layout(location = 0) flat out uint vPiece;
void main() { vPiece = uint(gl_VertexID); }
