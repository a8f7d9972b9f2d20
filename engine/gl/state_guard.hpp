// Saves the GL state that the engine touches and puts it back: for contexts that belong to a host.
#pragma once

#include <memory>
#include <optional>

#include "engine/gl/context.hpp"

namespace tessera::gl {

/// State at construction is restored at destruction, on the same context (core profile); in between, pixels
/// in client memory are tightly packed, and the rest is what the engine sets as it needs it. Covered is what
/// the engine's draws, dispatches and readbacks set, and nothing else; the tables in state_guard.cpp list it.
/// The host must not have a query, conditional rendering or transform feedback active: those cannot be saved.
/// A program that the host has deleted while it is current is gone afterwards, and none is current then.
class StateGuard {
 public:
  StateGuard();
  ~StateGuard();
  StateGuard(const StateGuard&) = delete;
  StateGuard& operator=(const StateGuard&) = delete;

 private:
  struct Saved;
  std::unique_ptr<Saved> saved_;
};

/// A guard where the context is a host's; nothing where it is the engine's own.
inline std::optional<StateGuard> guardHost(const Context& context) {
  return context.info().backend == Backend::Host ? std::optional<StateGuard>(std::in_place) : std::nullopt;
}

}  // namespace tessera::gl
