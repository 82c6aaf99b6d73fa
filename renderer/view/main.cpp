// assay-view: a scene in a window, rendered while it is edited. See assay-view --help.
#include <imgui.h>

#include <cstdio>
#include <regex>

#include "app/console.h"
#include "app/version.h"
#include "base/error.h"
#include "view/measure.h"
#include "view/viewer.h"

namespace {

const char* const help_text =
    "Shows a glTF scene in a window and renders it while you edit it, with the same code as assay-render.\n"
    "Usage: assay-view SCENE [options of assay-render] [--reference FILE]\n"
    "\n"
    "  assay-view model.glb                       540 pixels high, shader disney\n"
    "  assay-view model.glb --shader path_disney --width 960 --height 408\n"
    "  assay-view model.glb --environment sky.hdr --reference golden.exr\n"
    "\n"
    "In the picture\n"
    "  left drag      turn about what the middle shows      wheel, right drag   nearer, farther\n"
    "  middle drag    shift                                 click               choose that material\n"
    "  rest the mouse on a pixel: its numbers, magnified, with what is seen there\n"
    "  mouse 'fly':   left drag looks around; W A S D Q E move, faster with shift\n"
    "  ctrl-click a slider to type a number, right-click it for the file's value; rest on it: what it does\n"
    "  ctrl-Z undoes edits\n"
    "\n"
    "Every edit restarts the picture: first small, then finer, then sample after sample up to --spp (4096).\n"
    "'save image' waits until all replicates have the same number of samples; the .exr is then, byte for "
    "byte,\n"
    "what assay-render writes, but for the date, with the command that 'copy command' puts into the "
    "clipboard. If materials,\n"
    "lights, environment or camera were edited, the scene is saved beside it: that command needs it.\n"
    "'save scene' writes a .glb or .gltf with the edits and everything else as it was.\n"
    "\n"
    "Options\n"
    "  --reference FILE   .exr, .hdr, .png or .jpg to wipe against and to compare with\n"
    "  --measure          no window: how long after an edit its first picture is there\n"
    "  --trace FILE       write what the window shows as lines of JSON, for scripts that drive it\n"
    "  -h, --help; --version\n"
    "  and those of assay-render (see its --help) under Picture, Camera and size (not --crop), Samples (not\n"
    "  --adaptive, --noise, --time) and Light, and --exposure, --gamma, --filmic, --threads\n"
    "\n"
    "Exit codes\n"
    "  0   done\n"
    "  2   could not run, for example without a display: one line says why\n";

struct Arguments {
  std::vector<std::string> words;  // for assay-render's parser
  std::string reference, trace;
  bool help = false, version = false, measure = false;
};

Arguments sort_out(const std::vector<std::string>& words) {
  Arguments a;
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "-h" || word == "--help")
      a.help = true;
    else if (word == "--version")
      a.version = true;
    else if (word == "--measure")
      a.measure = true;
    else if (word == "--reference" || word == "--trace") {
      if (i + 1 == words.size()) base::fail(word, ": wanted FILE, found nothing");
      (word == "--trace" ? a.trace : a.reference) = words[++i];
    } else
      a.words.push_back(word);
  }
  return a;
}

// Options that make no sense while one looks on.
void check(const app::Options& options) {
  for (const char* name : {"out", "layers", "save-progress", "log", "batch", "info", "json", "quiet"})
    if (options.has(name)) base::fail("--", name, ": is assay-render's alone");
}

void run_window(app::Options options, const Arguments& arguments) {
  image::Display display;
  display.exposure = options["exposure"];
  if (options.has("gamma")) display.gamma = options["gamma"];
  display.filmic = options["filmic"];
  for (const char* name : {"exposure", "gamma", "filmic"}) options.given.erase(name);

  view::Trace trace;
  trace.open(arguments.trace);
  view::Window window("assay-view", 1280, 760);
  view::Session session(options, view::Window::wake);
  view::Viewer viewer(session, trace);
  viewer.display = display;
  if (!arguments.reference.empty()) {
    viewer.load_reference(viewer.reference_file = arguments.reference);
    if (viewer.message_is_error) base::fail(viewer.message);
  }
  window.set_title("assay-view: " + options.text("scene"));

  int lively = 3;  // the user interface needs a few frames to settle after an event
  while (!window.closed()) {
    const double patience = lively > 0 ? .01 : .5;
    const auto start = view::Clock::now();
    window.begin_frame(patience);
    const bool event = view::Clock::now() - start < std::chrono::duration<double>(.9 * patience);
    lively = event || ImGui::IsAnyMouseDown() || viewer.hand == view::Hand::fly ? 3 : lively - 1;
    int x = 0, y = 0;
    if (trace.on()) window.position(x, y);
    trace.begin_frame(x, y);
    viewer.update();
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const float column = 400 * window.scale();
    view::draw_canvas(viewer, 0, 0, std::max(size.x - column, 50.f), size.y);
    view::draw_panels(viewer, std::max(size.x - column, 50.f), 0, column, size.y);
    window.end_frame();
    viewer.submit();
    trace.end_frame(viewer.to_json());
  }
}

void run(const std::vector<std::string>& words) {
  const Arguments arguments = sort_out(words);
  if (arguments.help) return app::print_result(help_text);
  if (arguments.version)
    return app::print_result(std::string("assay-view ") + app::version + " (commit " + app::commit + ")\n");
  const app::Options options = app::parse_command_line(arguments.words);
  check(options);
  if (!options.has("scene")) base::fail("no scene given (see assay-view --help)");
  if (!arguments.measure) return run_window(options, arguments);
  if (!arguments.reference.empty()) base::fail("--reference: --measure shows no picture");
  view::Session session(options);
  view::measure(session, 50);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run({argv + 1, argv + argc});
    return 0;
  } catch (const std::exception& error) {
    const std::string text =
        std::regex_replace(app::message(error), std::regex("assay-render --help"), "assay-view --help");
    std::fprintf(stderr, "assay-view: error: %s\n", text.c_str());
    return 2;
  }
}
