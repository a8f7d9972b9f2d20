// The experiments of Mueller 2021, sec. 7.2.2 to 7.2.4, on one scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/tessera/study/atlas_stream.hpp"
#include "apps/tessera/study/recorder.hpp"
#include "engine/frame/image_warp.hpp"

namespace tessera::app {

/// What a method's name on the command line says, and what a report calls it.
struct StudyMethodName {
  const char* option;
  const char* title;
  std::optional<Warp> warp;  // else an atlas
};
const std::vector<StudyMethodName>& studyMethods();

/// Measures every method of the settings. `engine` has the atlas, forward, what is blended and visible pixels
/// in its plan; `masks` as AtlasStream::create takes them. Truth, methods and videos are filled in; the
/// caller says the rest.
Result<void> measureStudy(const gl::Context& context, Engine& engine, const StudyPath& path,
                          const StudySettings& settings, AtlasStream::Masks masks, StudyScene& scene);

}  // namespace tessera::app
