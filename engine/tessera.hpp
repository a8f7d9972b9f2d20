// What a host includes.
#pragma once

#include "engine/frame/engine.hpp"
#include "engine/gl/context.hpp"
#include "engine/scene/gltf.hpp"
#include "engine/scene/stage.hpp"
