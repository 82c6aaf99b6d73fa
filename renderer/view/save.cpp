#include "view/save.h"

#include "app/text.h"
#include "base/error.h"
#include "image/file.h"

namespace view {

namespace {

Edits edits_of(const Original& original, const State& state) {
  Edits edits;
  for (size_t i = 0; i < state.materials.size(); ++i)
    if (state.materials[i] != original.state.materials[i])
      edits.materials.push_back({i, original.state.materials[i], state.materials[i]});
  for (size_t i = 0; i < state.lights.size(); ++i)
    if (state.lights[i] != original.state.lights[i]) edits.lights.push_back(state.lights[i]);
  if (state.camera) {
    edits.camera = {state.camera->camera(), state.camera->to_world()};
    edits.camera->camera.aspect = static_cast<float>(state.width()) / static_cast<float>(state.height());
  }
  if (state.sky) edits.environment = {{*state.sky->map, state.sky->strength, 0}, state.sky->rotation_degrees};
  return edits;
}

// The number of samples decides the default number of replicates.
int default_replicates(int samples) {
  int replicates = 8;
  while (samples % replicates != 0) --replicates;
  return replicates;
}

}  // namespace

bool is_edited(const Original& original, const State& state) {
  return state.materials != original.state.materials || state.lights != original.state.lights ||
         state.camera || state.sky;
}

bool is_scene_of(const SavedScene& saved, const State& state) {
  return state.materials == saved.state.materials && state.lights == saved.state.lights &&
         state.camera == saved.state.camera && state.sky == saved.state.sky;
}

app::Options complete_options(const State& state) {
  app::Options options = state.options;
  options.render = {};
  options.choices.clear();
  if (options.has("camera")) options.render.camera = std::stoi(options.text("camera"));
  if (options.text("shader") == "path_disney") {
    app::apply_job(options, {{"d-gamma", app::decimal(state.d_gamma)}});
    app::apply_job(options, {{"d-constant",
                              state.d_constant ? app::decimal(*state.d_constant) : nlohmann::json("auto")}});
  }
  app::complete_settings(options);
  app::choose_size(options, 0);
  return options;
}

SavedScene save_scene(const Original& original, const State& state, const std::string& file) {
  const Edits edits = edits_of(original, state);
  const gltf::Options load = complete_options(state).load;
  write_gltf(original.file, original.hash, file, edits, load);
  const scene::Scene read = gltf::load(file, load);

  // What reads back otherwise would make another picture.
  const auto want = [&](bool same, const char* what) {
    if (!same) base::fail(file, ": was written, but its ", what, " read back otherwise than edited");
  };
  want(read.materials.size() == state.materials.size(), "materials");
  for (size_t i = 0; i < read.materials.size(); ++i) {
    scene::Material material = state.materials[i];
    material.name = read.materials[i].name;
    want(material == read.materials[i], "materials");
  }
  want(read.lights.size() == state.lights.size(), "lights");
  for (size_t i = 0; i < read.lights.size(); ++i) {
    scene::Light light = state.lights[i];
    light.node = read.lights[i].node;
    want(light == read.lights[i], "lights");
  }
  want(!edits.camera || read.cameras.back() == edits.camera->camera, "camera");
  if (state.sky) want(read.environment && read.environment->strength == state.sky->strength, "environment");
  return {file, read.hash, state};
}

app::Options options_for(const Original& original, const State& state, const SavedScene* saved, int samples,
                         const std::string& file, const image::Display& display) {
  State made = state;
  if (saved != nullptr) made.options.given["scene"] = saved->file;
  if (state.camera) made.set("camera", std::to_string(original.cameras.size()));
  if (state.sky)
    for (const char* name : {"environment", "environment-color"}) made.options.given.erase(name);
  made.set("spp", samples);
  made.options.given.erase("replicates");
  const int replicates = complete_options(state).render.replicates;
  if (replicates != default_replicates(samples)) made.set("replicates", replicates);
  made.set("out", file);
  const std::string extension = image::lower_extension(file);
  if (extension == ".png" || extension == ".jpg" || extension == ".jpeg") {
    if (display.exposure != 0) made.set("exposure", app::decimal(display.exposure));
    if (display.gamma > 0) made.set("gamma", app::decimal(display.gamma));
    if (display.filmic) made.set("filmic", true);
  }
  app::Options options = complete_options(made);
  app::complete(options);
  return options;
}

}  // namespace view
