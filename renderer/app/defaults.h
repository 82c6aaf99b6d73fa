// What makes a good picture of an unknown scene: plain edits of the scene data, each said in one line.
#pragma once

#include <string>
#include <vector>

#include "integrator/render.h"
#include "scene/scene.h"

namespace app {

// A camera that frames everything, seen three-quarters from above the front (+z, glTF's front). Throws
// base::Error for a scene with nothing in it.
scene::Camera framing_camera(const scene::Scene& scene, float aspect);

// Whether anything in the scene can send light: an emissive material in use, a lamp, an environment.
bool has_light(const scene::Scene& scene);

// Whether what a shader shows depends on the scene's lights.
bool shows_light(integrator::Shader shader);

// A soft neutral sky: radiance .45 above, .2 below, and a broad glow over the left shoulder that shows
// shapes.
scene::Environment neutral_environment();

scene::Environment constant_environment(const std::vector<float>& radiance);

// Index of the camera an option names by index or name. Throws base::Error naming what the file has.
int find_camera(const scene::Scene& scene, const std::string& camera);

}  // namespace app
