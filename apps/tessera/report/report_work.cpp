#include <algorithm>
#include <cmath>

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
double between(const std::vector<ReportCurvePoint>& curve, double ReportCurvePoint::*from,
               double ReportCurvePoint::*to, double at) {
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const double low = curve[i].*from;
    const double high = curve[i + 1].*from;
    if ((at - low) * (at - high) > 0.0) continue;
    const double share = high == low ? 0.0 : (at - low) / (high - low);
    return curve[i].*to + share * (curve[i + 1].*to - curve[i].*to);
  }
  return kNotMeasured;
}

}  // namespace

double curveMssimAt(const ReportMethod& method, double samplesPerPixel) {
  return between(method.curve, &ReportCurvePoint::samplesPerPixel, &ReportCurvePoint::mssim, samplesPerPixel);
}

double curveSamplesAt(const ReportMethod& method, double mssim) {
  return between(method.curve, &ReportCurvePoint::mssim, &ReportCurvePoint::samplesPerPixel, mssim);
}

}  // namespace tessera
