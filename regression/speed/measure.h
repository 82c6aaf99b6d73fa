// One scene: doubling samples, all contestants in turn, round after round with other seeds, until its time is
// spent. What comes out is JSON, docs/speed.md's raw material:
//
//   {"name", "size", "threads", "rounds", "load": [before, after],
//    "references": {FAMILY: {"spp", "mean", "error"}},
//    "contestants": {NAME: {"family", "compared_at", "build_seconds", "load_seconds", "process_seconds",
//                           "peak_mb", "levels": [{"spp", "seconds": [of each round], "mse", "relative",
//                           "flip": [...], "rays", "variance", "bias2": [value, error]}],
//                           "mean_bias": [relative, error]}}}
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "speed/contestants.h"

namespace speed {

struct Plan {
  double seconds = 60;  // for a scene, about
  int size = 128, threads = 0;
  int rounds_min = 3, rounds_max = 8;
};

// `keep` is called with the scene's results after each round.
nlohmann::json measure_scene(const std::string& name, const std::string& file, const Plan& plan,
                             const std::vector<Contestant>& contestants, Runner& runner,
                             const std::function<void(const nlohmann::json&)>& keep = {});

// Samples of each contestant's levels: from first to last, the dearest left out until `rounds` rounds fit
// into `seconds`; what comparisons stand on, at 64 and `compared_at`, always stays. `cost`: seconds of one
// sample.
std::vector<std::vector<int>> choose_levels(const std::vector<Contestant>& contestants,
                                            const std::vector<double>& cost, int rounds, double seconds);

// The one-minute load of the machine.
double load_average();

}  // namespace speed
