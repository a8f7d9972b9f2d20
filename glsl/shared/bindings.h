// Every buffer binding of the engine, in one place. Numbers only; the preprocessor of both languages reads it.
#ifndef TESSERA_GLSL_SHARED_BINDINGS_H
#define TESSERA_GLSL_SHARED_BINDINGS_H

// Shader storage: the scene
#define BIND_POSITIONS 0       // float[3 * vertices]
#define BIND_NORMALS 1         // float[3 * vertices]
#define BIND_TANGENTS 2        // vec4[vertices]
#define BIND_UV0 3             // vec2[vertices]
#define BIND_UV1 4             // vec2[vertices]
#define BIND_COLORS 5          // vec4[vertices]
#define BIND_INSTANCES 6       // InstanceGpu[]
#define BIND_PATCHES 7         // PatchGeometry[]
#define BIND_PATCH_INSTANCE 8  // uint[patch instances]: which InstanceGpu

// Shader storage: the rectangular atlas (more below)
#define BIND_ATLAS_SUPERBLOCKS 9 // uint[2 * superblocks]: the stack of free ones; texels live in each (without block stacks)
#define BIND_ATLAS_MERGE 10      // uint[]: a bit for each pair of texels, see rect_merge.comp

// Shader storage: the visible set
#define BIND_VISIBLE 11      // uint count, then uint[] patch-instance ids
#define BIND_VISIBLE_MARK 12 // uint[patch instances]: the frame in which it was last visible

// Shader storage: the rectangular atlas
#define BIND_PATCH_STATE 13   // PatchState[patch instances]
#define BIND_ATLAS_STATE 14   // AtlasState: counters, bias, carried-over superblocks
#define BIND_ATLAS_STACKS 15  // uint[]: entries of all block stacks
#define BIND_PATCH_MEASURE 16 // PatchMeasure[visible]
#define BIND_ATLAS_LIVE 17    // uint count, then uint[] patch-instance ids that may hold a block

// Shader storage: drawing of the visible set
#define BIND_DRAW_ENTRIES 18  // uint[]: what the gather and display passes draw
#define BIND_DRAW_COMMANDS 19 // DrawCommand[batches]
#define BIND_DRAW_VERTICES 20 // DisplayVertex[]
#define BIND_BATCHES 21       // BatchGpu[]

#define BIND_GATHER_VERTICES 22 // GatherVertex[]

#define BIND_SPLIT_PIECES 23       // TessPieceGpu[kSplitNumbers]

#define BIND_DISPATCH 24        // uint[4]: groups of 64 over the visible list, pixels that show nothing

// Shader storage: the tessellation gatherer's atlas. It has the rectangular one's bindings for what is alike, and:
#define BIND_TESS_BINS 9   // TessBin[]
#define BIND_TESS_RUNS 10  // TessRun[]
// and when it shades, of those that only memory phases read:
#define BIND_TESS_STARTS 13  // uint[entries]
#define BIND_TESS_GROUPS 14  // TessGroups[batches]
#define BIND_TESS_PIECES 15  // uvec2[]
#define BIND_TESS_SAMPLES 16 // uint[samples]: entry of each
// and when it writes what display draws:
#define BIND_TESS_CORNERS 16 // TessCorner[3 * triangles]

// and when it splits triangles, of those that memory phases use:
#define BIND_SPLIT_STATE 9      // TessSplitState, uint[batches]: pieces of each
#define BIND_SPLIT_ELEMENTS 10  // as BIND_VISIBLE: triangles and pieces

// Shader storage: Texel Shading's atlas. As above, and:
#define BIND_TEXEL_TABLE 9     // uint[]: of two tables, places of a number and a slot
#define BIND_TEXEL_BATCHES 10  // TexelBatch[]
#define BIND_TEXEL_CHARTS 13   // TexelChart[patch instances]
#define BIND_TEXEL_WANTED 16   // uvec2[]: tiles before they have slots
#define BIND_TEXEL_TILES 17    // TexelTile[2 * slots]
// and when it shades, of those that only memory phases read:
#define BIND_TEXEL_QUEUE 15    // TexelTile[slots]

// Shader storage: planes of video. Where they are made and read nothing of a scene is bound.
#define BIND_YUV_PLANES 9      // YuvHeader, uint[]

// Shader storage while the visible set is found:
#define BIND_VISIBLE_PIXELS 18 // uint[patch instances or triangles]: how many pixels show it
#define BIND_VISIBLE_SEEN 19   // uint[]: the same, in the order of the visible list

// Shader storage while a picture is warped: the nearest depth in it, as bits
#define BIND_WARP_NEAREST 9

#define BIND_STORAGE_COUNT 25   // of the above

// Uniform buffers
#define BIND_VIEWS 0
#define BIND_FRAME 1
#define BIND_LIGHTS 2    // LightGpu[kMaxLights]
#define BIND_SHADOWS 3   // ShadowGpu[kMaxShadowLayers]
#define BIND_MATERIAL 4  // one MaterialGpu
#define BIND_DENSITY 5   // DensityGpu[views], with foveation or a lens only
#define BIND_UNIFORM_COUNT 6
#define ID_VIEWS 8       // ViewGpu in BIND_VIEWS, at most

// Texture units
#define UNIT_MATERIAL 0  // five, one a slot of MaterialGpu
#define UNIT_SHADOW 5
#define UNIT_ATLAS 6
#define UNIT_PICTURE 6   // no pass reads both
#define UNIT_ID 7
#define UNIT_DEPTH 8
#define UNIT_COUNT 9

// Uniform locations
#define LOCATION_VIEW 1
#define LOCATION_COUNT 2
#define LOCATION_SIZE 3
#define LOCATION_FRAME 4
#define LOCATION_BACKGROUND 5
#define LOCATION_LENS 6
#define LOCATION_CHANNELS 7
#define LOCATION_TEXTURE_BIAS 8
#define LOCATION_WARP 9
#define LOCATION_WARP_EYE 10
#define LOCATION_WARP_DEPTH 11

#endif
