#include "apps/tessera/view/overlay.hpp"

#include <imgui.h>

namespace tessera::app {

namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoInputs |
                                    ImGuiWindowFlags_NoFocusOnAppearing;

void line(const std::string& text) { ImGui::TextUnformatted(text.c_str()); }

}  // namespace

void drawOverlay(const Viewing& viewing, bool figures) {
  const view::Figures& f = viewing.figures();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  if (!f.why.empty()) {
    ImGui::SetNextWindowPos({0.5f * size.x, 0.5f * size.y}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::Begin("why", nullptr, kPlain);
    ImGui::PushTextWrapPos(0.8f * size.x);
    line(f.why);
    ImGui::PopTextWrapPos();
    ImGui::End();
  }
  if (!figures) return;
  ImGui::SetNextWindowPos({8.0f, 8.0f});
  ImGui::Begin("figures", nullptr, kPlain);
  line(fmt::format("frame {:.1f} ms, atlas {}", viewing.frameMs(), viewing.shownFrame()));
  for (std::size_t i = 0; i < view::kStages; ++i) {
    const auto stage = static_cast<view::Stage>(i);
    const double median = viewing.latency(stage);
    line(median < 0.0 ? fmt::format("{:>8}", view::nameOf(stage))
                      : fmt::format("{:>8} {:7.1f} ms", view::nameOf(stage), median));
  }
  line(fmt::format("video {:.2f} Mbit/s, meta {:.2f} Mbit/s", f.videoMbit, f.metaMbit));
  line(fmt::format("loss {:.2f} %, round trip {:.1f} ms", f.lossPercent(), f.roundTripMs));
  if (viewing.missed())
    line(fmt::format("missing from the visible set: {} pixels", *viewing.missed()));
  else
    line(fmt::format("uncovered {} pixels, the background's among them", viewing.uncovered()));
  ImGui::End();
}

}  // namespace tessera::app
