// A window with GLFW: a camera that flies by mouse and keys, the picture, and the overlay.
#define GLFW_INCLUDE_NONE
#include <cstring>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

#include <GLFW/glfw3.h>

#include "apps/tessera/view/overlay.hpp"
#include "apps/tessera/view/viewing.hpp"
#include "engine/view/camera.hpp"

namespace tessera::app {

namespace {

constexpr double kRadiansPerPixel = 0.003;
constexpr double kMetresPerSecond = 2.0;
constexpr double kFaster = 5.0;

/// GLFW and its window, ended in order.
class Window {
 public:
  static Result<std::unique_ptr<Window>> open(glm::ivec2 size) {
    auto window = std::unique_ptr<Window>(new Window);
    if (glfwInit() != GLFW_TRUE) return fail("no window: {}", lastError());
    window->initialised_ = true;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    for (const int minor : {6, 5}) {
      glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
      window->handle_ = glfwCreateWindow(size.x, size.y, "tessera view", nullptr, nullptr);
      if (window->handle_ != nullptr) break;
    }
    if (window->handle_ == nullptr) return fail("no window with OpenGL 4.5 or newer: {}", lastError());
    glfwMakeContextCurrent(window->handle_);
    glfwSwapInterval(1);
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui_ImplGlfw_InitForOpenGL(window->handle_, true);
    ImGui_ImplOpenGL3_Init("#version 450 core");
    window->overlay_ = true;
    return window;
  }
  ~Window() {
    if (overlay_) {
      ImGui_ImplOpenGL3_Shutdown();
      ImGui_ImplGlfw_Shutdown();
      ImGui::DestroyContext();
    }
    if (handle_ != nullptr) glfwDestroyWindow(handle_);
    if (initialised_) glfwTerminate();
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  [[nodiscard]] GLFWwindow* get() const { return handle_; }
  [[nodiscard]] bool pressed(int key) const { return glfwGetKey(handle_, key) == GLFW_PRESS; }

 private:
  Window() = default;
  static std::string lastError() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text == nullptr ? "unknown" : text;
  }
  bool initialised_ = false;
  bool overlay_ = false;
  GLFWwindow* handle_ = nullptr;
};

/// Turns while the left button is held, moves by keys.
class Controls {
 public:
  void apply(const Window& window, double seconds, view::FlyCamera& camera) {
    glm::dvec2 mouse(0.0);
    glfwGetCursorPos(window.get(), &mouse.x, &mouse.y);
    if (glfwGetMouseButton(window.get(), GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS) {
      const glm::dvec2 turn = (mouse - last_) * kRadiansPerPixel;
      camera.turn(turn.x, -turn.y);
    }
    last_ = mouse;
    const auto axis = [&](int more, int less) {
      return (window.pressed(more) ? 1.0 : 0.0) - (window.pressed(less) ? 1.0 : 0.0);
    };
    const bool faster = window.pressed(GLFW_KEY_LEFT_SHIFT) || window.pressed(GLFW_KEY_RIGHT_SHIFT);
    const double step = seconds * kMetresPerSecond * (faster ? kFaster : 1.0);
    camera.move(step * glm::dvec3(axis(GLFW_KEY_D, GLFW_KEY_A) + axis(GLFW_KEY_RIGHT, GLFW_KEY_LEFT),
                                  axis(GLFW_KEY_E, GLFW_KEY_Q),
                                  axis(GLFW_KEY_W, GLFW_KEY_S) + axis(GLFW_KEY_UP, GLFW_KEY_DOWN)));
  }

 private:
  glm::dvec2 last_{0.0};
};

/// What is about to be shown, overlay and all.
Image readBack(glm::ivec2 size) {
  Image image;
  image.width = size.x;
  image.height = size.y;
  const std::size_t row = static_cast<std::size_t>(size.x) * 4;
  std::vector<std::uint8_t> rows(row * static_cast<std::size_t>(size.y));
  gl::api().BindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  gl::api().ReadPixels(0, 0, size.x, size.y, GL_RGBA, GL_UNSIGNED_BYTE, rows.data());
  image.pixels.resize(rows.size());
  for (int y = 0; y < size.y; ++y)
    std::memcpy(image.at(0, y), rows.data() + static_cast<std::size_t>(size.y - 1 - y) * row, row);
  return image;
}

}  // namespace

Result<void> viewWindow(const ViewOptions& options) {
  const auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  auto flight = Flight::of(options, *size);
  if (!flight) return tl::unexpected(flight.error());
  auto window = Window::open(*size);
  if (!window) return tl::unexpected(window.error());
  auto context = gl::Context::adoptCurrent(&glfwGetProcAddress);
  if (!context) return tl::unexpected(context.error());
  auto viewing = Viewing::start(options, **context, std::move(*flight));
  if (!viewing) return tl::unexpected(viewing.error());
  view::FlyCamera fly;
  bool placed = false;
  Controls controls;
  bool figures = options.overlay;
  bool held = false;
  double before = glfwGetTime();
  std::optional<double> pathStart;
  stopOnSignals();
  while (glfwWindowShouldClose((*window)->get()) == GLFW_FALSE && !stopAsked() &&
         (options.frames == 0 || viewing->framesShown() < options.frames)) {
    glfwPollEvents();
    if ((*window)->pressed(GLFW_KEY_ESCAPE)) break;
    const bool toggle = (*window)->pressed(GLFW_KEY_F1);
    if (toggle && !held) figures = !figures;
    held = toggle;
    const double now = glfwGetTime();
    controls.apply(**window, now - before, fly);
    before = now;
    const Flight& flown = viewing->flight();
    if (!placed) fly.set(flown.at(0.0));
    placed = flown.known();
    if (flown.moves()) {
      if (viewing->hasPicture() && !pathStart) pathStart = now;
      fly.set(flown.at(pathStart ? now - *pathStart : 0.0));
    }
    glm::ivec2 pixels(0);
    glfwGetFramebufferSize((*window)->get(), &pixels.x, &pixels.y);
    if (pixels.x < 1 || pixels.y < 1) {  // minimised
      glfwWaitEventsTimeout(0.1);
      continue;
    }
    const auto camera = view::resized(fly.camera(), static_cast<std::uint32_t>(pixels.x),
                                      static_cast<std::uint32_t>(pixels.y));
    if (auto done = viewing->step(camera); !done) return done;
    viewing->display().blit(0, pixels.x, pixels.y);
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    drawOverlay(*viewing, figures);
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    if (viewing->hasPicture() && !options.record.empty())
      if (auto written = viewing->record(readBack(pixels)); !written) return written;
    glfwSwapBuffers((*window)->get());
    if (auto done = viewing->shown(); !done) return done;
    if (viewing->figures().condition == view::Condition::Refused && !viewing->hasPicture() &&
        options.frames > 0) {
      if (auto written = viewing->writeStats(); !written) return written;
      return fail("{}", viewing->figures().why);
    }
  }
  return viewing->writeStats();
}

}  // namespace tessera::app
