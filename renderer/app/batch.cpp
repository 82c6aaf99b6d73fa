// jobs.json is {"jobs": [{"scene": "a.glb", "out": "a.exr", "spp": 64, ...}, ...]}, see docs/formats.md.
#include "app/batch.h"

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "app/console.h"
#include "app/job.h"
#include "base/error.h"

namespace app {
namespace {

using nlohmann::json;

json read_jobs(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) base::fail("--batch: ", file, ": cannot be read");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  json root;
  try {
    root = json::parse(text);
  } catch (const json::exception& error) {
    base::fail(file, ": wanted JSON, found: ", error.what());
  }
  if (!root.is_object() || !root.contains("jobs") || !root.at("jobs").is_array())
    base::fail(file, ": wanted {\"jobs\": [...]}, found no list of jobs");
  for (const auto& [key, value] : root.items())
    if (key != "jobs") base::fail(file, ": wanted \"jobs\" and nothing else, found \"", key, "\"");
  return root.at("jobs");
}

}  // namespace

int run_batch(const Options& options) {
  for (const char* name : {"scene", "out", "info"})
    if (options.has(name))
      base::fail("--batch: wanted no ", name, " on the command line, found '", options.given.at(name), "'");
  const json jobs = read_jobs(options.batch);

  Stage stage;
  bool failed = false;
  for (size_t i = 0; i < jobs.size() && stop_signal() == 0; ++i) {
    Options job = options;
    Result result;
    try {
      apply_job(job, jobs[i]);
      complete(job);
      Console console(job.quiet, job.log);
      result = run(job, stage, console);
    } catch (const std::exception& error) {
      failed = true;
      result.out = job.out;
      result.error = message(error);
      Console(true, "").error(options.batch + ": job " + std::to_string(i + 1) + ": " + result.error);
    }
    if (options.json) print_json(to_json(result));
  }
  return failed ? 2 : stop_signal() != 0 ? 128 + stop_signal() : 0;
}

}  // namespace app
