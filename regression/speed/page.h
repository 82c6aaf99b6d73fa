// The measurements as text: the section of docs/speed.md, and a page of HTML with the plots inside.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace speed {

// `all`: {"command", "machine", "scenes": {NAME: measure.h}, "what": {NAME: sentence}, "series": {NAME:
// series.h}, "small"}. `images`: where the plots are, seen from the page ("images/speed"); empty: no plots.
std::string markdown(const nlohmann::json& all, const std::string& images);

// One file; `plots`: SVG texts.
std::string html(const nlohmann::json& all, const std::vector<std::string>& plots);

// CPU, threads, memory, system; the versions of Assay and Blender if `renderer` names Assay's program.
nlohmann::json machine(const std::string& renderer);

}  // namespace speed
