// The report of stream-study: how close to the truth a viewer's pictures come, by latency, server rate and
// bitrate, for shading atlases and for warped pictures; as JSON and as one self-contained page.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/tessera/report/report.hpp"

namespace tessera {

/// One method with one setting. Qualities are means over the sampled pictures, against forward of the pose
/// that is shown.
struct StudyPoint {
  double latencyMs = 0.0;
  double serverHz = 0.0;
  double mbit = 0.0;  // asked of the encoder, million bits a second
  double mssim = kNotMeasured;
  double mssimWorst = kNotMeasured;  // of all samples
  double psnrDb = kNotMeasured;
  double videoMbit = kNotMeasured;        // that the encoder made, first I-frame included
  double metaMbit = kNotMeasured;         // of geometry, first frame apart; atlases only
  double firstMetaBytes = kNotMeasured;   // of the first frame's geometry
  double uncoveredPixels = kNotMeasured;  // a picture: where nothing was drawn; atlases only
  double atlasUsed = kNotMeasured;        // share of the atlas' texels, of the last frame
  double bias = kNotMeasured;             // levels by which a full atlas coarsened, of the last frame
  double shadedBehindMs = kNotMeasured;   // mean age of the pose whose picture is shown
};

struct StudyMethod {
  std::string name;  // "rect, 4 Mpix", "time warp"
  bool atlas = false;
  int width = 0;  // of the coded picture, texels
  int height = 0;
  std::vector<StudyPoint> byLatency, byRate, byBitrate;
  std::vector<std::uint8_t> video;  // MP4; empty: none was made
};

/// One stage of a picture's way from pose to screen.
struct StudyStage {
  std::string name;
  double ms = 0.0;  // median
};

/// Two processes over loopback.
struct StudyTimeline {
  std::string failed;  // why there is none; empty: there is one
  std::string method;
  std::vector<StudyStage> server;  // what a server's frame is made of
  std::vector<StudyStage> viewer;  // from a pose that is sent to the picture
  double totalMs = kNotMeasured;   // median end to end, as the viewer measured it
  double firstPictureSeconds = kNotMeasured;
  double videoMbit = kNotMeasured, metaMbit = kNotMeasured;
  double ownShare = kNotMeasured;  // of a server's frame: all but shading and coding
};

struct StudyScene {
  std::string file;
  std::string note;  // stage and path
  std::size_t triangles = 0;
  int width = 0;  // of a shown picture, pixels
  int height = 0;
  double start = 0.0;  // of the path, seconds: the first server frame's pose
  double leadSeconds = 0.0;
  double seconds = 0.0;  // from the first sample to the last
  int samples = 0;
  double metresPerSecond = 0.0;  // of the camera, means
  double degreesPerSecond = 0.0;
  std::vector<StudyMethod> methods;
  std::vector<std::uint8_t> truth;  // MP4
  StudyTimeline timeline;
};

struct StudyReport {
  ReportContext context;
  std::vector<std::pair<std::string, std::string>> settings;  // names and values, as the page shows them
  double serverHz = 30.0;
  double mbit = 20.0;
  double videoLatencyMs = 100.0;
  std::vector<StudyScene> scenes;
};

/// A sentence that follows from the numbers, and whether it is what was hoped for.
struct StudyFinding {
  std::string text;
  bool goal = false;     // one of the goals; else what else there is to see
  bool reached = false;  // of a goal
};
/// Where atlases come to beat every warp, and whether the goals are reached: at 50 ms and above each atlas
/// beats every warp, and 100 ms cost it 0.01 of MSSIM at most.
std::vector<StudyFinding> findingsOf(const StudyScene& scene);

/// Where one curve comes to lie above another for good: the least x from which on `a` is above `b` at every x
/// that was measured, linear between that and the one before; NaN where it is not above at the last. As many
/// values as `x`, which rises.
double crossing(const std::vector<double>& x, const std::vector<double>& a, const std::vector<double>& b);

/// study.json.
std::string toJson(const StudyReport& report);
/// The page: no request leaves it, opens from a file.
std::string toHtml(const StudyReport& report);

}  // namespace tessera
