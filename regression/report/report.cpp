#include "report/report.h"

#include <map>

#include "image/io.h"
#include "report/assets.h"
#include "report/card.h"
#include "report/html.h"
#include "report/pixels.h"
#include "report/results.h"

namespace report {
namespace {

// Nothing but what is in the file itself: the browser enforces it.
constexpr const char* policy =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

// The first provenance entry of that name any case has.
std::string any_provenance(const RunResults& results, const std::string& key) {
  for (const CaseResult& c : results.cases)
    if (std::string found = text(entry(entry(c.json, "provenance"), "render"), key); !found.empty())
      return found;
  return "";
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
  std::string out = std::string("<header class=\"top ") + (passed ? "good" : "bad") + "\"><h1>Assay <b>" +
                    (passed ? "passed" : "failed") + "</b></h1>\n<p class=\"lead\">" +
                    (failing ? std::to_string(failing) + " of " + std::to_string(count) + " cases fail"
                             : (count == 1 ? "1 case passes" : std::to_string(count) + " cases pass")) +
                    (pending ? ", " + std::to_string(pending) + " pending" : "") + "</p>\n<dl>";
  const auto fact = [&](const char* name, const std::string& value) {
    if (!value.empty()) out += "<div><dt>" + std::string(name) + "<dd>" + escape(value) + "</div>";
  };
  fact("finished", text(results.run, "finished"));
  if (const auto seconds = number(results.run, "seconds")) fact("took", number_text(seconds) + " s");
  fact("commit", any_provenance(results, "commit"));
  fact("renderer", text(results.run, "renderer"));
  fact("version", any_provenance(results, "version"));
  fact("instructions", any_provenance(results, "isa"));
  if (!results.run.contains("finished")) fact("note", "the run did not finish: this is what it left");
  out += "</dl></header>\n";
  if (orphans.is_array())
    for (const Json& orphan : orphans)
      if (orphan.is_string())
        out += "<p class=\"reason fails\">" + badge("BROKEN", false) + " " +
               escape(orphan.get<std::string>()) + "</p>\n";
  return out;
}

// One button per word that some case has, with how many.
std::string filters_html(const RunResults& results) {
  std::map<std::string, std::size_t> counts;
  for (const CaseResult& c : results.cases)
    for (const std::string& word : filter_words(c)) ++counts[word];
  const auto button = [](const std::string& word, const std::string& label, std::size_t count) {
    return "<button type=\"button\"" + attribute("data-word", word) + " aria-pressed=\"false\">" +
           escape(label) + " <b>" + std::to_string(count) + "</b></button>";
  };
  std::string out =
      "<nav class=\"filters\"><input type=\"search\" id=\"search\" placeholder=\"Search cases  ( / )\" "
      "aria-label=\"Search cases\">\n<span class=\"group\">" +
      button("", "all", results.cases.size());
  for (const char* word : {"failing", "pending"})
    if (counts.count(word)) out += button(word, word, counts[word]);
  for (const char* house : {"golden:", "witness:"}) {
    out += house == std::string("golden:") ? "</span><span class=\"group\">"
                                           : "</span><span class=\"group\"><i>witnesses</i>";
    for (const auto& [word, count] : counts)
      if (word.rfind(house, 0) == 0) out += button(word, word.substr(word.find(':') + 1), count);
  }
  return out +
         "</span><label class=\"exposure\">exposure <input type=\"range\" min=\"-8\" max=\"8\" step=\"0.25\" "
         "value=\"0\"><output>+0</output></label></nav>\n";
}

}  // namespace

std::string page(const std::string& build) {
  const RunResults results = read_results(build);
  Floats floats;
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\"" +
      attribute("content", policy) +
      ">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>Assay report</title>\n<style>\n" +
      style_text + "</style></head>\n<body>\n" + header_html(results) + filters_html(results) + "<main>\n";
  for (const CaseResult& c : results.cases) out += card_html(c, build, floats);
  out += "</main>\n<p id=\"nothing\" hidden>No case fits.</p>\n";
  out += viewer_text;
  const std::string script = std::string("<script>\n") + script_text + "</script>\n</body></html>\n";
  const std::size_t so_far = out.size() + script.size() + 100;
  out += "<script type=\"application/json\" id=\"floats\">" +
         floats.json(so_far < most_bytes ? most_bytes - so_far : 0) + "</script>\n";
  return out + script;
}

std::string write(const std::string& build, const std::string& file) {
  std::string path = file.empty() ? build + "/report/index.html" : file;
  const std::string html = page(build);
  image::write_file(path, html.data(), html.size());
  return path;
}

}  // namespace report
