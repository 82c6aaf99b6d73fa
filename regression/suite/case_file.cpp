#include "suite/case_file.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "base/error.h"
#include "suite/schema.h"

namespace suite {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

double default_tolerance(const std::string& quantity) {
  if (quantity == "position") return 1e-4;
  if (quantity == "normal") return 1e-3;
  if (quantity == "brdf") return 1e-5;
  return .02;  // direct, mirror
}

Witness read_witness(const Case& c, const json& entry, const std::string& place) {
  Witness w;
  const std::string kind = entry["kind"];
  w.kind = kind == "blender"  ? WitnessKind::blender
           : kind == "povray" ? WitnessKind::povray
                              : WitnessKind::analytic;
  w.margin = entry.value("margin", w.kind == WitnessKind::povray ? .001 : .005);
  w.spp = entry.value("spp", w.spp);
  w.seeds = entry.value("seeds", w.seeds);
  w.flip = entry.value("flip", true);
  w.quantity = entry.value("quantity", "");
  w.tolerance = entry.value("tolerance", default_tolerance(w.quantity));
  w.coverage = entry.value("coverage", w.coverage);
  if (entry.contains("mean")) w.mean = entry["mean"];
  if (entry.contains("rect")) w.rect = entry["rect"].get<std::array<int, 4>>();
  w.source = entry.value("source", "");
  const bool geometry = w.quantity == "position" || w.quantity == "normal";
  w.shader = entry.value("shader", geometry ? w.quantity : c.shader);
  w.depth = entry.value("depth", w.quantity == "direct" ? 1 : c.depth);
  w.expect_differs = entry.value("expect", "agrees") == "differs";
  w.because = entry.value("because", "");
  w.label = kind + (w.quantity.empty() ? "" : "." + w.quantity);

  // What the schema cannot say.
  if (w.expect_differs && w.because.empty())
    base::fail_in(c.file, place, "the key \"because\" beside \"expect\": \"differs\"", "none");
  if (w.rect) {
    const auto [x, y, width, height] = *w.rect;
    if (width < 1 || height < 1 || x + width > c.width || y + height > c.height)
      base::fail_in(c.file, place + ".rect", "a rectangle inside the image", entry["rect"].dump());
  }
  return w;
}

}  // namespace

Layout Layout::find(std::string root, std::string build) {
  Layout layout;
  if (root.empty()) {
    for (fs::path folder = fs::current_path();; folder = folder.parent_path()) {
      if (fs::is_directory(folder / "regression" / "cases")) root = (folder / "regression").string();
      if (!root.empty() || folder == folder.parent_path()) break;
    }
    if (root.empty())
      base::fail_in(fs::current_path().string(), "",
                    "to stand in a checkout with regression/cases, or --suite DIR", "neither");
  }
  if (!fs::is_directory(fs::path(root) / "cases"))
    base::fail_in(root, "", "a folder that holds cases/", "none");
  layout.root = fs::path(root).lexically_normal().string();
  while (layout.root.size() > 1 && layout.root.back() == '/') layout.root.pop_back();
  const fs::path beside = fs::absolute(layout.root).parent_path();
  layout.reference = fs::is_directory(fs::path(layout.root) / "reference") ? layout.root + "/reference"
                                                                           : (beside / "reference").string();
  layout.build = build.empty() ? (beside / "build").string() : build;
  return layout;
}

std::string Layout::witness_folder(WitnessKind kind) const {
  return reference + (kind == WitnessKind::blender ? "/blender" : "/povray");
}

std::string Layout::witness_file(const Case& c, const Witness& witness) const {
  if (witness.kind == WitnessKind::analytic) return "";
  const std::string quantity = witness.quantity.empty() ? "" : "." + witness.quantity;
  return witness_folder(witness.kind) + "/renders/" + c.name + quantity + ".exr";
}

Case read_case(const Layout& layout, const std::string& name) {
  Case c;
  c.file = layout.case_file(name);
  const json j = read_json(c.file);
  check_schema(c.file, j, case_schema());
  c.name = j["name"];
  if (c.name != name)
    base::fail_in(c.file, "name", "\"" + name + "\" as the file is called", j["name"].dump());
  c.why = j["why"];
  c.scene = j["scene"];
  if (!fs::is_regular_file(layout.scene_file(c)))
    base::fail_in(c.file, "scene", "a file in " + layout.root + "/scenes", j["scene"].dump());
  c.shader = j["shader"];
  c.width = j["size"][0];
  c.height = j["size"][1];
  c.spp = j["spp"];
  c.replicates = j["replicates"];
  if (c.spp % c.replicates != 0)
    base::fail_in(c.file, "spp", "a multiple of replicates, " + j["replicates"].dump(), j["spp"].dump());
  c.seed = j["seed"];
  c.depth = j["depth"];
  c.camera = j.value("camera", 0);
  c.options = j.value("options", json::object());
  const json margins = j.value("margins", json::object());
  c.margin_image = margins.value("image", c.margin_image);
  c.margin_tile = margins.value("tile", c.margin_tile);
  if (j.contains("limits")) c.limits = Case::Limits{j["limits"]["flip"], j["limits"]["rmse"]};
  c.timeout_s = j.value("timeout_s", c.timeout_s);
  c.tags = j.value("tags", std::vector<std::string>{});

  std::map<std::string, int> seen;
  const json witnesses = j.value("witnesses", json::array());
  for (size_t i = 0; i < witnesses.size(); ++i) {
    const std::string place = "witnesses[" + std::to_string(i) + "]";
    Witness w = read_witness(c, witnesses[i], place);
    const int repetition = ++seen[w.label];
    // A stored picture has one name, so only closed forms may come more than once.
    if (repetition > 1 && w.kind != WitnessKind::analytic)
      base::fail_in(c.file, place, "each stored picture once", w.label + " twice");
    if (repetition > 1) w.label += "-" + std::to_string(repetition);
    c.witnesses.push_back(w);
  }
  return c;
}

std::vector<std::string> case_names(const Layout& layout) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(layout.root + "/cases"))
    if (entry.path().extension() == ".json" && entry.path().stem() != "schema")
      names.push_back(entry.path().stem().string());
  if (names.empty()) base::fail_in(layout.root + "/cases", "", "at least one case NAME.json", "none");
  std::sort(names.begin(), names.end());
  return names;
}

bool matches(const std::string& pattern, const std::string& name) {
  if (pattern.find_first_of("*?") == std::string::npos) return name.find(pattern) != std::string::npos;
  // The usual glob with one remembered star to come back to.
  size_t p = 0, n = 0, star = std::string::npos, mark = 0;
  while (n < name.size()) {
    if (p < pattern.size() && (pattern[p] == '?' || (pattern[p] != '*' && pattern[p] == name[n]))) {
      ++p, ++n;
    } else if (p < pattern.size() && pattern[p] == '*') {
      star = p++, mark = n;
    } else if (star != std::string::npos) {
      p = star + 1, n = ++mark;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

}  // namespace suite
