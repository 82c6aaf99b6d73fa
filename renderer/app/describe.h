// --info: what is in a scene, and what a render of it would use.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/options.h"
#include "scene/scene.h"

namespace app {

// Everything that decides the picture; dumped without blanks it is `assay:options`. `scene` is as it will be
// rendered and `options` are complete.
nlohmann::json decisive(const Options& options, const scene::Scene& scene);

// The file's contents and what will be used. `reduced` is Renderer::summary().
nlohmann::json describe(const Options& options, const scene::Scene& scene, const std::string& reduced);

// The same for people.
std::string describe_text(const nlohmann::json& description);

}  // namespace app
