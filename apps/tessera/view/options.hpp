// What `tessera view` is asked for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/tessera/options.hpp"
#include "codec/transport/address.hpp"

namespace tessera::app {

struct ViewOptions {
  std::string address;
  transport::Address server;  // `address`, parsed
  std::string token;
  std::string keys;
  SizeChoice size;
  ContextChoice context;  // without a window
  bool headless = false;
  std::string path;  // a file, or the name of a path of the server's stage
  int frames = 0;    // with a picture; 0: with a path its length, else until the window closes
  double fps = 30.0;
  double patience = 20.0;  // seconds without a first picture, headless
  std::string record;
  std::string stats;
  std::string csv;
  bool stereo = false;
  std::optional<std::string> lensText;  // as addLens takes it
  std::optional<Lens> lens;             // `lensText`, parsed
  bool overlay = true;                  // the figures, in a window
  std::vector<double> eye, target;      // three numbers each; without them the server's start camera
  std::optional<double> fovY;           // degrees
};

inline constexpr double kEyeDistance = 0.064;  // metres

/// Without a window, along a path, at `fps`.
Result<void> viewHeadless(const ViewOptions& options);
/// In a window, flown by hand, or along a path where there is one.
Result<void> viewWindow(const ViewOptions& options);

}  // namespace tessera::app
