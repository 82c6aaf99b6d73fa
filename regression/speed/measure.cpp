#include "speed/measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>

#include "base/error.h"
#include "metric/flip.h"
#include "speed/errors.h"
#include "speed/fit.h"

namespace speed {
namespace {

using image::Image;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int pilot_spp = 16;
constexpr double reference_share = .35;  // of a scene's time
constexpr int reference_spp_min = 256, reference_spp_max = 65536;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Every render of a scene has another seed, far from the others'.
class Seeds {
 public:
  int next() { return static_cast<int>(1 + (count_++ * 104729u) % 2147483647u); }

 private:
  unsigned count_ = 0;
};

// What one contestant has rendered at one number of samples.
struct LevelResult {
  int spp = 0;
  std::vector<Image> pictures;
  json seconds = json::array(), mse = json::array(), relative = json::array(), flip = json::array();
  double rays = 0;
};

struct Entry {
  const Contestant* contestant = nullptr;
  Shot pilot;
  std::vector<LevelResult> levels;
};

void add(LevelResult& level, Shot shot, const Reference& reference) {
  const Errors errors = against(shot.picture, reference);
  const metric::Flip flip = metric::hdr_flip(reference.mean, shot.picture);
  level.seconds.push_back(shot.render_seconds);
  level.mse.push_back(errors.mse), level.relative.push_back(errors.relative_mse);
  level.flip.push_back(flip.ok() ? json(flip.mean) : json());
  level.rays = shot.rays;
  level.pictures.push_back(std::move(shot.picture));
}

std::vector<const Image*> pointers(const std::vector<Image>& pictures) {
  std::vector<const Image*> all;
  for (const Image& picture : pictures) all.push_back(&picture);
  return all;
}

json level_json(const LevelResult& level, const Reference& reference) {
  json out = {{"spp", level.spp},           {"seconds", level.seconds}, {"mse", level.mse},
              {"relative", level.relative}, {"flip", level.flip},       {"rays", level.rays}};
  if (level.pictures.size() < 2) return out;
  double own = 0, pairs = 0;
  for (std::size_t i = 0; i < level.pictures.size(); ++i)
    for (std::size_t j = i + 1; j < level.pictures.size(); ++j, ++pairs)
      own += variance(level.pictures[i], level.pictures[j], reference.mean).mse;
  const Estimate b2 = bias_squared(pointers(level.pictures), reference);
  out["variance"] = own / pairs;
  out["bias2"] = {b2.value, b2.standard_error};
  return out;
}

// Mean of all a contestant's renders less that of its reference, relative. Levels weigh as their samples do.
json mean_bias(const Entry& entry, const Reference& reference) {
  const Estimate truth = image_mean({&reference.c, &reference.d});
  double weights = 0, value = 0, square = 0;
  for (const LevelResult& level : entry.levels) {
    if (level.pictures.size() < 2) continue;
    const Estimate mean = image_mean(pointers(level.pictures));
    weights += level.spp, value += level.spp * mean.value;
    square += level.spp * level.spp * mean.standard_error * mean.standard_error;
  }
  if (weights == 0 || truth.value == 0) return nullptr;
  const double error = std::hypot(std::sqrt(square) / weights, truth.standard_error);
  return {value / weights / truth.value - 1, error / truth.value};
}

json results(const std::string& name, const Plan& plan, std::size_t rounds, const std::vector<Entry>& entries,
             const std::map<std::string, Reference>& references,
             const std::map<std::string, int>& reference_spp, double load_before) {
  json out = {{"name", name},
              {"size", plan.size},
              {"threads", plan.threads},
              {"rounds", rounds},
              {"load", {load_before, load_average()}}};
  for (const auto& [family, reference] : references) {
    const Estimate mean = image_mean({&reference.c, &reference.d});
    out["references"][family] = {
        {"spp", 2 * reference_spp.at(family)}, {"mean", mean.value}, {"error", mean.standard_error}};
  }
  for (const Entry& entry : entries) {
    const Contestant& c = *entry.contestant;
    const Reference& reference = references.at(c.family);
    json levels = json::array();
    for (const LevelResult& level : entry.levels) levels.push_back(level_json(level, reference));
    out["contestants"][c.name] = {{"family", c.family},
                                  {"compared_at", c.compared_at},
                                  {"build_seconds", entry.pilot.build_seconds},
                                  {"load_seconds", entry.pilot.load_seconds},
                                  {"process_seconds", entry.pilot.process_seconds},
                                  {"peak_mb", entry.pilot.peak_mb},
                                  {"levels", levels},
                                  {"mean_bias", mean_bias(entry, reference)}};
  }
  return out;
}

}  // namespace

double load_average() {
  double load[1] = {0};
  return getloadavg(load, 1) == 1 ? load[0] : 0;
}

std::vector<std::vector<int>> choose_levels(const std::vector<Contestant>& contestants,
                                            const std::vector<double>& cost, int rounds, double seconds) {
  std::vector<std::vector<int>> levels(contestants.size());
  double total = 0;
  for (std::size_t i = 0; i < contestants.size(); ++i)
    for (int spp = contestants[i].first; spp <= contestants[i].last; spp *= 2)
      levels[i].push_back(spp), total += rounds * spp * cost[i];
  while (total > seconds) {
    std::size_t dearest = contestants.size();
    double most = 0;
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      const int top = levels[i].back();
      if (top > std::max(64, contestants[i].compared_at) && top * cost[i] > most)
        dearest = i, most = top * cost[i];
    }
    if (dearest == contestants.size()) break;
    levels[dearest].pop_back();
    total -= rounds * most;
  }
  return levels;
}

json measure_scene(const std::string& name, const std::string& file, const Plan& plan,
                   const std::vector<Contestant>& contestants, Runner& runner,
                   const std::function<void(const json&)>& keep) {
  const auto start = Clock::now();
  const double load_before = load_average();
  Seeds seeds;
  Order order;
  order.scene = file, order.size = plan.size, order.threads = plan.threads;
  const auto shoot = [&](const Contestant& contestant, int spp) {
    order.spp = spp, order.seed = seeds.next();
    return runner.render(contestant, order);
  };

  // A first look at everybody: start-up, loading, the BVH, and what a sample costs (the second time, warm).
  std::vector<Entry> entries;
  std::vector<double> cost;
  for (const Contestant& contestant : contestants) {
    entries.push_back({&contestant, shoot(contestant, pilot_spp), {}});
    cost.push_back(shoot(contestant, pilot_spp).render_seconds / pilot_spp);
  }

  // Each family's converged picture, in two halves.
  std::map<std::string, Reference> references;
  std::map<std::string, int> reference_spp;
  const double families = static_cast<double>(std::count_if(
      contestants.begin(), contestants.end(), [](const Contestant& c) { return c.is_reference; }));
  for (std::size_t i = 0; i < contestants.size(); ++i) {
    if (!contestants[i].is_reference) continue;
    int spp = reference_spp_min;
    while (spp < reference_spp_max && 4 * spp * cost[i] < reference_share * plan.seconds / families) spp *= 2;
    Image c = shoot(contestants[i], spp).picture;
    references[contestants[i].family] = Reference(std::move(c), shoot(contestants[i], spp).picture);
    reference_spp[contestants[i].family] = spp;
  }

  // In turn at each number of samples, so that a disturbance of the machine hits all alike.
  const auto levels = choose_levels(contestants, cost, plan.rounds_min, plan.seconds - since(start));
  int most = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    for (const int spp : levels[i]) entries[i].levels.emplace_back().spp = spp;
    most = std::max(most, levels[i].back());
  }
  json out;
  double round_seconds = 0;
  for (int round = 0; round < plan.rounds_max; ++round) {
    if (round >= plan.rounds_min && since(start) + round_seconds > plan.seconds) break;
    const auto round_start = Clock::now();
    for (int spp = 1; spp <= most; spp *= 2)
      for (Entry& entry : entries)
        for (LevelResult& level : entry.levels)
          if (level.spp == spp)
            add(level, shoot(*entry.contestant, spp), references.at(entry.contestant->family));
    round_seconds = since(round_start);
    out = results(name, plan, static_cast<std::size_t>(round) + 1, entries, references, reference_spp,
                  load_before);
    if (keep) keep(out);
  }
  return out;
}

}  // namespace speed
