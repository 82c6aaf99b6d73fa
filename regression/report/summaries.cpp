#include "report/summaries.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "base/error.h"
#include "image/io.h"
#include "report/results.h"

namespace report {
namespace {

namespace fs = std::filesystem;

std::string xml(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\n':
        out += "&#10;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;  // XML 1.0 has no other control characters
    }
  return out;
}

// One line of a Markdown table cell.
std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c == '\n' ? ' ' : c);
  return out;
}

// GitHub's escapes of a message, and of a property, in which more characters have a meaning.
std::string escaped(const std::string& text, bool property) {
  std::string out;
  for (const char c : text) {
    char code[8];
    const bool special = c == '%' || c == '\r' || c == '\n' || (property && (c == ':' || c == ','));
    std::snprintf(code, sizeof code, special ? "%%%02X" : "%c", static_cast<unsigned char>(c));
    out += code;
  }
  return out;
}

struct Line {
  std::string name, verdict, reason, accept;
  bool passed = false;
  double seconds = 0;
};

// The cases and, after each, its witnesses, in the order of the report.
std::vector<Line> lines_of(const RunResults& results) {
  std::vector<Line> lines;
  for (const CaseResult& c : results.cases) {
    const Json& witnesses = entry(c.json, "witnesses");
    Line own{c.name,
             c.verdict(),
             text(c.json, "reason"),
             text(c.json, "accept"),
             true,
             number(c.json, "seconds").value_or(0)};
    // What the golden says; `passed` of the file includes the witnesses.
    own.passed = own.verdict == "IDENTICAL" || own.verdict == "EQUIVALENT" || own.verdict == "QUIETER";
    lines.push_back(own);
    if (!witnesses.is_array()) continue;
    for (const Json& w : witnesses)
      lines.push_back(
          {c.name + "/" + text(w, "label"), text(w, "verdict"), text(w, "reason"), "", flag(w, "passed"), 0});
  }
  return lines;
}

std::map<std::string, int> counts(const std::vector<Line>& lines, bool witnesses) {
  std::map<std::string, int> out;
  for (const Line& line : lines)
    if ((line.name.find('/') != std::string::npos) == witnesses) ++out[line.verdict];
  return out;
}

std::string listed(const std::map<std::string, int>& counts) {
  std::string out;
  for (const auto& [verdict, count] : counts)
    out += (out.empty() ? "" : ", ") + std::to_string(count) + " " + verdict;
  return out.empty() ? "none" : out;
}

bool was_skipped(const Line& line) { return line.verdict == "SKIPPED"; }

std::vector<std::string> orphans_of(const RunResults& results) {
  std::vector<std::string> out;
  if (const Json& list = entry(results.run, "orphans"); list.is_array())
    for (const Json& o : list)
      if (o.is_string()) out.push_back(o);
  return out;
}

}  // namespace

std::string junit(const std::string& build) {
  const RunResults results = read_results(build);
  const std::vector<Line> lines = lines_of(results);
  const std::vector<std::string> orphans = orphans_of(results);
  int failures = static_cast<int>(orphans.size()), errors = 0, skipped = 0;
  std::ostringstream tests;
  for (const Line& line : lines) {
    const bool witness = line.name.find('/') != std::string::npos;
    tests << "  <testcase classname=\"assay." << (witness ? "witness" : "golden") << "\" name=\""
          << xml(line.name) << "\" time=\"" << line.seconds << "\"";
    const std::string body =
        xml(line.verdict + ": " + line.reason +
            (line.accept.empty() ? "" : "\nif the new picture is right: " + line.accept));
    if (was_skipped(line)) {
      tests << "><skipped message=\"" << xml(line.reason) << "\"/></testcase>\n", ++skipped;
    } else if (line.passed) {
      tests << "><system-out>" << body << "</system-out></testcase>\n";
    } else {
      const bool error = line.verdict == "ERROR";
      (error ? errors : failures) += 1;
      const char* tag = error ? "error" : "failure";
      tests << "><" << tag << " type=\"" << xml(line.verdict) << "\" message=\"" << xml(line.reason) << "\">"
            << body << "</" << tag << "></testcase>\n";
    }
  }
  for (const std::string& orphan : orphans)
    tests << "  <testcase classname=\"assay.suite\" name=\"no orphans\"><failure type=\"BROKEN\" message=\""
          << xml(orphan) << "\"/></testcase>\n";
  std::ostringstream out;
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"assay\" tests=\""
      << lines.size() + orphans.size() << "\" failures=\"" << failures << "\" errors=\"" << errors
      << "\" skipped=\"" << skipped << "\" time=\"" << number(results.run, "seconds").value_or(0)
      << "\" timestamp=\"" << xml(text(results.run, "finished")) << "\">\n"
      << tests.str() << "</testsuite>\n";
  return out.str();
}

std::string markdown(const std::string& build) {
  const RunResults results = read_results(build);
  const std::vector<Line> lines = lines_of(results);
  const std::vector<std::string> orphans = orphans_of(results);
  const auto failed =
      std::count_if(lines.begin(), lines.end(), [](const Line& l) { return !l.passed && !was_skipped(l); });
  std::ostringstream out;
  out << "## Assay: "
      << (failed + static_cast<long>(orphans.size()) == 0
              ? "nothing changed"
              : std::to_string(failed + static_cast<long>(orphans.size())) + " to look at")
      << "\n\n"
      << results.cases.size() << " cases: " << listed(counts(lines, false))
      << ". Witnesses: " << listed(counts(lines, true)) << ".\n";
  for (const std::string& orphan : orphans) out << "\n- " << cell(orphan);
  if (failed == 0) return out.str();
  out << "\n| case | verdict | why |\n|---|---|---|\n";
  for (const Line& line : lines)
    if (!line.passed && !was_skipped(line))
      out << "| " << cell(line.name) << " | " << line.verdict << " | " << cell(line.reason) << " |\n";
  bool first = true;
  for (const Line& line : lines) {
    if (line.accept.empty() || line.passed) continue;
    if (first) out << "\nIf the new pictures are right, after looking at them:\n\n```sh\n";
    first = false;
    out << line.accept << "\n";
  }
  if (!first) out << "```\n";
  return out.str();
}

std::string annotations(const std::string& build) {
  const RunResults results = read_results(build);
  const std::string suite = text(results.run, "suite");
  std::ostringstream out;
  for (const Line& line : lines_of(results)) {
    if (line.passed || was_skipped(line)) continue;
    const std::string name = line.name.substr(0, line.name.find('/'));
    // run.json's path to the suite is relative to the build folder, GitHub's to the checkout.
    const fs::path file = (fs::absolute(build) / suite / "cases" / (name + ".json"))
                              .lexically_normal()
                              .lexically_relative(fs::current_path());
    out << "::error file=" << escaped(file.string(), true)
        << ",title=" << escaped(line.verdict + " " + line.name, true)
        << "::" << escaped(line.reason.empty() ? line.verdict : line.reason, false) << "\n";
  }
  for (const std::string& orphan : orphans_of(results))
    out << "::error title=orphan::" << escaped(orphan, false) << "\n";
  return out.str();
}

void merge(const std::string& build, const std::string& suite_root, const std::vector<std::string>& shards) {
  // Look at all of them before anything is written.
  struct Shard {
    fs::path folder;
    RunResults results;
  };
  std::vector<Shard> all;
  std::map<std::string, std::string> judged_in;
  for (const std::string& folder : shards) {
    if (fs::exists(build) && fs::equivalent(folder, build))
      base::fail_in("--merge", folder, "another folder than --build", "the same");
    all.push_back({folder, read_results(folder)});
    if (!all.back().results.run.contains("cases"))
      base::fail_in(folder + "/run.json", "", "the end of a run", "none");
    for (const CaseResult& c : all.back().results.cases)
      if (const auto [known, fresh] = judged_in.emplace(c.name, folder); !fresh)
        base::fail_in(folder, c.name, "each case in one shard", "it also in " + known->second);
  }
  const fs::path target = fs::absolute(build).lexically_normal();
  const std::string suite = fs::absolute(suite_root).lexically_normal().lexically_relative(target).string();

  Json run = all.empty() ? Json::object() : all.front().results.run;
  run["cases"] = Json::array(), run["orphans"] = Json::array();
  run["suite"] = suite, run["exit_code"] = 0, run["seconds"] = 0.;
  std::set<std::string> orphans;
  for (const char* folder : {"results", "renders", "pending"}) fs::create_directories(target / folder);
  for (const Shard& shard : all) {
    // A path into the suite, or into reference/ beside it, changes its way there; all others stay.
    const std::string house = fs::path(text(shard.results.run, "suite")).parent_path().string();
    const std::string here = fs::path(suite).parent_path().string();
    const auto redirect = [&](auto& self, Json& value) -> void {
      if (value.is_string()) {
        const std::string path = value;
        if (!house.empty() && path.starts_with(house + "/")) value = here + path.substr(house.size());
      } else if (value.is_object() || value.is_array()) {
        for (Json& part : value) self(self, part);
      }
    };
    for (const char* folder : {"results", "renders", "pending"})
      if (fs::is_directory(shard.folder / folder))
        for (const auto& file : fs::directory_iterator(shard.folder / folder))
          if (file.path().extension() == ".exr")
            fs::copy_file(file.path(), target / folder / file.path().filename(),
                          fs::copy_options::overwrite_existing);
    for (CaseResult c : shard.results.cases) {
      if (Json* golden = c.json.contains("golden") ? &c.json["golden"] : nullptr;
          golden && golden->contains("images"))
        redirect(redirect, (*golden)["images"]);
      if (c.json.contains("witnesses"))
        for (Json& w : c.json["witnesses"])
          if (w.is_object() && w.contains("images")) redirect(redirect, w["images"]);
      const std::string text = c.json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
      image::write_file((target / "results" / (c.name + ".json")).string(), text.data(), text.size());
      run["cases"].push_back(c.name);
    }
    run["seconds"] = run["seconds"].get<double>() + number(shard.results.run, "seconds").value_or(0);
    run["exit_code"] =
        std::max(run["exit_code"].get<double>(), number(shard.results.run, "exit_code").value_or(2));
    for (const std::string& orphan : orphans_of(shard.results)) orphans.insert(orphan);
  }
  run["exit_code"] = static_cast<int>(run["exit_code"].get<double>());
  std::vector<std::string> names = run["cases"];
  std::sort(names.begin(), names.end());
  run["cases"] = names;
  run["orphans"] = orphans;
  const std::string text = run.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  image::write_file((target / "run.json").string(), text.data(), text.size());
}

}  // namespace report
