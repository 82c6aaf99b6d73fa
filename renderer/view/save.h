// What leaves the viewer: the edited scene as a glTF file, and the command line of assay-render that makes
// the picture again.
#pragma once

#include <optional>

#include "image/display.h"
#include "view/gltf_file.h"
#include "view/state.h"

namespace view {

// What the scene was before any edit.
struct Original {
  State state;
  std::string file, hash;
  std::vector<scene::Camera> cameras;            // of the file; may be none
  std::optional<Sky> sky;                        // the file's or the options'
  std::shared_ptr<const scene::Bitmap> neutral;  // of a scene without light
};

// A file that holds an edited scene.
struct SavedScene {
  std::string file, hash;
  State state;
};

// Whether `state` differs from the file in what a scene file holds.
bool is_edited(const Original& original, const State& state);
// Whether a saved scene is that of `state`.
bool is_scene_of(const SavedScene& saved, const State& state);

// The options with everything filled in, for a renderer. Throws base::Error.
app::Options complete_options(const State& state);

// Writes the scene with its edits, reads it back and throws base::Error if it does not read the same.
SavedScene save_scene(const Original& original, const State& state, const std::string& file);

// Options for assay-render, complete, that make `samples` samples of `state`; `saved` for an edited scene.
app::Options options_for(const Original& original, const State& state, const SavedScene* saved, int samples,
                         const std::string& file, const image::Display& display);

}  // namespace view
