#include "report/results.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "base/error.h"

namespace report {
namespace {

namespace fs = std::filesystem;

// An object, or null with the reason in `fault`.
Json read_object(const std::string& file, std::string& fault) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    fault = file + ": missing";
    return nullptr;
  }
  Json json = Json::parse(stream, nullptr, false);
  if (json.is_object()) return json;
  fault = file + ": not a JSON object";
  return nullptr;
}

CaseResult read_case_result(const std::string& build, const std::string& name) {
  std::string fault;
  Json json = read_object(build + "/results/" + name + ".json", fault);
  if (json.is_null())
    json = {{"case", name}, {"verdict", "NO RESULT"}, {"passed", false}, {"exit_code", 2}, {"reason", fault}};
  return {name, std::move(json)};
}

// What a reader wants to see first has the smallest number.
std::size_t rank(const CaseResult& result) {
  static const std::vector<std::string> order = {"CHANGED", "NOISIER",   "UNDECIDED",  "BROKEN",
                                                 "ERROR",   "NO RESULT", "EQUIVALENT", "QUIETER"};
  const auto place = std::find(order.begin(), order.end(), result.verdict()) - order.begin();
  return static_cast<std::size_t>(place) + (result.passed() ? 100 : 0);
}

}  // namespace

const Json& entry(const Json& object, const std::string& key) {
  static const Json null;
  if (!object.is_object()) return null;
  const auto found = object.find(key);
  return found == object.end() ? null : *found;
}

std::string text(const Json& object, const std::string& key) {
  const Json& value = entry(object, key);
  return value.is_string() ? value.get<std::string>() : "";
}

std::optional<double> number(const Json& object, const std::string& key) {
  const Json& value = entry(object, key);
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

bool flag(const Json& object, const std::string& key) {
  const Json& value = entry(object, key);
  return value.is_boolean() && value.get<bool>();
}

RunResults read_results(const std::string& build) {
  RunResults results;
  std::string fault;
  results.run = read_object(build + "/run.json", fault);
  std::vector<std::string> names;
  if (results.run.is_object()) {
    for (const Json& name : entry(results.run, "cases"))
      if (name.is_string()) names.push_back(name.get<std::string>());
  } else {
    // A run that was cut short has no run.json: take what it finished.
    results.run = Json::object();
    std::error_code ignored;
    for (const auto& file : fs::directory_iterator(build + "/results", ignored))
      if (file.path().extension() == ".json") names.push_back(file.path().stem().string());
    std::sort(names.begin(), names.end());
    if (names.empty()) base::fail_in(build + "/results", "", "results of assay run", "none");
  }
  for (const std::string& name : names) results.cases.push_back(read_case_result(build, name));
  std::stable_sort(results.cases.begin(), results.cases.end(),
                   [](const CaseResult& a, const CaseResult& b) { return rank(a) < rank(b); });
  return results;
}

}  // namespace report
