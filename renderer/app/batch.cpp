// jobs.json is {"jobs": [{"scene": "a.glb", "out": "a.exr", "spp": 64, ...}, ...]}, see docs/formats.md.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "app/job.h"
#include "base/error.h"

namespace app {

namespace fs = std::filesystem;
using nlohmann::json;

json read_jobs(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::error_code ignored;
  if (fs::is_directory(file, ignored))
    base::fail("--batch: ", file, ": wanted a file of jobs, found a folder");
  if (!stream) base::fail("--batch: ", file, ": cannot read: ", std::strerror(errno));

  // JSON's own reader lets the last of two equal keys win.
  std::vector<std::set<json>> keys;
  int job = 0;
  const auto refuse_twins = [&](int, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_start && keys.size() == 2) ++job;
    if (event == json::parse_event_t::object_end) keys.pop_back();
    if (event == json::parse_event_t::key && !keys.back().insert(parsed).second)
      base::fail(file, ": ", keys.size() > 1 ? "job " + std::to_string(job) + ": " : "",
                 "wanted each key once, found ", parsed, " twice");
    return true;
  };
  json root;
  try {
    root = json::parse(stream, refuse_twins);
  } catch (const json::exception& error) {
    base::fail(file, ": wanted JSON, found: ", error.what());
  }
  if (!root.is_object() || !root.contains("jobs") || !root["jobs"].is_array() || root["jobs"].empty())
    base::fail(file, ": wanted {\"jobs\": [...]} with one job or more, found none");
  for (const auto& [key, value] : root.items())
    if (key != "jobs") base::fail(file, ": wanted \"jobs\" and nothing else, found \"", key, "\"");

  std::map<fs::path, size_t> pictures;
  for (size_t i = 0; i < root["jobs"].size(); ++i) {
    const json& job_i = root["jobs"][i];
    if (!job_i.is_object() || !job_i.contains("out") || !job_i["out"].is_string()) continue;
    const std::string out = job_i["out"];
    const auto [first, is_new] = pictures.emplace(fs::weakly_canonical(fs::absolute(out)), i + 1);
    if (!is_new)
      base::fail(file, ": job ", i + 1, ": out: wanted a picture of its own, found that of job ",
                 first->second, ", '", out, "'");
  }
  return root["jobs"];
}

}  // namespace app
