// How cost grows: triangles, lights, resolution, threads; and what a small job costs. Each is JSON again:
//
//   {"name", "axis", "points": [{"x", "pixels", NAME: {"seconds": per pixel and sample, "build_seconds",
//    "peak_mb", "cost": seconds x variance / mean^2}}]}
//   {"batch_seconds", "warm_seconds": of one job, "single_seconds", "jobs", "whole": {NAME: seconds}}
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "speed/contestants.h"
#include "speed/measure.h"

namespace speed {

// `series`: an entry of scenes.json. Contestants that are references take part, three renders of 16 samples
// each.
nlohmann::json measure_series(const nlohmann::json& series, const std::string& scenes, const Plan& plan,
                              const std::vector<Contestant>& contestants, Runner& runner);

// 100 jobs of 64 x 64 and 16 samples in one process and each in its own, and one of 512 x 512 and 16 samples
// from start to end of the process, medians of three. `assay` is the renderer's program.
nlohmann::json measure_small(const std::string& scene, const std::string& assay,
                             const std::vector<Contestant>& contestants, const std::string& scratch);

// How far the mean of pictures with 64 samples is from that of fixed samples, in turn, for each contestant
// that has the first one's reference and is not it: {NAME: {"relative", "error", "pictures": of each}}.
// Until 3.29 standard errors are below `resolved` (relative), at least 20 pictures, at most plan.seconds.
nlohmann::json measure_bias(const std::string& file, double resolved, const Plan& plan,
                            const std::vector<Contestant>& contestants, Runner& runner);

// Percent of the samples that `perf` finds in each library while the command runs: {"libembree3.so.3": 56.1}.
// Null where perf cannot be used.
nlohmann::json profile(const std::vector<std::string>& command, const std::string& scratch);

// The command line with which Assay renders this order, for profiles.
std::vector<std::string> command_line(const Contestant& contestant, const Order& order,
                                      const std::string& out);

}  // namespace speed
