#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

#include "apps/tessera/report/report.hpp"
#include "engine/measure/metrics.hpp"

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

const ReportMethod* methodNamed(const ReportScene& scene, std::string_view name) {
  const auto found = std::find_if(scene.methods.begin(), scene.methods.end(),
                                  [&](const ReportMethod& method) { return method.name == name; });
  return found == scene.methods.end() ? nullptr : &*found;
}

const ReportMethod* referenceOf(const ReportScene& scene, const ReportMethod& method) {
  return methodNamed(scene, method.reference);
}

double perSampleAgainstPassed(const ReportScene& scene, const ReportMethod& method) {
  const ReportMethod* reference = referenceOf(scene, method);
  const double own = std::isnan(method.nsPerPassed) ? method.nsPerSample : method.nsPerPassed;
  return reference == nullptr ? kNotMeasured : own / reference->nsPerPassed;
}

double perSampleAgainstInvocation(const ReportScene& scene, const ReportMethod& method) {
  const ReportMethod* reference = referenceOf(scene, method);
  return reference == nullptr ? kNotMeasured : method.nsPerSample / reference->nsPerSample;
}

double displayAgainstAtlas(const ReportScene& scene, const ReportMethod& method) {
  const ReportMethod* reference = methodNamed(scene, scene.atlasReference);
  if (reference == nullptr || method.displayMs.count == 0 || reference->views != method.views)
    return kNotMeasured;
  return method.displayMs.median / reference->displayMs.median;
}

double wastedTexels(const ReportMethod& method) { return method.takenTexels - method.samplesShaded; }

double decodeBytesPerTriangle(const ReportMethod& method) {
  return method.decodeBytes / method.visibleTriangles;
}

double displayBytesPerTriangle(const ReportMethod& method) {
  return method.displayBytes / method.visibleTriangles;
}

double dssimOf(const ReportMethod& method) { return dssim(method.mssim); }

double biasInForce(const ReportMethod& method) {
  double sum = 0.0;
  for (const double bias : method.series.bias) sum += bias;
  return sum / static_cast<double>(method.series.bias.size());
}

double samplesAgainstPlain(const ReportScene& scene, const ReportPvsRow& row) {
  const ReportMethod* plain = methodNamed(scene, row.pvs.method);
  return plain == nullptr ? kNotMeasured : row.method.samplesShaded / plain->samplesShaded;
}

double dssimAgainstPlain(const ReportScene& scene, const ReportPvsRow& row) {
  const ReportMethod* plain = methodNamed(scene, row.pvs.method);
  return plain == nullptr ? kNotMeasured : dssimOf(row.method) / dssimOf(*plain);
}

namespace {

/// `to` where `from` is `at`, on the line through the points, whichever way they are sorted.
double between(const std::vector<glm::dvec2>& points, double at, int from) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const glm::dvec2 step = points[i + 1] - points[i];
    if ((at - points[i][from]) * (at - points[i + 1][from]) > 0.0) continue;
    return points[i][1 - from] +
           (step[from] == 0.0 ? 0.0 : (at - points[i][from]) / step[from]) * step[1 - from];
  }
  return kNotMeasured;
}

/// Quality over the logarithm of samples is nearly straight.
std::vector<glm::dvec2> pointsOf(const ReportMethod& method) {
  std::vector<glm::dvec2> points;
  for (const ReportCurvePoint& point : method.curve)
    points.emplace_back(std::log2(point.samplesPerPixel), point.mssim);
  return points;
}

}  // namespace

double curveMssimAt(const ReportMethod& method, double samplesPerPixel) {
  return between(pointsOf(method), std::log2(samplesPerPixel), 0);
}

double curveSamplesAt(const ReportMethod& method, double mssim) {
  return std::exp2(between(pointsOf(method), mssim, 1));
}

}  // namespace tessera
