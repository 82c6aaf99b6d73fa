#include "report/report.h"

#include <algorithm>
#include <vector>

#include "image/io.h"
#include "report/assets.h"
#include "report/card.h"
#include "report/html.h"
#include "report/overview.h"
#include "report/pixels.h"
#include "report/results.h"

namespace report {
namespace {

// Nothing but what is in the file itself: the browser enforces it.
constexpr const char* policy =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

// The page if floats may take `floats_bytes`.
std::string page_with(const RunResults& results, const std::string& build, std::size_t floats_bytes,
                      bool all) {
  Floats floats(floats_bytes, all);
  std::vector<WitnessRow> witnesses;
  std::string cases;
  for (const CaseResult& c : results.cases) cases += card_html(c, build, floats, witnesses);
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\"" +
      attribute("content", policy) +
      ">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>Assay report</title>\n<style>\n" +
      style_text + "</style></head>\n<body>\n" + header_html(results) +
      "<noscript><p class=\"reason\">Pictures and filters need JavaScript; verdicts and numbers do not.</p>"
      "</noscript>\n" +
      witnesses_html(witnesses) + filters_html(results) + "<main>\n" + cases +
      "</main>\n<p id=\"nothing\" hidden>No case fits.</p>\n" + viewer_text +
      "<script type=\"application/json\" id=\"floats\">" + floats.json() +
      "</script>\n<script>\n(() => {\n'use strict';\n";
  for (const char* part : script_parts) out += part;
  return out + "})();\n</script>\n</body></html>\n";
}

}  // namespace

std::string page(const std::string& build, std::size_t most) {
  const RunResults results = read_results(build);
  std::string out = page_with(results, build, most, true);
  // Too large: first the pictures that are the same bits everywhere give up their floats, then the last of
  // the rest. What gives them up still costs a PNG, about half of them.
  for (std::size_t floats = most; out.size() > most;) {
    out = page_with(results, build, floats, false);
    if (floats == 0) break;
    if (out.size() > most) floats -= std::min(floats, 3 * (out.size() - most));
  }
  return out;
}

std::string write(const std::string& build, const std::string& file) {
  std::string path = file.empty() ? build + "/report/index.html" : file;
  const std::string html = page(build);
  image::write_file(path, html.data(), html.size());
  return path;
}

}  // namespace report
