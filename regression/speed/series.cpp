#include "speed/series.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <regex>
#include <utility>

#include "base/error.h"
#include "image/io.h"
#include "speed/errors.h"
#include "speed/fit.h"
#include "suite/process.h"

namespace speed {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int series_spp = 16, repeats = 3;

void run(const std::vector<std::string>& command, const suite::OnLine& on_line = {}) {
  const suite::ProcessEnd end = suite::run_process(command, 600, on_line);
  if (!end.ok()) base::fail(command.front(), ": ", end.reason());
}

template <typename Work>
double median_seconds(int times, const Work& work) {
  std::vector<double> seconds;
  for (int i = 0; i < times; ++i) {
    const auto start = Clock::now();
    work(i);
    seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
  }
  return median(seconds);
}

}  // namespace

json measure_series(const json& series, const std::string& scenes, const Plan& plan,
                    const std::vector<Contestant>& contestants, Runner& runner) {
  json out = {{"name", series.at("name")}, {"axis", series.at("axis")}, {"points", json::array()}};
  for (const json& point : series.at("points")) {
    Order order;
    order.scene = scenes + "/" + point.at("scene").get<std::string>() + ".glb";
    order.size = point.value("size", plan.size);
    order.threads = point.value("threads", plan.threads);
    order.spp = series_spp;
    const double pixels = static_cast<double>(order.size) * order.size;
    struct Result {
      std::vector<image::Image> pictures;
      std::vector<double> seconds;
      double build = 0, peak_mb = 0;
    };
    std::map<std::string, Result> results;
    for (int i = 0; i < repeats; ++i)
      for (const Contestant& contestant : contestants) {
        if (!contestant.is_reference || (point.contains("only") && point["only"] != contestant.name))
          continue;
        order.seed = 1 + i;
        Shot shot = runner.render(contestant, order);
        Result& result = results[contestant.name];
        if (i == 0) result.build = shot.build_seconds;
        result.peak_mb = shot.peak_mb;
        result.seconds.push_back(shot.render_seconds);
        result.pictures.push_back(std::move(shot.picture));
      }
    runner.dismiss();  // memory is told as the largest a process ever had
    json entry = {{"x", point.at("x")}, {"pixels", pixels}};
    for (const auto& [name, result] : results) {
      std::vector<const image::Image*> pictures;
      for (const image::Image& picture : result.pictures) pictures.push_back(&picture);
      const double mean = image_mean(pictures).value, seconds = median(result.seconds);
      const double noise = (variance(*pictures[0], *pictures[1], *pictures[2]).mse +
                            variance(*pictures[1], *pictures[2], *pictures[0]).mse) /
                           2;
      entry[name] = {{"seconds", seconds / pixels / series_spp},
                     {"build_seconds", result.build},
                     {"peak_mb", result.peak_mb},
                     {"cost", seconds / pixels * noise / (mean * mean)}};
    }
    out["points"].push_back(entry);
  }
  return out;
}

std::vector<std::string> command_line(const Contestant& contestant, const Order& order,
                                      const std::string& out) {
  suite::Job job;
  job.scene = order.scene, job.out = out, job.shader = "principled";
  job.width = job.height = order.size, job.spp = order.spp, job.depth = order.depth;
  job.seed = static_cast<std::uint32_t>(order.seed), job.replicates = 1;
  suite::RendererCommand command = *contestant.command;
  command.set_threads(order.threads);
  return command.arguments(job);
}

json measure_small(const std::string& scene, const std::string& assay,
                   const std::vector<Contestant>& contestants, const std::string& scratch) {
  constexpr int jobs = 100;
  std::filesystem::create_directories(scratch);
  Order order;
  order.scene = scene, order.size = 64, order.spp = 16;
  json list = json::array();
  for (int i = 0; i < jobs; ++i)
    list.push_back({{"scene", scene},
                    {"out", scratch + "/batch" + std::to_string(i) + ".exr"},
                    {"width", 64},
                    {"height", 64},
                    {"spp", 16},
                    {"replicates", 1},
                    {"seed", i + 1},
                    {"shader", "principled"}});
  const std::string text = json{{"jobs", list}}.dump(), file = scratch + "/batch.json";
  image::write_file(file, text.data(), text.size());
  const Contestant& ours = contestants.front();
  json out = {{"jobs", jobs}};
  std::vector<double> warm;  // of each job but those that come first, from its start to its picture on disk
  out["batch_seconds"] = median_seconds(3, [&](int) {
    bool first = true;
    run({assay, "--batch", file, "--quiet", "--json"}, [&](const std::string& line) {
      if (!std::exchange(first, false)) warm.push_back(json::parse(line).at("seconds"));
      return 0.;
    });
  });
  out["warm_seconds"] = median(warm);
  out["single_seconds"] = median_seconds(1, [&](int) {
    for (int i = 0; i < jobs; ++i) {
      order.seed = i + 1;
      run(command_line(ours, order, scratch + "/single.exr"));
    }
  });
  order.size = 512;
  for (const Contestant& contestant : contestants)
    if (contestant.is_reference)
      out["whole"][contestant.name] = median_seconds(3, [&](int i) {
        order.seed = i + 1;
        Runner fresh(scratch);  // its workers end with it
        fresh.render(contestant, order);
      });
  return out;
}

json measure_bias(const std::string& file, double resolved, const Plan& plan,
                  const std::vector<Contestant>& contestants, Runner& runner) {
  struct Sum {
    const Contestant* contestant;
    double n = 0, sum = 0, squares = 0;
    double mean() const { return sum / n; }
    double error2() const { return (squares / n - mean() * mean()) / (n - 1); }
  };
  std::vector<Sum> sums;
  for (const Contestant& c : contestants)
    if (c.family == contestants.front().family && (c.is_reference == sums.empty())) sums.push_back({&c});
  json out = json::object();
  if (sums.size() < 2) return out;
  Order order;
  order.scene = file, order.size = plan.size, order.threads = plan.threads, order.spp = 64;
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  constexpr int fewest = 20;
  for (bool enough = false; !enough;) {
    for (Sum& s : sums) {
      ++order.seed;
      const std::vector<float> values = runner.render(*s.contestant, order).picture.data;
      const double mean =
          std::accumulate(values.begin(), values.end(), 0.) / static_cast<double>(values.size());
      ++s.n, s.sum += mean, s.squares += mean * mean;
    }
    if (sums[0].n < fewest) continue;
    enough = true;
    for (std::size_t i = 1; i < sums.size(); ++i) {
      const double truth = sums[0].mean(), error = std::sqrt(sums[0].error2() + sums[i].error2()) / truth;
      out[sums[i].contestant->name] = {
          {"relative", sums[i].mean() / truth - 1}, {"error", error}, {"pictures", sums[0].n}};
      enough = enough && normal_999 * error < resolved;
    }
    enough = enough || seconds() > plan.seconds;
  }
  return out;
}

json profile(const std::vector<std::string>& command, const std::string& scratch) {
  std::filesystem::create_directories(scratch);
  const std::string data = scratch + "/perf.data";
  std::vector<std::string> record = {"perf", "record", "-q", "-F", "499", "-o", data, "--"};
  record.insert(record.end(), command.begin(), command.end());
  if (!suite::run_process(record, 600).ok()) return nullptr;
  json shares = json::object();
  const std::regex row("^ *([0-9.]+)% +([^ ]+).*");
  const suite::ProcessEnd end = suite::run_process({"perf", "report", "-i", data, "--sort", "dso", "--stdio"},
                                                   120, [&](const std::string& line) {
                                                     std::smatch match;
                                                     if (std::regex_match(line, match, row))
                                                       shares[match[2].str()] = std::stod(match[1].str());
                                                     return 0.;
                                                   });
  std::filesystem::remove(data);
  return end.ok() && !shares.empty() ? shares : json();
}

}  // namespace speed
