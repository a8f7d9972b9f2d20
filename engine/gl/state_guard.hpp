// Saves the GL state that the engine touches and puts it back: for contexts that belong to a host.
#pragma once

#include <memory>

namespace tessera::gl {

/// State at construction is restored at destruction, on the same context. See state_guard.cpp for what is covered.
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

}  // namespace tessera::gl
