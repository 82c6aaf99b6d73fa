// Everything about a picture that can be edited while it is looked at, as one value: two pictures are of one
// state if and only if the states are equal.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "app/options.h"
#include "scene/scene.h"
#include "view/camera.h"

namespace view {

// An environment; the map is shared, as it may be large.
struct Sky {
  std::shared_ptr<const scene::Bitmap> map;
  float strength = 1;
  float rotation_degrees = 0;  // about +y

  bool operator==(const Sky&) const = default;
};

struct State {
  // As on assay-render's command line, complete: the shader, sizes, samples, ... but d-gamma and d-constant,
  // which outlive a change of the shader. `camera` is an index, and absent only if the file has no camera.
  app::Options options;
  float d_gamma = 2;
  std::optional<float> d_constant;  // absent: auto

  std::vector<scene::Material> materials;
  std::vector<scene::Light> lights;
  std::optional<FreeCamera> camera;  // in place of the options'
  std::optional<Sky> sky;            // in place of the scene's and of the options'

  // Sets an option, as a batch job does. Throws base::Error if the value is none it can have.
  void set(const std::string& option, const nlohmann::json& value) {
    app::apply_job(options, {{option, value}});
  }
  int width() const { return options["width"]; }
  int height() const { return options["height"]; }

  bool operator==(const State& o) const {
    return options.given == o.options.given && d_gamma == o.d_gamma && d_constant == o.d_constant &&
           materials == o.materials && lights == o.lights && camera == o.camera && sky == o.sky;
  }
};

}  // namespace view
