#include "engine/gl/state_guard.hpp"

namespace tessera::gl {
struct StateGuard::Saved {};
StateGuard::StateGuard() : saved_(std::make_unique<Saved>()) {}
StateGuard::~StateGuard() = default;
}  // namespace tessera::gl
