#include "speed/page.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <thread>

#include "speed/compare.h"
#include "suite/process.h"

namespace speed {
namespace {

using nlohmann::json;

struct Section {
  std::string title, text;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::string plot;  // file name, without folder
};

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

// Two significant digits or so, for ratios of any size.
std::string short_number(double value) {
  return format(std::abs(value) >= 100 ? "%.0f" : std::abs(value) >= 10 ? "%.1f" : "%.2f", value);
}

std::string cell(const std::optional<Ratio>& ratio) {
  if (!ratio) return "–";
  return short_number(ratio->value) + " ± " + short_number(ratio->error) + (ratio->extrapolated ? "*" : "");
}

std::vector<std::string> names(const json& scene, bool ours) {
  std::vector<std::string> found;
  for (const auto& [name, contestant] : scene.at("contestants").items())
    if ((contestant.at("family") == "assay") == ours) found.push_back(name);
  return found;
}

// Opponents of any scene, in the order of their names.
std::vector<std::string> opponents(const json& all) {
  std::vector<std::string> found;
  for (const json& scene : all.at("scenes"))
    for (const std::string& name : names(scene, false))
      if (std::find(found.begin(), found.end(), name) == found.end()) found.push_back(name);
  return found;
}

Section equal_errors(const json& all) {
  Section s;
  s.title = "Time to equal error";
  s.text =
      "How many times longer the other renderer takes to its error at 64 samples (adaptive Cycles: at most "
      "256, the error it then has), with its standard error (jackknife over the rounds). Above 1 Assay is "
      "faster. A star: our curve was prolonged.";
  const std::vector<std::string> others = opponents(all);
  s.header = {"scene", "contestant"};
  const std::vector<std::pair<std::string, std::string>> metrics = {
      {"mse", "RMSE"}, {"relative", "relative MSE"}, {"flip", "FLIP"}};
  for (const auto& [key, label] : metrics)
    for (const std::string& other : others) s.header.push_back(label + ", " + other);
  for (const json& scene : all.at("scenes"))
    for (const std::string& name : names(scene, true)) {
      std::vector<std::string> row = {scene.at("name"), name};
      for (const auto& [key, label] : metrics)
        for (const std::string& other : others)
          row.push_back(scene.at("contestants").contains(other) ? cell(equal_error(scene, name, other, key))
                                                                : "–");
      s.rows.push_back(row);
    }
  s.plot = "error.svg";
  return s;
}

// A relative bias with its interval at 99.9 %.
std::string bias_text(double relative, double error) {
  return format("%+.3f", 100 * relative) + " ± " + format("%.3f %%", 100 * normal_999 * error);
}

Section fits(const json& all) {
  Section s;
  s.title = "How error falls, and what stays";
  s.text =
      "MSE = a N^-p + b² over N samples; b², the bias, is measured without bias as the mean of (A - C)(B - "
      "D) over four "
      "independent renders, C and D long ones of the same renderer with fixed samples. b is relative to the "
      "image's mean: the "
      "value if it is significant at 99.9 %, else the largest it can be. The mean of all of a contestant's "
      "renders less that of "
      "its converged picture, with its interval at 99.9 %. Efficiency is 1/(MSE × time) at 64 samples, over "
      "that of Cycles.";
  s.header = {"scene", "contestant", "p", "b", "bias of the mean", "efficiency"};
  for (const json& scene : all.at("scenes"))
    for (const auto& [name, contestant] : scene.at("contestants").items()) {
      const double mean = scene.at("references").at(contestant.at("family").get<std::string>()).at("mean");
      const auto power = fit(contestant);
      const json* best = nullptr;
      for (const json& level : contestant.at("levels"))
        if (level.contains("bias2") && (!best || level["bias2"][1] < (*best)["bias2"][1])) best = &level;
      std::string b = "–";
      if (best) {
        const double value = (*best)["bias2"][0], error = normal_999 * (*best)["bias2"][1].get<double>();
        b = value > error ? format("%.2f %%", 100 * std::sqrt(value) / mean)
                          : "< " + format("%.2f %%", 100 * std::sqrt(std::max(value, 0.) + error) / mean);
      }
      const json& bias = contestant.at("mean_bias");
      const std::string mean_text = bias.is_null() ? "–" : bias_text(bias[0], bias[1]);
      const double theirs =
          scene["contestants"].contains("cycles") ? efficiency(scene["contestants"]["cycles"], 64) : 0;
      const double own = efficiency(contestant, contestant.at("compared_at").get<int>());
      s.rows.push_back({scene.at("name"), name, power ? format("%.2f", power->p) : "–", b, mean_text,
                        theirs > 0 && own > 0 ? short_number(own / theirs) : "–"});
    }
  return s;
}

Section adaptive_bias(const json& all) {
  Section s;
  s.title = "Bias of adaptive sampling";
  s.text =
      "Mean of pictures with 64 adaptive samples, less that of fixed ones (`assay speed --bias`), with its "
      "interval at 99.9 %.";
  s.header = {"scene", "contestant", "bias of the mean", "pictures"};
  for (const auto& [scene, contestants] : all.at("bias").items())
    for (const auto& [name, bias] : contestants.items())
      s.rows.push_back({scene, name, bias_text(bias.at("relative"), bias.at("error")),
                        format("%.0f", bias.at("pictures").get<double>())});
  return s;
}

Section agreement(const json& all) {
  Section s;
  s.title = "The same picture";
  s.text = "Means of the converged pictures, less Assay's, with the interval at 99.9 %.";
  s.header = {"scene", "what", "renderer", "its mean less Assay's"};
  for (const json& scene : all.at("scenes")) {
    const json& references = scene.at("references");
    if (!references.contains("assay")) continue;
    const double mean = references["assay"]["mean"], error = references["assay"]["error"];
    const std::string name = scene.at("name");
    for (const auto& [family, reference] : references.items())
      if (family != "assay")
        s.rows.push_back(
            {name, all.value("what", json::object()).value(name, ""), family,
             format("%+.2f", 100 * (reference["mean"].get<double>() / mean - 1)) + " ± " +
                 format("%.2f %%",
                        100 * normal_999 * std::hypot(error, reference["error"].get<double>()) / mean)});
  }
  return s;
}

Section resources(const json& all) {
  Section s;
  s.title = "Rays, memory, preparation";
  s.text =
      "Rays per second and thread-time inside Embree (perf, whole process) are Assay's; Cycles tells "
      "neither. Memory is the "
      "largest resident size of the process, Blender's with its program. Preparation is loading, BVH and, "
      "with Cycles, "
      "synchronisation, in percent of that renderer's render time at 64 samples.";
  s.header = {"scene", "contestant", "Mrays/s", "inside Embree", "memory, MB", "preparation"};
  for (const json& scene : all.at("scenes"))
    for (const auto& [name, contestant] : scene.at("contestants").items()) {
      double rays = 0, at64 = 0;
      for (const json& level : contestant.at("levels")) {
        if (level["spp"] != contestant.at("compared_at") || level["seconds"].empty()) continue;
        at64 = median(level["seconds"].get<std::vector<double>>());
        rays = level.value("rays", 0.) / at64 * 1e-6;
      }
      double embree = 0, rendering = 0;
      if (name == "assay" && scene.contains("profile") && scene["profile"].is_object())
        for (const auto& [object, share] : scene["profile"].items()) {
          const bool is_embree = object.find("libembree") == 0;
          if (is_embree) embree += share.get<double>();
          if (is_embree || object == "assay-render" || object.find("libm.") == 0 ||
              object.find("libtbb") == 0)
            rendering += share.get<double>();
        }
      const double before =
          contestant["build_seconds"].get<double>() + contestant["load_seconds"].get<double>();
      s.rows.push_back({scene.at("name"), name, rays > 0 ? short_number(rays) : "–",
                        embree > 0 ? format("%.0f %%", 100 * embree / rendering) : "–",
                        format("%.0f", contestant["peak_mb"].get<double>()),
                        at64 > 0 ? format("%.0f %%", 100 * before / at64) : "–"});
    }
  return s;
}

// Everything relative to Assay's first point, so that growth can be read.
Section growth(const json& series) {
  Section s;
  s.title = "Growth: " + series.at("name").get<std::string>();
  s.text =
      "Time per sample and pixel, BVH time and the cost of equal noise (time × variance / mean²), each over "
      "Assay's at the first "
      "point; memory in MB.";
  s.header = {
      series.at("axis").get<std::string>(), "renderer", "time", "BVH", "cost of equal noise", "memory, MB"};
  json first;
  for (const json& point : series.at("points"))
    for (const auto& item : point.items()) {
      const json& value = item.value();
      if (!value.is_object()) continue;
      if (first.is_null()) first = value;
      const auto over = [&](const char* key) {
        const double base = first.at(key);
        return base > 0 ? short_number(value.at(key).get<double>() / base) : std::string("–");
      };
      s.rows.push_back({format("%.0f", point["x"].get<double>()), item.key(), over("seconds"),
                        over("build_seconds"), over("cost"), format("%.0f", value["peak_mb"].get<double>())});
    }
  return s;
}

Section small(const json& result) {
  Section s;
  s.title = "Small renders";
  s.text =
      "64 × 64 and 16 samples, all in one process (`assay-render --batch`) and each in its own; and the "
      "whole process, start to "
      "end, for 512 × 512 and 16 samples.";
  s.header = {"what", "result"};
  const double jobs = result.at("jobs"), batch = result.at("batch_seconds"),
               single = result.at("single_seconds");
  s.rows.push_back({"a batch over its jobs, in this run", format("%.0f ms", 1000 * batch / jobs)});
  if (result.contains("warm_seconds"))
    s.rows.push_back({"a job in it, the median of all but the first",
                      format("%.0f ms", 1000 * result["warm_seconds"].get<double>())});
  s.rows.push_back({"jobs started alone, over the batch", short_number(single / batch)});
  if (result.contains("whole") && result["whole"].contains("assay"))
    for (const auto& [name, seconds] : result["whole"].items())
      if (name != "assay")
        s.rows.push_back({"512 × 512, whole process: " + name + " over assay",
                          short_number(seconds.get<double>() / result["whole"]["assay"].get<double>())});
  return s;
}

std::vector<Section> sections(const json& all) {
  std::vector<Section> list;
  Section about;
  about.title = "This run";
  const json machine = all.value("machine", json::object());
  for (const auto& [key, value] : machine.items())
    about.rows.push_back({key, value.is_string() ? value.get<std::string>() : value.dump()});
  double load = 0;
  std::string sizes;
  for (const json& scene : all.at("scenes")) {
    for (const json& value : scene.at("load")) load = std::max(load, value.get<double>());
    const std::string size = std::to_string(scene.at("size").get<int>());
    sizes = size + " × " + size + " pixels, depth 8, box filter, shader `principled`";
  }
  about.rows.push_back({"pictures", sizes});
  about.rows.push_back({"largest load average during the run", format("%.1f", load)});
  about.header = {"", ""};
  list.push_back(about);
  if (!all.at("scenes").empty())
    for (const auto& make : {equal_errors, fits, agreement, resources}) list.push_back(make(all));
  if (all.contains("bias")) list.push_back(adaptive_bias(all));
  for (const json& series : all.value("series", json::object())) list.push_back(growth(series));
  if (!list.empty() && list.back().title.rfind("Growth", 0) == 0) list.back().plot = "growth.svg";
  if (all.contains("small")) list.push_back(small(all["small"]));
  return list;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

}  // namespace

std::string markdown(const json& all, const std::string& images) {
  std::ostringstream out;
  out << "`" << all.value("command", "") << "`\n";
  for (const Section& s : sections(all)) {
    out << "\n### " << s.title << "\n\n" << s.text << (s.text.empty() ? "" : "\n\n");
    for (const std::string& word : s.header) out << "| " << word << " ";
    out << "|\n";
    for (std::size_t i = 0; i < s.header.size(); ++i) out << (i < 2 ? "|---" : "|---:");
    out << "|\n";
    for (const auto& row : s.rows) {
      for (const std::string& word : row) out << "| " << word << " ";
      out << "|\n";
    }
    if (!s.plot.empty() && !images.empty())
      out << "\n![" << s.title << "](" << images << "/" << s.plot << ")\n";
  }
  return out.str();
}

std::string html(const json& all, const std::vector<std::string>& plots) {
  std::ostringstream out;
  out << "<!DOCTYPE html><html lang=\"en\"><meta charset=\"utf-8\"><title>assay "
         "speed</title><style>body{font:15px/1.5 "
         "system-ui,sans-serif;max-width:75em;margin:2em auto;padding:0 "
         "1em}table{border-collapse:collapse;font-variant-numeric:"
         "tabular-nums}td,th{padding:.2em .8em;border-bottom:1px solid "
         "#ddd;text-align:right}td:first-child,td:nth-child(2),"
         "th:first-child,th:nth-child(2){text-align:left}svg{max-width:100%;height:auto}</style><h1>Speed "
         "against error</h1><p><code>"
      << escaped(all.value("command", "")) << "</code></p>";
  for (const std::string& plot : plots) out << plot.substr(std::min(plot.find("<svg"), plot.size()));
  for (const Section& s : sections(all)) {
    out << "<h2>" << escaped(s.title) << "</h2><p>" << escaped(s.text) << "</p><table><tr>";
    for (const std::string& word : s.header) out << "<th>" << escaped(word) << "</th>";
    out << "</tr>";
    for (const auto& row : s.rows) {
      out << "<tr>";
      for (const std::string& word : row) out << "<td>" << escaped(word) << "</td>";
      out << "</tr>";
    }
    out << "</table>\n";
  }
  out << "</html>\n";
  return out.str();
}

json machine(const std::string& renderer) {
  json about = json::object();
  std::ifstream cpu("/proc/cpuinfo");
  for (std::string line; std::getline(cpu, line);)
    if (line.rfind("model name", 0) == 0) {
      about["CPU"] = line.substr(line.find(':') + 2);
      break;
    }
  about["threads"] = std::to_string(std::thread::hardware_concurrency());
  about["memory"] = format("%.0f GB", static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
                                          static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 30));
  utsname system{};
  if (uname(&system) == 0)
    about["system"] = std::string(system.sysname) + " " + system.release + " " + system.machine;
  if (renderer.empty()) return about;
  const auto first_line = [&](const char* what, const std::vector<std::string>& command) {
    suite::run_process(command, 60, [&](const std::string& line) {
      if (!about.contains(what)) about[what] = line;
      return 0.;
    });
  };
  first_line("assay", {renderer, "--version"});
  const char* blender = std::getenv("ASSAY_BLENDER");
  first_line("cycles", {blender ? blender : "blender", "--version"});
  return about;
}

}  // namespace speed
