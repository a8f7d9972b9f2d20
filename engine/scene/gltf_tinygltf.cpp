#include <fstream>  // tinygltf forgets it when it is told to open no files

#define TINYGLTF_IMPLEMENTATION
#include "engine/scene/gltf_tinygltf.hpp"
