#include "app/results.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "image/io.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Paths stand relative to the build folder, so that it can be moved together with the checkout.
Json path_json(const RunOptions& options, const std::string& file) {
  if (file.empty()) return nullptr;
  return fs::absolute(file)
      .lexically_normal()
      .lexically_relative(fs::absolute(options.layout.build).lexically_normal())
      .string();
}

// JSON has no infinities; null says "not a number that could be plotted".
Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json header_json(const image::Header& header) {
  Json out = Json::object();
  for (const auto& [key, value] : header)
    std::visit([&, name = key.substr(key.find(':') + 1)](const auto& v) { out[name] = v; }, value);
  return out;
}

Json measures_json(const std::vector<suite::Measure>& measures) {
  Json out = Json::array();
  for (const suite::Measure& m : measures) {
    Json entry = {{"name", m.name}, {"value", number(m.value)}};
    if (m.limit) entry["limit"] = number(*m.limit);
    entry["ok"] = m.ok;
    out.push_back(entry);
  }
  return out;
}

Json difference_json(const metric::Difference& d) {
  return {{"reference", number(d.reference)},
          {"test", number(d.test)},
          {"relative", number(d.relative())},
          {"low", number(d.interval.low)},
          {"high", number(d.interval.high)},
          {"standard_error", number(d.standard_error)},
          {"t", number(d.t)},
          {"p", number(d.p)},
          {"detectable", number(d.detectable)},
          {"significant", d.significant},
          {"within_margin", d.within_margin}};
}

Json channels_json(const metric::Difference* differences) {
  Json out = Json::object();
  static const char* const names[] = {"red", "green", "blue", "luminance"};
  for (int q = 0; q < metric::quantity_count; ++q) out[names[q]] = difference_json(differences[q]);
  return out;
}

Json comparison_json(const metric::Comparison& comparison) {
  Json tiles = Json::array();
  for (const metric::Tile& tile : comparison.tiles) {
    const metric::Difference& d = tile.difference[metric::luminance];
    tiles.push_back({{"x", tile.x},
                     {"y", tile.y},
                     {"width", tile.width},
                     {"height", tile.height},
                     {"t", number(tile.t())},
                     {"relative", number(d.relative())},
                     {"low", number(d.interval.low)},
                     {"high", number(d.interval.high)},
                     {"significant", tile.significant()},
                     {"within_margin", tile.within_margin()}});
  }
  return {{"biased", comparison.biased()},
          {"equivalent", comparison.equivalent()},
          {"smallest_p", number(comparison.smallest_p)},
          {"level", number(comparison.level)},
          {"image", channels_json(comparison.image)},
          {"tile_columns", comparison.tile_columns},
          {"tile_rows", comparison.tile_rows},
          {"tiles", tiles}};
}

Json golden_json(const RunOptions& options, const CaseOutcome& outcome) {
  const suite::GoldenResult& g = outcome.golden;
  Json out = {
      {"measures", measures_json(g.measures)}, {"detectable", number(g.detectable)}, {"looks", g.looks}};
  if (g.paired) out["paired"] = comparison_json(*g.paired);
  if (g.welch) out["welch"] = comparison_json(*g.welch);
  if (g.noise)
    out["noise"] = {{"ratio", number(g.noise->ratio)},
                    {"low", number(g.noise->interval.low)},
                    {"high", number(g.noise->interval.high)},
                    {"p", number(g.noise->p)}};
  if (!g.wrong_pixels.empty()) {
    out["wrong_pixels"] = Json::array();
    for (std::size_t i = 0; i < std::min<std::size_t>(g.wrong_pixels.size(), 100); ++i) {
      const metric::WrongPixel& w = g.wrong_pixels[i];
      out["wrong_pixels"].push_back({{"x", w.x},
                                     {"y", w.y},
                                     {"reference", number(w.reference)},
                                     {"test", number(w.test)},
                                     {"sigmas", number(w.sigmas)}});
    }
  }
  out["images"] = {{"render", path_json(options, outcome.render_file)},
                   {"golden", path_json(options, outcome.golden_file)},
                   {"fresh", path_json(options, outcome.fresh_file)},
                   {"flip", path_json(options, outcome.map_file)},
                   {"pending", path_json(options, outcome.pending_file)}};
  return out;
}

Json witness_json(const RunOptions& options, const WitnessOutcome& w) {
  static const char* const kinds[] = {"blender", "povray", "analytic"};
  Json out = {{"label", w.entry.label},
              {"kind", kinds[static_cast<int>(w.entry.kind)]},
              {"quantity", w.entry.quantity},
              {"verdict", suite::name(w.result.verdict)},
              {"passed", w.result.passed},
              {"expect", w.entry.expect_differs ? "differs" : "agrees"},
              {"because", w.entry.because},
              {"reason", w.result.reason},
              {"said_by", w.result.said_by},
              {"shader", w.entry.shader},
              {"depth", w.entry.depth},
              {"margin", w.entry.margin},
              {"measures", measures_json(w.result.measures)}};
  if (w.result.image.size() == metric::quantity_count) out["image"] = channels_json(w.result.image.data());
  out["images"] = {{"render", path_json(options, w.render_file)},
                   {"witness", path_json(options, w.stored_file)},
                   {"map", path_json(options, w.map_file)},
                   {"map_is", w.result.error_map_is}};
  return out;
}

void write_json(const std::string& file, const Json& json) {
  const std::string text = json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  image::write_file(file, text.data(), text.size());
}

std::string short_number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

}  // namespace

void write_result(const RunOptions& options, const CaseOutcome& outcome) {
  Json out = {{"case", outcome.name},
              {"verdict", suite::name(outcome.golden.verdict)},
              {"passed", outcome.passed(options.require_witnesses)},
              {"exit_code", outcome.exit_code(options.require_witnesses)},
              {"reason", outcome.golden.reason},
              {"seconds", outcome.seconds}};
  if (outcome.a_case) {
    const suite::Case& c = *outcome.a_case;
    out.update({{"why", c.why},
                {"scene", c.scene},
                {"shader", c.shader},
                {"size", {c.width, c.height}},
                {"spp", c.spp},
                {"replicates", c.replicates},
                {"seed", c.seed},
                {"depth", c.depth},
                {"options", Json::parse(c.options.dump())},
                {"tags", c.tags},
                {"margins", {{"image", c.margin_image}, {"tile", c.margin_tile}}}});
    if (c.limits) out["limits"] = {{"flip", c.limits->flip}, {"rmse", c.limits->rmse}};
    out["hashes"] = {{"scene", outcome.hashes.scene},
                     {"picture", outcome.hashes.picture},
                     {"case", outcome.hashes.a_case}};
  }
  out["golden"] = golden_json(options, outcome);
  out["witnesses"] = Json::array();
  for (const WitnessOutcome& w : outcome.witnesses) out["witnesses"].push_back(witness_json(options, w));
  out["provenance"] = {{"render", header_json(outcome.render_header)},
                       {"golden", header_json(outcome.golden_header)}};
  out["accept"] = outcome.accept_command;
  write_json(options.layout.result_file(outcome.name), out);
}

void write_map(const std::string& file, const image::Image& map) {
  image::Render render;
  render.mean = image::Image(map.width, map.height, 3);
  for (std::size_t p = 0; p < map.pixels(); ++p)
    std::fill_n(&render.mean.data[3 * p], 3, map.data[p * static_cast<std::size_t>(map.channels)]);
  image::write_exr(file, render);
}

void write_run(const RunOptions& options, const RunResult& result) {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char date[32];
  std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", &parts);
  Json out = {{"finished", date},
              {"seconds", result.seconds},
              {"exit_code", result.exit_code},
              {"renderer", options.renderer.text()},
              {"suite", path_json(options, options.layout.root)},
              {"require_witnesses", options.require_witnesses},
              {"cases", Json::array()},
              {"orphans", result.orphans}};
  for (const CaseOutcome& c : result.cases) out["cases"].push_back(c.name);
  if (options.quick) out["quick"] = result.quick;
  write_json(options.layout.build + "/run.json", out);
}

std::string line_of(const CaseOutcome& outcome) {
  std::ostringstream line;
  char head[160];
  std::snprintf(head, sizeof head, "%-10s %-32s %6.2f s", suite::name(outcome.golden.verdict),
                outcome.name.c_str(), outcome.seconds);
  line << head;
  for (const suite::Measure& m : outcome.golden.measures)
    if (m.name == "flip" || m.name == "rmse") {
      line << (m.name == "flip" ? "  FLIP " : "  RMSE ") << short_number(m.value);
      if (m.limit) line << "/" << short_number(*m.limit);
    }
  if (outcome.golden.detectable > 0) line << "  sees " << suite::percent(outcome.golden.detectable);
  // Closed forms come in numbers: those that agree are only counted.
  int analytic = 0, analytic_passed = 0;
  for (const WitnessOutcome& w : outcome.witnesses) {
    if (w.entry.kind == suite::WitnessKind::analytic) {
      ++analytic, analytic_passed += w.result.passed;
      continue;
    }
    line << "  " << w.entry.label << " " << suite::name(w.result.verdict);
    if (w.entry.expect_differs && w.result.passed) line << " (as expected)";
  }
  if (analytic) line << "  analytic " << analytic_passed << "/" << analytic << " AGREES";
  if (!outcome.golden.reason.empty()) line << "\n           " << outcome.golden.reason;
  for (const WitnessOutcome& w : outcome.witnesses) {
    if (w.result.reason == outcome.golden.reason) continue;  // no picture at all: said once
    if (!w.result.passed)
      line << "\n           " << w.entry.label << " " << suite::name(w.result.verdict) << ": "
           << w.result.reason;
  }
  return line.str();
}

std::string summary_of(const RunOptions& options, const RunResult& result) {
  std::map<suite::Verdict, int> cases, witnesses;
  int failed = 0, pending = 0, as_expected = 0;
  for (const CaseOutcome& c : result.cases) {
    ++cases[c.golden.verdict];
    failed += !c.passed(options.require_witnesses);
    pending += !c.accept_command.empty();
    for (const WitnessOutcome& w : c.witnesses) {
      if (w.entry.expect_differs && w.result.passed)
        ++as_expected;
      else
        ++witnesses[w.result.verdict];
    }
  }
  std::ostringstream text;
  if (!result.quick.empty())
    text << "\n"
         << result.quick.size() << (result.quick.size() == 1 ? " case has" : " cases have")
         << " their golden's first samples (--quick: no more was looked at)\n";
  const auto counts = [&](const std::map<suite::Verdict, int>& by_verdict) {
    const char* comma = " ";
    for (const auto& [verdict, count] : by_verdict) {
      text << comma << count << " " << suite::name(verdict);
      comma = ", ";
    }
  };
  if (!result.cases.empty()) {
    text << "\n" << result.cases.size() << (result.cases.size() == 1 ? " case:" : " cases:");
    counts(cases);
    text << "\nwitnesses:";
    if (witnesses.empty() && !as_expected) text << " none";
    counts(witnesses);
    if (as_expected) text << (witnesses.empty() ? " " : ", ") << as_expected << " DIFFERS as expected";
    text << "\n";
  }
  for (const std::string& orphan : result.orphans) text << "BROKEN     orphan: " << orphan << "\n";
  if (pending)
    text << pending << " pending: " << options.program
         << " review, then accept CASE… --because \"…\" or reject CASE…\n";
  if (!result.cases.empty()) text << "results: " << options.layout.build << "/results\n";
  text << (result.exit_code == 0 ? "PASSED" : "FAILED") << ": " << failed << " of "
       << result.cases.size() + result.quick.size() << " cases fail, exit code " << result.exit_code << ", "
       << short_number(result.seconds) << " s\n";
  return text.str();
}

}  // namespace app
