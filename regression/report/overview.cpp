#include "report/overview.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "report/html.h"

namespace report {
namespace {

std::string plural(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

// The first provenance entry of that name any case has.
std::string any_provenance(const RunResults& results, const std::string& key) {
  for (const CaseResult& c : results.cases)
    if (std::string found = text(entry(entry(c.json, "provenance"), "render"), key); !found.empty())
      return found;
  return "";
}

// One command for all that is pending, made from those of the cases; empty if they do not look alike.
std::string accept_all(const RunResults& results) {
  std::string names, first, first_name;
  std::size_t pending = 0;
  for (const CaseResult& c : results.cases) {
    const std::string command = text(c.json, "accept");
    if (command.empty()) continue;
    if (first.empty()) first = command, first_name = c.name;
    names += " " + c.name;
    ++pending;
  }
  const std::string marker = " accept " + first_name + " ";
  const std::size_t at = first.find(marker);
  if (pending < 2 || at == std::string::npos) return "";
  return first.substr(0, at) + " accept" + names + first.substr(at + marker.size() - 1);
}

constexpr int bins = 20;

struct PValue {
  double p;
  std::string name;
  bool expected;  // to differ
};

std::string histogram_html(const std::string& title, const std::vector<PValue>& values) {
  if (values.empty()) return "";
  std::vector<std::string> names[bins][2];
  for (const PValue& v : values)
    names[std::clamp(static_cast<int>(v.p * bins), 0, bins - 1)][v.expected].push_back(v.name);
  const double uniform = static_cast<double>(std::count_if(values.begin(), values.end(),
                                                           [](const PValue& v) { return !v.expected; })) /
                         bins;
  double tallest = std::max(1., uniform);
  for (const auto& bin : names)
    tallest = std::max(tallest, static_cast<double>(bin[0].size() + bin[1].size()));
  constexpr double width = 12, height = 56;
  const auto n = [](double v) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.5g", std::max(0., v));
    return std::string(buffer);
  };
  std::string bars;
  for (int b = 0; b < bins; ++b) {
    double top = height;
    for (int expected = 0; expected < 2; ++expected) {
      if (names[b][expected].empty()) continue;
      const double tall = height * static_cast<double>(names[b][expected].size()) / tallest;
      top -= tall;
      std::string list;
      for (const std::string& name : names[b][expected]) list += (list.empty() ? "" : ", ") + name;
      bars += "<rect x=\"" + n(b * width + .5) + "\" y=\"" + n(top) + "\" width=\"" + n(width - 1) +
              "\" height=\"" + n(tall) + "\"" + (expected ? " class=\"expected\"" : "") + "><title>p " +
              n(b / 20.) + " to " + n((b + 1) / 20.) + (expected ? ", expected to differ" : "") + ": " +
              escape(list) + "</title></rect>";
    }
  }
  const auto smallest = std::min_element(values.begin(), values.end(), [](const PValue& a, const PValue& b) {
    return std::pair(a.expected, a.p) < std::pair(b.expected, b.p);
  });
  const std::string line = n(height - height * uniform / tallest);
  return "<figure class=\"histogram\"><figcaption>" + escape(title) + ": " +
         plural(values.size(), "p-value", "p-values") + "</figcaption>\n<svg viewBox=\"0 0 " +
         n(bins * width) + " 72\" role=\"img\"" +
         attribute("aria-label", title + ": histogram of " + plural(values.size(), "p-value", "p-values") +
                                     " from 0 to 1, uniform where only noise is left; smallest " +
                                     number_text(smallest->p) + ", " + smallest->name) +
         "><path d=\"M0 " + n(height) + "H" + n(bins * width) + "\" class=\"axis\"/>" + bars +
         "<path d=\"M0 " + line + "H" + n(bins * width) +
         "\" class=\"uniform\"/><text x=\"0\" y=\"69\">0</text><text x=\"120\" y=\"69\" "
         "text-anchor=\"middle\">p</text><text x=\"240\" y=\"69\" text-anchor=\"end\">1</text></svg>\n"
         "<small>smallest " +
         number_text(smallest->p) + ", " + escape(smallest->name) + (smallest->expected ? ", expected" : "") +
         "</small></figure>\n";
}

}  // namespace

std::string histograms_html(const RunResults& results) {
  std::vector<PValue> goldens, witnesses;
  for (const CaseResult& c : results.cases) {
    const Json& golden = entry(c.json, "golden");
    const Json& test = entry(golden, entry(golden, "welch").is_object() ? "welch" : "paired");
    if (const auto p = number(entry(entry(test, "image"), "luminance"), "p"))
      goldens.push_back({*p, c.name, false});
    for (const Json& w : entry(c.json, "witnesses"))
      if (const auto p = number(entry(entry(w, "image"), "luminance"), "p"))
        witnesses.push_back({*p, c.name + " / " + kind_name(w), text(w, "expect") == "differs"});
  }
  const std::string both = histogram_html("Goldens", goldens) + histogram_html("Witnesses", witnesses);
  return both.empty() ? "" : "<div class=\"histograms\">" + both + "</div>\n";
}

std::string header_html(const RunResults& results) {
  std::size_t failing = 0, pending = 0;
  for (const CaseResult& c : results.cases) {
    failing += !c.passed();
    pending += !text(c.json, "accept").empty();
  }
  const Json& orphans = entry(results.run, "orphans");
  const bool passed = failing == 0 && (!orphans.is_array() || orphans.empty()) && !results.cases.empty();
  const std::size_t count = results.cases.size();
  std::string out = std::string("<header class=\"top ") + (passed ? "good" : "bad") +
                    "\"><div class=\"outcome\"><h1>Assay <b>" + (passed ? "passed" : "failed") +
                    "</b></h1>\n<p class=\"lead\">" +
                    (failing ? std::to_string(failing) + " of " + std::to_string(count) + " cases fail"
                             : plural(count, "case passes", "cases pass")) +
                    (pending ? ", " + std::to_string(pending) + " pending" : "") + "</p>\n<dl>";
  const auto fact = [&](const char* name, const std::string& value) {
    if (!value.empty()) out += "<div><dt>" + std::string(name) + "<dd>" + escape(value) + "</div>";
  };
  fact("finished", text(results.run, "finished"));
  if (const auto seconds = number(results.run, "seconds")) fact("took", number_text(seconds) + " s");
  fact("commit", any_provenance(results, "commit"));
  fact("version", any_provenance(results, "version"));
  fact("instructions", any_provenance(results, "isa"));
  fact("renderer", text(results.run, "renderer"));
  if (!results.run.contains("finished")) fact("note", "the run did not finish: this is what it left");
  out += "</dl></div>\n" + histograms_html(results) + "</header>\n";
  if (const std::string all = accept_all(results); !all.empty())
    out += command_html("If all new pictures are right:", all);
  if (orphans.is_array())
    for (const Json& orphan : orphans)
      if (orphan.is_string())
        out += "<p class=\"reason fails\">" + badge("BROKEN", false) + " " +
               escape(orphan.get<std::string>()) + "</p>\n";
  return out;
}

std::string filters_html(const RunResults& results) {
  std::map<std::string, std::size_t> counts;
  for (const CaseResult& c : results.cases)
    for (const std::string& word : filter_words(c)) ++counts[word];
  std::string out =
      "<nav class=\"filters\" aria-label=\"filters\"><div class=\"row\"><input type=\"search\" id=\"search\" "
      "placeholder=\"Search  ( / )\" aria-label=\"search cases\">\n<span id=\"count\" role=\"status\">" +
      plural(results.cases.size(), "case", "cases") +
      "</span><button type=\"button\" id=\"clear\" disabled>Clear</button><span "
      "class=\"space\"></span><label "
      "class=\"exposure\">exposure <input type=\"range\" min=\"-8\" max=\"8\" step=\"0.25\" "
      "value=\"0\"><output>+0</output>"
      "</label><button type=\"button\" class=\"help\" aria-label=\"keys\" title=\"keys "
      "(?)\">?</button></div>\n"
      "<div class=\"row\">";
  const std::pair<const char*, const char*> groups[] = {{"status", "status"},
                                                        {"verdict", "golden"},
                                                        {"witness", "witnesses"},
                                                        {"by", "compared with"},
                                                        {"tag", "tags"}};
  for (const auto& [group, label] : groups) {
    std::string buttons;
    const std::string prefix = std::string(group) + ":";
    for (const auto& [word, count] : counts)
      if (word.rfind(prefix, 0) == 0)
        buttons += "<button type=\"button\"" + attribute("data-group", group) + attribute("data-word", word) +
                   " aria-pressed=\"false\">" + escape(word.substr(prefix.size())) + " <b>" +
                   std::to_string(count) + "</b></button>";
    if (!buttons.empty())
      out += "<span class=\"group\" role=\"group\"" + attribute("aria-label", label) + "><i>" + label +
             "</i>" + buttons + "</span>\n";
  }
  return out + "</div></nav>\n";
}

std::string witnesses_html(const std::vector<WitnessRow>& rows) {
  if (rows.empty()) return "";
  std::size_t passed = 0;
  std::string body;
  for (const WitnessRow& row : rows) {
    const Json& w = row.witness;
    const bool fine = flag(w, "passed");
    passed += fine;
    const double margin = number(w, "margin").value_or(.005);
    const Json& luminance = entry(entry(w, "image"), "luminance");
    body += "<tr><td><a" + attribute("href", "#case-" + row.case_name) + ">" + escape(row.case_name) +
            "</a><td>" + escape(kind_name(w)) + "<td>" + badge(text(w, "verdict"), fine, "", as_expected(w));
    if (luminance.is_object())
      body += "<td>" + signed_percent_text(number(luminance, "relative")) + "<td class=\"plot\">" +
              interval_svg(luminance, margin, 1.25 * margin, "luminance") + "<td>±" + percent_text(margin);
    else
      body += "<td>–<td><td>";
    const auto share = [&](double square) {
      return percent_text(std::sqrt(std::max(0., square)) / row.parts->scale);
    };
    if (row.parts && row.parts->scale > 0)
      body += "<td>" + parts_bar(*row.parts) + "<td>" + share(row.parts->noise) + "<td>" +
              (row.parts->model > 3.5 * row.parts->model_error
                   ? share(row.parts->model)
                   : "<span class=\"soft\">&lt; " + share(3.5 * row.parts->model_error) + "</span>");
    else
      body += "<td><td>–<td>–";
    // FLIP, or where there is none the measure that comes nearest to its limit.
    std::string flip = "<td>–";
    double nearest = -1;
    for (const Json& m : entry(w, "measures")) {
      const std::string name = text(m, "name");
      const auto value = number(m, "value"), limit = number(m, "limit");
      if (!limit || name.rfind("bias", 0) == 0) continue;
      const double share = name == "flip" ? INFINITY : value.value_or(INFINITY) / *limit;
      if (!(share > nearest)) continue;
      nearest = share;
      flip = "<td" + attribute("title", name) + ">" + number_text(value) + " <small>/ " + number_text(limit) +
             "</small>";
    }
    body += flip + "</tr>\n";
  }
  return "<details class=\"panel\" id=\"witnesses\"><summary><h2>All witnesses</h2> <small>" +
         std::to_string(passed) + " of " + std::to_string(rows.size()) +
         " as their cases want them</small></summary>\n<p class=\"facts\">Bias of the image's luminance, "
         "ours − theirs, "
         "with its 99 % interval against the margin. <b class=\"noise\">Noise</b>: the RMS difference both "
         "variances "
         "explain. <b class=\"model\">Model</b>: RMS of differences in places, beyond noise and <b "
         "class=\"bias\">bias</b>; "
         "“&lt;” where noise hides it. In percent of the witness's mean.</p>\n<div class=\"scroll\"><table "
         "class=\"measures\"><thead><tr><th>case<th>compared with<th>verdict<th>bias<th>99 "
         "%<th>margin<th>difference<th>noise<th>model<th>FLIP or error / limit</tr></thead><tbody>\n" +
         body + "</tbody></table></div></details>\n";
}

}  // namespace report
