#include "atlas/rect/patches.hpp"
