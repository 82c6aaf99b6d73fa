#include "view/viewer.h"

#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "app/console.h"
#include "base/error.h"
#include "image/decode.h"
#include "image/read.h"

namespace view {
namespace fs = std::filesystem;

namespace {

// Half of the pixels have a smaller relative error; fireflies do not count for more than one.
float median_relative_error(const Frame& frame) {
  std::vector<float> errors;
  for (size_t i = 0; i < frame.variance.pixels.size(); ++i)
    if (const float error = relative_error(frame.mean.pixels[i], frame.variance.pixels[i]); error >= 0)
      errors.push_back(error);
  if (errors.empty()) return -1;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

}  // namespace

Viewer::Viewer(Session& s, Trace& t) : session(s), trace(t), state(s.original().state), submitted(state) {
  const std::string stem = fs::path(session.original().file).stem().string();
  image_file = stem + "-view.exr";
  scene_file = stem + "-edited.glb";
  for (const std::string& warning : session.warnings()) say(warning);
}

scene::Camera Viewer::camera() const {
  return state.camera ? state.camera->camera() : session.file_camera(state);
}

// It turns about what is seen in the middle, else about a point as far as the origin.
FreeCamera& Viewer::free_camera() {
  if (state.camera) return *state.camera;
  const scene::Camera start = session.file_camera(state);
  const auto middle = session.pick(.5f, .5f);
  const double distance =
      middle ? middle->distance : std::max(1.f, math::length(math::Vec3(start.to_world[3])));
  return state.camera.emplace(start, distance);
}

void Viewer::load_reference(const std::string& file) {
  try {
    reference = image::read_picture(file);
    reference_name = fs::path(file).filename().string();
    reference_painted_ = false;
    painted_.reset();
    say(reference_name + ": " + std::to_string(reference.width) + " x " + std::to_string(reference.height));
  } catch (const std::exception& error) {
    say(app::message(error), true);
  }
}

void Viewer::load_environment(const std::string& file) {
  try {
    const image::Image map = image::read_environment(file);
    scene::Bitmap bitmap{fs::path(file).filename().string(), map.width, map.height, {}};
    for (const math::Vec3& p : map.pixels) bitmap.texels.push_back({p.x, p.y, p.z, 1});
    state.sky = {std::make_shared<const scene::Bitmap>(std::move(bitmap)), 1, 0};
  } catch (const std::exception& error) {
    say(app::message(error), true);
  }
}

void Viewer::paint() {
  const bool display_changed = display.exposure != painted_display_.exposure ||
                               display.gamma != painted_display_.gamma ||
                               display.filmic != painted_display_.filmic;
  if (frame == painted_ && !display_changed && show == painted_show_ && reference_painted_) return;
  if (frame && frame != painted_) median_error = median_relative_error(*frame);
  const Codes codes(display);
  if (frame && frame->problem.empty() && frame->mean.width > 0) {
    const image::Image& mean = frame->mean;
    texture.set(show == Show::error                               ? show_error(mean, frame->variance)
                : show == Show::difference && reference.width > 0 ? show_difference(mean, reference)
                                                                  : view::show(mean, codes),
                mean.width, mean.height, frame->divisor > 1);
  }
  if (reference.width > 0 && (display_changed || !reference_painted_))
    reference_texture.set(view::show(reference, codes), reference.width, reference.height, false);
  painted_ = frame;
  painted_display_ = display;
  painted_show_ = show;
  reference_painted_ = true;
}

void Viewer::update() {
  frame = session.frame();
  paint();
  if (saving.valid() && saving.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    try {
      const std::string result = saving.get();
      say(result);
      if (copy_when_done) ImGui::SetClipboardText(result.c_str());
    } catch (const std::exception& error) {
      say(app::message(error), true);
    }
  }
}

// Called when the user interface was drawn and is on the screen.
void Viewer::submit() {
  if (frame && frame->generation != timed_generation && frame->problem.empty()) {
    timed_generation = frame->generation;
    preview_ms = 1e3 * std::chrono::duration<double>(Clock::now() - frame->edited).count();
  }
  // Drags, typed digits and keys that are held make one edit of many.
  const bool goes_on = in_edit_ || ImGui::GetTime() < edited_ + .3;
  in_edit_ = in_edit_ && ImGui::IsAnyItemActive();
  if (state == submitted) return;
  if (!goes_on && !undoing_) history_.push_back(submitted);
  if (history_.size() > 200) history_.erase(history_.begin());
  in_edit_ = ImGui::IsAnyItemActive() && !undoing_;
  undoing_ = false;
  edited_ = ImGui::GetTime();
  submitted = state;
  generation = session.edit(state);
}

void Viewer::undo() {
  if (history_.empty()) return;
  state = history_.back();
  history_.pop_back();
  undoing_ = true;
}

nlohmann::json Viewer::to_json() const {
  nlohmann::json out = {{"generation", generation},
                        {"shader", state.options.text("shader")},
                        {"camera", state.camera ? "view" : state.options.text("camera")},
                        {"d_gamma", state.d_gamma},
                        {"undo", history_.size()},
                        {"material", material},
                        {"roughness", state.materials[static_cast<size_t>(material)].roughness},
                        {"metallic", state.materials[static_cast<size_t>(material)].metallic},
                        {"sky", state.sky ? state.sky->map->name : ""},
                        {"texture shown", show_textures ? bitmap : -1},
                        {"hover", {hover_x, hover_y}},
                        {"wipe_at", wipe_at},
                        {"message", message},
                        {"saving", saving.valid()}};
  if (frame)
    out["frame"] = {{"generation", frame->generation}, {"divisor", frame->divisor},
                    {"samples", frame->samples},       {"complete", frame->complete},
                    {"problem", frame->problem},       {"preview_ms", preview_ms}};
  return out;
}

}  // namespace view
