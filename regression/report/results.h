// What `assay run` left in the build folder (docs/formats.md, "Results"), read so that nothing in it can stop
// the report: absent or odd entries are empty, a file that cannot be read is a case of its own that says so.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace report {

using Json = nlohmann::json;

// The entry `key` of an object; null if there is none.
const Json& entry(const Json& object, const std::string& key);

// An entry as text or number: empty if it is absent or of another kind.
std::string text(const Json& object, const std::string& key);
std::optional<double> number(const Json& object, const std::string& key);
bool flag(const Json& object, const std::string& key);

struct CaseResult {
  std::string name;
  Json json;  // an object with at least "verdict" and "reason"
  std::string verdict() const { return text(json, "verdict"); }
  bool passed() const { return flag(json, "passed"); }
};

struct RunResults {
  Json run;                       // run.json, or an empty object
  std::vector<CaseResult> cases;  // failures first, then those with something to tell, then the rest
};

// Throws base::Error only if the folder holds no results at all.
RunResults read_results(const std::string& build);

}  // namespace report
