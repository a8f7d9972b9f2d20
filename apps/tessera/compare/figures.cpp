#include "apps/tessera/compare/figures.hpp"

#include <algorithm>

#include "apps/tessera/compare/method.hpp"

namespace tessera::app {

namespace {

// As the thesis has it: the bias may give up to four times the texels where there is room, and an atlas
// without bias is so large that it never runs out.
constexpr const char* kFloor = "+floor=-2";
constexpr const char* kOff = "mpix=64+bias=off";

ReportBar limited(const std::string& method, int megapixels) {
  const std::string size = std::to_string(megapixels);
  return {withSetting(method, "mpix=" + size + kFloor), "Atlas " + size + " Mpix"};
}

ReportBar unlimited(const std::string& method) { return {withSetting(method, kOff), "Atlas, bias off"}; }

std::vector<ReportFigure> allFigures() {
  std::vector<ReportFigure> figures;
  figures.push_back({"4.1",
                     "Resolution upsampling",
                     "Forward at a quarter of the pixels, upsampled with Lanczos-3 on encoded values, beside "
                     "the atlas at full "
                     "resolution. In the thesis 8 and 16 Mpix were one and two texels for each pixel of the "
                     "target; at a target "
                     "of 1080p 2 and 4 Mpix are. Compared with forward at the target resolution.",
                     {{"forward-lanczos", "Forward, Lanczos"},
                      limited("rect", 2),
                      limited("rect", 4),
                      limited("rect", 8),
                      limited("rect", 16),
                      unlimited("rect")}});
  figures.push_back(
      {"4.3",
       "Stereo rendering",
       "Samples against the pixels of one picture of the pair; MSSIM is the mean over both. Mesh "
       "warping draws the left eye forward and warps it to the right one, so that half of its mean "
       "is 1: compare the right eyes too. The atlas is shaded once, from between the eyes; where forward "
       "draws "
       "much more than once over, a bias of -0.5 still spends no more than warping, and where triangles are "
       "small, 2.5 "
       "Mpix that are always filled bound what is spent. Compared with forward for each eye.",
       {{"forward-stereo", "Forward twice"},
        {"warp-stereo", "Mesh warping"},
        limited("rect-stereo", 8),
        limited("rect-stereo", 16),
        unlimited("rect-stereo"),
        {"rect-stereo:mpix=64+bias=-0.5", "Atlas, bias -0.5"},
        {"rect-stereo:mpix=2.5+floor=-2", "Atlas, 2.5 Mpix filled"}}});
  figures.push_back({"4.6",
                     "Foveated rendering",
                     "The eye looks at the middle of the picture. Beside MSSIM, SSIM at the scale that "
                     "the eye resolves at each pixel, weighted by the share of the display's cycles that it "
                     "resolves there.",
                     {limited("rect:foveate", 8), limited("rect:foveate", 16), unlimited("rect:foveate")}});
  figures.push_back(
      {"4.7",
       "Stereo through a lens",
       "With the lens, both the pictures and forward's are compared as they reach the display: drawn through "
       "the "
       "lens. Without, as they are.",
       {limited("rect-stereo", 8), limited("rect-stereo", 16), unlimited("rect-stereo"),
        limited("rect-stereo:lens", 8), limited("rect-stereo:lens", 16), unlimited("rect-stereo:lens")}});
  for (ReportBar& bar : figures.back().bars)
    if (bar.method.find(":lens") != std::string::npos) bar.label += ", lens";
  return figures;
}

}  // namespace

Result<std::vector<ReportFigure>> figuresOf(const std::vector<std::string>& names) {
  const std::vector<ReportFigure> all = allFigures();
  std::vector<ReportFigure> chosen;
  for (const std::string& name : names) {
    if (name == "all") return all;
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const ReportFigure& figure) { return figure.id == name; });
    if (found == all.end()) return fail("--figures {}: not one of 4.1, 4.3, 4.6, 4.7, all", name);
    chosen.push_back(*found);
  }
  return chosen;
}

}  // namespace tessera::app
