#include "view/measure.h"

#include <algorithm>
#include <cstdio>

#include "base/error.h"

namespace view {

void measure(Session& session, int edits) {
  const std::shared_ptr<const Frame> first = session.wait(1, 1, 1, 600);
  if (!first) base::fail("--measure: no picture within ten minutes");
  if (!first->problem.empty()) base::fail(first->problem);
  State state = session.original().state;
  const auto& cameras = session.original().cameras;
  if (cameras.empty()) base::fail("--measure: wanted a scene with a camera, found none");
  state.camera = FreeCamera(cameras[static_cast<size_t>(std::stoi(state.options.text("camera")))], 5);

  std::vector<double> milliseconds;
  double preview_pixels = 0;
  for (int i = 0; i < edits; ++i) {
    state.camera->turn(i % 2 == 0 ? .02 : -.02, 0);
    const Clock::time_point start = Clock::now();
    const auto frame = session.wait(session.edit(state), 64, 1);
    if (!frame || !frame->problem.empty()) base::fail("--measure: an edit was not answered");
    milliseconds.push_back(1e3 * std::chrono::duration<double>(Clock::now() - start).count());
    preview_pixels += static_cast<double>(frame->mean.pixels.size()) / edits;
    std::this_thread::sleep_for(std::chrono::milliseconds(37 * (i % 8)));  // what is interrupted differs
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  const auto at = [&](double q) {
    return milliseconds[static_cast<size_t>(q * static_cast<double>(milliseconds.size() - 1))];
  };
  std::printf(
      "%d x %d: interaction to preview: median %.0f ms, 95 %% within %.0f ms, longest %.0f ms (%d edits); "
      "a preview has %.0f pixels\n",
      state.width(), state.height(), at(.5), at(.95), at(1), edits, preview_pixels);
}

}  // namespace view
