#include <thread>

#include "apps/tessera/view/viewing.hpp"

namespace tessera::app {

Result<void> viewHeadless(const ViewOptions& options) {
  const auto size = parseSize(options.size.text);
  if (!size) return tl::unexpected(size.error());
  auto flight = Flight::of(options, *size);
  if (!flight) return tl::unexpected(flight.error());
  auto context = openContext(options.context);
  if (!context) return tl::unexpected(context.error());
  auto viewing = Viewing::start(options, **context, std::move(*flight));
  if (!viewing) return tl::unexpected(viewing.error());
  const auto interval =
      std::chrono::duration_cast<view::Clock::duration>(std::chrono::duration<double>(1.0 / options.fps));
  auto due = view::Clock::now();
  std::string said;
  const auto frames = [&] {
    return options.frames > 0 ? options.frames : viewing->flight().frames(options.fps);
  };
  stopOnSignals();
  while (viewing->framesShown() < frames() && !stopAsked()) {
    // The path begins with the first picture.
    const double time = viewing->framesShown() / options.fps;
    if (auto done = viewing->step(viewing->flight().at(time)); !done) return done;
    const view::Figures& figures = viewing->figures();
    if (figures.why != said) {
      said = figures.why;
      if (!said.empty()) fmt::print(stderr, "view: {}\n", said);
    }
    if (figures.condition == view::Condition::Refused ||
        (!viewing->hasPicture() && viewing->seconds() > options.patience)) {
      // Figures of a failed run are figures too.
      if (auto written = viewing->writeStats(); !written) return written;
      return fail("no picture of {} for {:.1f} s: {}", options.address, viewing->seconds(), figures.why);
    }
    if (viewing->hasPicture() && !options.record.empty())
      if (auto written = viewing->record(viewing->display().read()); !written) return written;
    if (auto done = viewing->shown(); !done) return done;
    due = std::max(due + interval, view::Clock::now() - interval);
    std::this_thread::sleep_until(due);
  }
  return viewing->writeStats();
}

}  // namespace tessera::app
