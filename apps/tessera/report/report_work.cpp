#include <algorithm>
#include <cmath>

#include "apps/tessera/report/report.hpp"

namespace tessera {

double shadedSamples(const ReportMethod& method) {
  return std::isnan(method.samplesPassed) ? method.samplesShaded : method.samplesPassed;
}

double shadedPerTargetPixel(const ReportScene& scene, const ReportMethod& method) {
  return shadedSamples(method) / (static_cast<double>(scene.width) * scene.height);
}

double shadedPerPicturePixel(const ReportScene& scene, const ReportMethod& method) {
  return shadedPerTargetPixel(scene, method) / method.views;
}

double shadedAgainstReference(const ReportScene& scene, const ReportMethod& method) {
  const ReportMethod* reference = referenceOf(scene, method);
  return reference == nullptr ? kNotMeasured : shadedSamples(method) / shadedSamples(*reference);
}

double passShare(const ReportMethod& method, std::string_view pass) {
  const auto found = std::find_if(method.passes.begin(), method.passes.end(),
                                  [&](const ReportPass& other) { return other.name == pass; });
  return found == method.passes.end() ? kNotMeasured : found->ms.median / method.frameMs.median;
}

double mssimOfRightEye(const ReportMethod& method) {
  return method.mssimViews.size() == 2 ? method.mssimViews[1] : kNotMeasured;
}

const ReportMethod* referenceOf(const ReportScene& scene, const ReportMethod& method) {
  const auto found = std::find_if(scene.methods.begin(), scene.methods.end(),
                                  [&](const ReportMethod& other) { return other.name == method.reference; });
  return found == scene.methods.end() ? nullptr : &*found;
}

}  // namespace tessera
