#include "engine/measure/metrics.hpp"
