// The column of controls: status, shader, display, camera, sampling, saving.
#include <imgui.h>
#include <imgui_stdlib.h>

#include <cmath>

#include "app/console.h"
#include "app/text.h"
#include "base/error.h"
#include "bsdf/microfacet.h"
#include "view/controls.h"

namespace view {

namespace {

// Sets an option of the state; what cannot be is said and nothing changes.
void set(Viewer& v, const std::string& option, const nlohmann::json& value) {
  try {
    v.state.set(option, value);
  } catch (const base::Error& error) {
    v.say(error.what(), true);
  }
}

void choose(Viewer& v, const char* option, const std::vector<std::string>& helps = {}) {
  int index = static_cast<int>(v.state.options.index(option));
  const auto& names = app::choices_of(option);
  if (menu(v, option, names, index, app::help_of(option), helps))
    set(v, option, names[static_cast<size_t>(index)]);
}

void integer(Viewer& v, const char* option, int step) {
  int value = v.state.options[option];
  if (ImGui::InputInt(option, &value, step, 10 * step, ImGuiInputTextFlags_EnterReturnsTrue))
    set(v, option, value);
  v.trace.item(option);
  explain(v, app::help_of(option));
}

void status(Viewer& v) {
  if (!v.frame) {
    ImGui::TextUnformatted("preparing ...");
    return;
  }
  const Frame& f = *v.frame;
  const int wanted = v.state.options["spp"];
  if (!f.problem.empty())
    ImGui::TextColored({1, .5f, .5f, 1}, "no picture");
  else if (f.divisor > 1)
    ImGui::Text("preview, 1/%d of the size", f.divisor);
  else
    ImGui::Text("%d of %d samples, %s, %s", f.samples, wanted, app::speed(f.rays, f.seconds).c_str(),
                app::duration(f.seconds).c_str());
  if (v.median_error >= 0)
    ImGui::Text("standard error %.2g %% (median pixel)", 100 * v.median_error);
  else
    ImGui::TextUnformatted("standard error not known yet");
  ImGui::Text("edit to preview %.0f ms", v.preview_ms);
  ImGui::SameLine(ImGui::GetWindowWidth() - 9 * ImGui::GetFontSize());
  ImGui::BeginDisabled(!v.can_undo());
  const bool key = ImGui::GetIO().KeyCtrl && !ImGui::GetIO().WantTextInput && ImGui::IsKeyPressed('Z');
  if (button(v, "undo", "Back to before the last edit (ctrl-Z).") || key) v.undo();
  ImGui::EndDisabled();
  if (f.rejected > 0)
    ImGui::TextColored({1, .5f, .5f, 1}, "%lld samples were not finite", static_cast<long long>(f.rejected));
}

void shader(Viewer& v) {
  if (!section(v, "Shader")) return;
  // In the order of app::choices_of("shader").
  static const std::vector<std::string> helps = {
      "Lambert and GGX with Schlick's Fresnel.",
      "The 2018 report's: Disney diffuse and a D of one's own, by d_gamma and d_constant.",
      "Blender 3.4.1's Principled BSDF, term by term.",
      "Burley's BRDF of 2012 as published.",
      "In the light of a lamp at the eye, without shadows.",
      "Only light that was scattered once.",
      "path that finds lights by looking for them alone: noisier highlights, the same mean.",
      "Shading normals, from -1 to 1: black where negative.",
      "How much light the surface reflects, by its parameters.",
      "Texture coordinates u, v as red and green.",
      "Position in the world, metres, as red, green and blue."};
  choose(v, "shader", helps);
  if (v.state.options.text("shader") == "path_disney") {
    slider(v, "d_gamma", v.state.d_gamma, .05f, 10, "%.3f", ImGuiSliderFlags_Logarithmic,
           "Exponent of the distribution D: 2 is GGX, below it the highlight has a longer tail.");
    bool automatic = !v.state.d_constant;
    const float roughness = v.state.materials[static_cast<size_t>(v.material)].roughness;
    const double alpha = std::max(static_cast<double>(roughness) * roughness, .001);
    const auto normalised = static_cast<float>(bsdf::gtr_constant(alpha, v.state.d_gamma));
    if (checkbox(v, "d_constant auto", automatic, "D normalised for each roughness, as it should be.")) {
      if (automatic)
        v.state.d_constant.reset();
      else
        v.state.d_constant = normalised;
    }
    if (v.state.d_constant)
      slider(v, "d_constant", *v.state.d_constant, 0, 10, "%.6f", ImGuiSliderFlags_Logarithmic,
             "Factor of D in place of the normalising one: the same for every roughness.");
    ImGui::TextDisabled("normalised for the chosen material: %.4g", static_cast<double>(normalised));
  }
  integer(v, "depth", 1);
  bool hidden = v.state.options["hide-environment"];
  if (checkbox(v, "hide-environment", hidden, app::help_of("hide-environment")))
    set(v, "hide-environment", hidden);
}

void display(Viewer& v) {
  if (!section(v, "Display")) return;
  int show = static_cast<int>(v.show);
  std::vector<std::string> names = {"picture", "relative standard error"};
  if (v.reference.width > 0) names.push_back("difference from the reference");
  if (menu(v, "show", names, show)) v.show = static_cast<Show>(show);
  if (v.show != Show::picture) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    for (int i = 0; i < 256; ++i) {
      const Rgba c = false_colour(least * std::pow(most / least, static_cast<float>(i) / 255));
      const float x = at.x + static_cast<float>(i);
      ImGui::GetWindowDrawList()->AddRectFilled({x, at.y}, {x + 1, at.y + 10},
                                                IM_COL32(c[0], c[1], c[2], 255));
    }
    ImGui::Dummy({256, 10});
    static const char* const marks[] = {"0.1 %", "1 %", "10 %", "100 %"};
    for (int i = 0; i < 4; ++i) {
      if (i > 0) ImGui::SameLine();
      const float width = ImGui::CalcTextSize(marks[i]).x;
      ImGui::SetCursorScreenPos({at.x + static_cast<float>(i) * 256 / 3 - width * static_cast<float>(i) / 3,
                                 ImGui::GetCursorScreenPos().y});
      ImGui::TextUnformatted(marks[i]);
    }
  }
  slider(v, "exposure", v.display.exposure, -10, 10, "%.2f stops");
  bool srgb = v.display.gamma == 0;
  if (checkbox(v, "sRGB curve", srgb)) v.display.gamma = srgb ? 0 : 2.2f;
  if (!srgb) slider(v, "gamma", v.display.gamma, .5f, 4);
  checkbox(v, "filmic", v.display.filmic, "Rolls highlights off instead of cutting them.");
  ImGui::SameLine();
  checkbox(v, "inspect pixels", v.inspect,
           "The numbers of the pixel under the mouse, and what is seen there.");
  ImGui::InputText("##reference", &v.reference_file);
  v.trace.item("reference file");
  ImGui::SameLine();
  if (button(v, "load reference")) v.load_reference(v.reference_file);
  if (v.reference.width > 0) checkbox(v, "wipe", v.wipe);
}

void camera(Viewer& v) {
  if (!section(v, "Camera")) return;
  const auto& cameras = v.session.original().cameras;
  std::vector<std::string> names;
  for (size_t i = 0; i < cameras.size(); ++i)
    names.push_back(std::to_string(i) + (cameras[i].name.empty() ? "" : " " + cameras[i].name));
  if (cameras.empty()) names.push_back("everything framed");
  names.push_back("view (moved by hand)");
  const int free = static_cast<int>(names.size()) - 1;
  int index = v.state.camera ? free : cameras.empty() ? 0 : std::stoi(v.state.options.text("camera"));
  if (menu(v, "camera", names, index)) {
    if (index == free) {
      v.free_camera();
    } else {
      v.state.camera.reset();
      if (!cameras.empty()) set(v, "camera", std::to_string(index));
    }
  }
  int hand = static_cast<int>(v.hand);
  if (menu(v, "mouse", {"turntable", "fly (keys W A S D Q E)"}, hand)) v.hand = static_cast<Hand>(hand);
  if (v.hand == Hand::fly) {
    auto speed = static_cast<float>(v.speed);
    if (slider(v, "speed", speed, .01f, 100, "%.2f m/s", ImGuiSliderFlags_Logarithmic)) v.speed = speed;
  }
  const scene::Camera now = v.camera();
  float degrees = now.yfov * 180 / math::pi;
  if (!now.orthographic && slider(v, "field of view", degrees, 1, 150, "%.1f°"))
    v.free_camera().set_yfov(degrees * math::pi / 180);
}

void sampling(Viewer& v) {
  if (!section(v, "Size and samples")) return;
  integer(v, "width", 16);
  integer(v, "height", 16);
  integer(v, "spp", 64);
  integer(v, "seed", 1);
  choose(v, "sampler");
  choose(v, "filter");
}

void saving(Viewer& v) {
  if (!section(v, "Save")) return;
  const bool busy = v.saving.valid();
  const auto start = [&](std::future<std::string> future, bool copy, const char* what) {
    v.saving = std::move(future);
    v.copy_when_done = copy;
    v.say(what);
  };
  ImGui::InputText("##image", &v.image_file);
  v.trace.item("image file");
  ImGui::SameLine();
  if (button(v, "save image", "assay-render's file: .exr with provenance, .png, .jpg or .hdr.") && !busy)
    start(v.session.save_image(v.image_file, v.display), false,
          "saving when all replicates have the same samples ...");
  ImGui::InputText("##scene", &v.scene_file);
  v.trace.item("scene file");
  ImGui::SameLine();
  if (button(v, "save scene", ".glb or .gltf with the edits, everything else as it was.") && !busy)
    start(v.session.save_scene(v.scene_file), false, "saving ...");
  const bool edited = is_edited(v.session.original(), v.state);
  if (button(v, edited ? "save scene, copy command" : "copy command",
             "The command line of assay-render that makes this picture, into the clipboard.") &&
      !busy) {
    const int round = complete_options(v.state).render.replicates;
    const int samples =
        v.frame && v.frame->divisor == 1 ? (v.frame->samples + round - 1) / round * round : round;
    start(v.session.command(v.image_file, samples, v.display), true, "...");
  }
  ImGui::PushTextWrapPos();
  if (v.message_is_error)
    ImGui::TextColored({1, .5f, .5f, 1}, "%s", v.message.c_str());
  else
    ImGui::TextUnformatted(v.message.c_str());
  ImGui::PopTextWrapPos();
}

}  // namespace

void draw_panels(Viewer& v, float x, float y, float width, float height) {
  ImGui::SetNextWindowPos({x, y});
  ImGui::SetNextWindowSize({width, height});
  ImGui::Begin("controls", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize);
  ImGui::PushItemWidth(.53f * width);
  status(v);
  saving(v);
  if (ImGui::BeginTabBar("tabs")) {
    const bool scene = ImGui::BeginTabItem("Scene");
    v.trace.item("tab Scene");
    if (scene) {
      draw_material(v);
      draw_lights(v);
      draw_environment(v);
      ImGui::EndTabItem();
    }
    const bool picture = ImGui::BeginTabItem("Picture");
    v.trace.item("tab Picture");
    if (picture) {
      shader(v);
      camera(v);
      display(v);
      sampling(v);
      ImGui::EndTabItem();
    }
    ImGui::EndTabBar();
  }
  ImGui::PopItemWidth();
  ImGui::End();
  draw_textures(v);
}

}  // namespace view
