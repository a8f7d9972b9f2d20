// The experiments of Mueller 2021, sec. 7.2.2 to 7.2.4, on one scene.
#pragma once

#include <string>

#include "apps/tessera/study/recorder.hpp"

namespace tessera::app {

/// What a method's name on the command line says, and what a report calls it.
struct StudyMethodName {
  const char* option;
  const char* title;
  bool atlas;
};
const std::vector<StudyMethodName>& studyMethods();

/// Measures every method of the settings. `engine` has the atlas and forward in its plan. Truth, methods and
/// videos are filled in; the caller says the rest.
Result<void> measureStudy(const gl::Context& context, Engine& engine, const StudyPath& path,
                          const StudySettings& settings, StudyScene& scene);

}  // namespace tessera::app
