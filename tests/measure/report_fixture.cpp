#include "tests/measure/report_fixture.hpp"

#include <algorithm>
#include <cmath>

#include "engine/image/image.hpp"
#include "engine/measure/colormap.hpp"
#include "engine/measure/metrics.hpp"

namespace tessera {
namespace {

/// A tiled floor and a ball; `blocky` > 1 takes the colour of coarser pixels, as a coarse level in an atlas
/// would.
Image scenePicture(int width, int height, double time, int blocky) {
  Image image{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height * 4), 255)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = (x - x % blocky + 0.5 * blocky) / height - 0.9;
      const double v = (y - y % blocky + 0.5 * blocky) / height - 0.5;
      double r = 0.55 + 0.3 * v;
      double g = 0.7 + 0.2 * v;
      double b = 0.9;
      if (v > 0) {
        const double z = 1 / (v + 0.02);
        const bool dark =
            (static_cast<int>(std::floor(u * z + time)) + static_cast<int>(std::floor(z))) % 2 == 0;
        r = dark ? 0.25 : 0.8;
        g = dark ? 0.22 : 0.76;
        b = dark ? 0.3 : 0.66;
      }
      const double d = std::hypot(u - 0.3 * std::sin(time), v);
      if (d < 0.3) {
        const double light = std::max(0.1, (-u - v + std::sqrt(0.09 - d * d)) / 0.5);
        r = 0.9 * light;
        g = 0.35 * light;
        b = 0.2 * light;
      }
      const double colour[] = {r, g, b};
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(255 * colour[c], 0.0, 255.0));
    }
  return image;
}

Statistics around(double ms) {
  std::vector<double> samples;
  samples.reserve(21);
  for (int i = 0; i < 21; ++i) samples.push_back(ms * (0.97 + 0.003 * i));
  return summarize(samples);
}

}  // namespace

ReportScene fixtureScene(const std::string& file, const std::vector<std::string>& names, int pictures) {
  constexpr int kWidth = 320;
  constexpr int kHeight = 180;
  constexpr int kFrames = 60;
  ReportScene scene;
  scene.file = file;
  scene.note = "stage atrium.json, path walk, atlas 8 Mpix";
  scene.triangles = 81234;
  scene.instances = 157;
  scene.materials = 23;
  scene.lights = 5;
  scene.width = kWidth;
  scene.height = kHeight;
  scene.frames = kFrames;
  for (std::size_t i = 0; i < names.size(); ++i) {
    ReportMethod m;
    m.name = names[i];
    const auto k = static_cast<double>(i);
    const bool reference = i == 0;
    m.samplesShaded = 1.3e6 + 611003 * k;
    m.coveredPixels = 900017;
    m.visibleTriangles = 30211 + 7 * k;
    m.nsPerSample = 88.8 + 3.1 * k;
    m.frameMs = around(142.6 + 17 * k);
    m.passes.push_back({"id", around(9.1 + k)});
    if (reference) {
      m.mssim = 1;
      m.psnrDb = std::numeric_limits<double>::infinity();
      m.flip = 0;
      m.passes.push_back({"forward", around(128.4)});
    } else {
      m.mssim = 0.9 + 0.0213 * k;
      m.psnrDb = 28.31 + 2 * k;
      m.flip = 0.0571 - 0.01 * k;
      m.samplesAllocated = 2511777 + k;
      m.atlasTexelsUsed = 3411222 + 100000 * k;
      m.visiblePatches = 16003 + k;
      m.outOfMemory = 12 + k;
      m.resets = k;
      m.holes = 0;
      m.nonFiniteTexels = 0;
      m.gatherMs = around(101.7 + k);
      m.displayMs = around(41.2 + k);
      m.passes.push_back({"mark and compact", around(2.2)});
      m.passes.push_back({"levels", around(1.7)});
      m.passes.push_back({"memory", around(3.6)});
      m.passes.push_back({"shade", around(94.2 + 30 * k)});
      m.passes.push_back({"display", around(41.2 + k)});
    }
    for (int f = 0; f < kFrames; ++f) {
      const double wave = std::sin(0.2 * f + k);
      m.series.frameMs.push_back(142.6 + 17 * k + 8 * wave);
      m.series.samplesShaded.push_back(m.samplesShaded + 90000 * wave);
      if (reference) continue;
      m.series.mssim.push_back(m.mssim + 0.012 * wave);
      m.series.flip.push_back(m.flip - 0.006 * wave);
      m.series.atlasTexelsUsed.push_back(m.atlasTexelsUsed + 200000 * wave);
    }
    for (int p = 0; p < pictures; ++p) {
      ReportFrame frame;
      frame.frame = p * 20;
      const Image truth = scenePicture(kWidth, kHeight, p, 1);
      const Image picture =
          scenePicture(kWidth, kHeight, p, reference ? 1 : 5 - std::min<int>(3, static_cast<int>(i)));
      frame.image = encodePng(picture).value();
      if (!reference) {
        frame.error = encodePng(errorMap(flip(truth, picture).value())).value();
        frame.atlas = encodeJpeg(scenePicture(512, 256, 3.0 * p, 2), 90).value();
      }
      m.frames.push_back(std::move(frame));
    }
    scene.methods.push_back(std::move(m));
  }
  return scene;
}

Report fixtureReport() {
  Report report;
  report.context = {"osmesa",
                    "llvmpipe (LLVM 15.0.6, 256 bits)",
                    "4.5 (Core Profile) Mesa 22.3.6",
                    "4.50",
                    "glFinish and CPU clock",
                    "0123abc",
                    "tessera compare atrium.gltf -o out"};
  report.scenes.push_back(fixtureScene("atrium.gltf", {"forward", "rect", "rect bias -2"}, 3));
  report.scenes.push_back(fixtureScene("sponza.glb", {"forward", "rect"}, 2));
  return report;
}

}  // namespace tessera
