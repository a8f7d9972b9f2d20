// The part of a report on what atlases hold and cost: tables after Hladky 2019, tables 2 to 4.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// Kinds of samples that any method of the scene has, in order of first appearance; empty without an atlas.
std::vector<std::string> kindNames(const ReportScene& scene);
/// Samples of a kind; not a number for a method without it.
double samplesOfKind(const ReportMethod& method, const std::string& kind);

/// What a method's record holds besides, as members.
nlohmann::ordered_json atlasJson(const ReportScene& scene, const ReportMethod& method);
/// What a row of a moving camera holds besides its method's record.
nlohmann::ordered_json pvsJson(const ReportScene& scene, const ReportPvsRow& row);
/// Numbers of the crops, without pictures.
nlohmann::ordered_json cropsJson(const ReportScene& scene);
/// The scene's tables: what atlases hold and cost, moving cameras, and what the curves say at equal samples
/// and at equal quality. Those without rows are left out.
std::string atlasTables(const ReportScene& scene);

}  // namespace tessera
