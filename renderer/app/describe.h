// --info: what is in a scene, and what a render of it would use.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/options.h"
#include "scene/scene.h"

namespace app {

// The file's contents and what will be used. `scene` is as it will be rendered, `options` are complete and
// `reduced` is Renderer::summary().
nlohmann::ordered_json describe(const Options& options, const scene::Scene& scene,
                                const std::string& reduced);

// The same for people: a line for each value, each line of a list and each element.
std::string describe_text(const nlohmann::ordered_json& description);

}  // namespace app
