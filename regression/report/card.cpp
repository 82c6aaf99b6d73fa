#include "report/card.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "report/gallery.h"
#include "report/html.h"

namespace report {
namespace {

bool golden_passed(const std::string& verdict) {
  return verdict == "IDENTICAL" || verdict == "EQUIVALENT" || verdict == "QUIETER";
}

bool is_analytic(const Json& witness) { return text(witness, "kind") == "analytic"; }

std::string measure_title(const std::string& name) {
  return name == "flip" ? "FLIP" : name == "rmse" ? "RMSE" : name == "relative mse" ? "relative MSE" : name;
}

// What a number of the results is in: shares of the image's mean as percent, everything else as it is.
std::string measure_value(const std::string& name, const std::optional<double>& value) {
  return name.rfind("bias", 0) == 0 ? percent_text(value) : number_text(value);
}

std::string measures_html(const Json& measures) {
  if (!measures.is_array() || measures.empty()) return "";
  std::string out =
      "<table class=\"measures\"><thead><tr><th>measure<th>value<th>limit<th></tr></thead><tbody>\n";
  for (const Json& m : measures) {
    const bool limited = m.is_object() && m.contains("limit"), ok = flag(m, "ok");
    const std::string name = text(m, "name");
    const auto value = number(m, "value"), limit = number(m, "limit");
    out += std::string("<tr") + (ok ? "" : " class=\"fails\"") + "><td>" + escape(measure_title(name)) +
           "<td>" + measure_value(name, value) + "<td>" + (limited ? measure_value(name, limit) : "–") +
           "<td>";
    if (limited && value && limit && *limit > 0) {
      char width[32];
      std::snprintf(width, sizeof width, "%.1f", std::clamp(100 * *value / *limit, 0., 100.));
      out += "<span class=\"meter\"><i style=\"width:" + std::string(width) + "%\"></i></span>";
    }
    out += ok ? "" : " <b>✗</b>";
    out += "</tr>\n";
  }
  return out + "</tbody></table>\n";
}

std::string coordinate(double v) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.2f", v);
  return buffer;
}

// Intervals of the bias of each channel, drawn against the margin.
std::string bias_html(const Json& channels, double margin) {
  static const char* const names[] = {"red", "green", "blue", "luminance"};
  if (!channels.is_object()) return "";
  double widest = margin;
  for (const char* name : names)
    for (const char* end : {"low", "high"})
      widest = std::max(widest, std::fabs(number(entry(channels, name), end).value_or(0)));
  const double range = 1.15 * std::min(widest, 6 * margin);
  if (!(range > 0)) return "";
  std::string out =
      "<table class=\"bias\"><thead><tr><th>bias<th>ours − reference, 99 %<th class=\"plot\">margin ±" +
      percent_text(margin) + "<th>p<th>detectable</tr></thead><tbody>\n";
  for (const char* name : names) {
    const Json& d = entry(channels, name);
    if (!d.is_object()) continue;
    const auto low = number(d, "low"), high = number(d, "high");
    out += std::string("<tr") + (flag(d, "significant") ? " class=\"fails\"" : "") + "><td>" + name + "<td>" +
           signed_percent_text(number(d, "relative"));
    if (low && high)
      out += " <small>[" + signed_percent_text(low) + ", " + signed_percent_text(high) + "]</small>";
    out += "<td class=\"plot\">" + interval_svg(d, margin, range, name) + "<td>" +
           number_text(number(d, "p")) + "<td>" + percent_text(number(d, "detectable")) + "</tr>\n";
  }
  return out + "</tbody></table>\n";
}

std::string reason_html(const std::string& reason, bool passed) {
  if (reason.empty()) return "";
  return std::string("<p class=\"reason") + (passed ? "" : " fails") + "\">" + escape(reason) + "</p>\n";
}

std::string comparison_html(const std::string& title, const std::string& badge_html,
                            const std::string& inner_html, bool expected = false) {
  return std::string("<section class=\"comparison") + (expected ? " expected" : "") + "\"><h3>" +
         escape(title) + " " + badge_html + "</h3>\n" + inner_html + "</section>\n";
}

// Pictures, and the numbers beside them where there is room.
std::string body_html(const std::string& figures, const std::string& numbers) {
  if (figures.empty() && numbers.empty()) return "";
  return "<div class=\"body\">\n" +
         (figures.empty() ? "" : "<div class=\"figures\">\n" + figures + "</div>\n") +
         (numbers.empty() ? "" : "<div class=\"numbers\">\n" + numbers + "</div>\n") + "</div>\n";
}

// The worst pixels that no noise explains, each a button that shows it.
std::string wrong_pixels_html(const Json& pixels) {
  if (!pixels.is_array() || pixels.empty()) return "";
  constexpr std::size_t most = 8;
  std::string out = "<p class=\"wrong\">Wrong pixels: ";
  for (std::size_t i = 0; i < std::min(most, pixels.size()); ++i) {
    const auto x = number(pixels[i], "x"), y = number(pixels[i], "y"), sigmas = number(pixels[i], "sigmas");
    if (!x || !y) continue;
    const std::string place = number_text(x, 6) + ", " + number_text(y, 6);
    out += "<button type=\"button\" class=\"pixel\"" + attribute("data-x", number_text(x, 6)) +
           attribute("data-y", number_text(y, 6)) + attribute("aria-label", "show pixel " + place) + ">" +
           place + "</button> " + number_text(number(pixels[i], "test")) + " instead of " +
           number_text(number(pixels[i], "reference")) +
           (sigmas ? ", " + number_text(sigmas) + " σ" : ", where nothing varies") + " · ";
  }
  out.resize(out.size() - std::string(" · ").size());
  if (pixels.size() > most) out += " · and " + std::to_string(pixels.size() - most) + " more";
  return out + "</p>\n";
}

std::string golden_html(const CaseResult& result, Gallery& gallery) {
  const Json& golden = entry(result.json, "golden");
  const Json& test = entry(golden, entry(golden, "welch").is_object() ? "welch" : "paired");
  const bool fine = golden_passed(result.verdict());
  std::string numbers = measures_html(entry(golden, "measures"));
  numbers += bias_html(entry(test, "image"), number(entry(result.json, "margins"), "image").value_or(.005));
  std::string facts;
  if (const auto seen = number(golden, "detectable"); seen && *seen > 0)
    facts += "smallest bias of the mean it would find 99 times in 100: " + percent_text(seen);
  if (const auto looks = number(golden, "looks"); looks && *looks > 0)
    facts += (facts.empty() ? "" : " · ") + std::string("fresh seeds judged: ") + number_text(looks);
  if (const Json& noise = entry(golden, "noise"); noise.is_object())
    facts += (facts.empty() ? "" : " · ") + std::string("noise variance × ") +
             number_text(number(noise, "ratio")) + " [" + number_text(number(noise, "low")) + ", " +
             number_text(number(noise, "high")) + "]";
  return comparison_html("Golden", badge(result.verdict(), fine),
                         reason_html(text(result.json, "reason"), fine) +
                             wrong_pixels_html(entry(golden, "wrong_pixels")) +
                             body_html(gallery.golden_html(), numbers) +
                             (facts.empty() ? "" : "<p class=\"facts\">" + escape(facts) + "</p>\n"));
}

std::string witness_html(const Json& witness, const Gallery::Witness& pictures) {
  std::string said = text(witness, "said_by");
  if (const auto margin = number(witness, "margin"))
    said += (said.empty() ? "margin " : " · margin ") + percent_text(margin);
  const std::string because = text(witness, "because");
  if (!because.empty() && text(witness, "reason").find(because) == std::string::npos)
    said += " · expected to differ: " + because;
  return comparison_html(
      kind_name(witness), badge(text(witness, "verdict"), flag(witness, "passed"), "", as_expected(witness)),
      reason_html(text(witness, "reason"), flag(witness, "passed")) +
          (pictures.parts ? parts_html(*pictures.parts) : "") +
          body_html(pictures.html,
                    measures_html(entry(witness, "measures")) +
                        bias_html(entry(witness, "image"), number(witness, "margin").value_or(.005))) +
          (said.empty() ? "" : "<p class=\"facts\">" + escape(said) + "</p>\n"),
      as_expected(witness));
}

// Closed forms come in numbers: one line each, the details of those that agree folded away.
std::string analytic_html(const std::vector<Json>& entries) {
  if (entries.empty()) return "";
  std::string out;
  std::size_t passed = 0;
  for (const Json& w : entries) {
    const bool fine = flag(w, "passed");
    passed += fine;
    out += std::string("<details") + (fine ? "" : " open") + "><summary>" +
           badge(text(w, "verdict"), fine, "", as_expected(w)) + " " + escape(text(w, "label")) + " <small>" +
           escape(text(w, "said_by")) + "</small></summary>\n" + reason_html(text(w, "reason"), fine) +
           "<div class=\"numbers\">\n" + measures_html(entry(w, "measures")) +
           bias_html(entry(w, "image"), number(w, "margin").value_or(.005)) + "</div></details>\n";
  }
  const std::string count = std::to_string(passed) + " of " + std::to_string(entries.size());
  return comparison_html(
      "Closed forms", badge(passed == entries.size() ? "AGREES" : "DIFFERS", passed == entries.size(), count),
      out);
}

// A value as JSON writes it, a string without quotes.
std::string plain(const Json& value) {
  if (value.is_null()) return "–";
  return value.is_string() ? value.get<std::string>()
                           : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// What the case says, then the headers of render and golden side by side, with what differs standing out.
std::string provenance_html(const Json& json) {
  std::string said, made;
  for (const char* group : {"options", "limits", "margins", "hashes"})
    if (const Json& object = entry(json, group); object.is_object())
      for (const auto& [key, value] : object.items())
        said +=
            "<tr><td>" + std::string(group) + " " + escape(key) + "<td>" + escape(plain(value)) + "</tr>\n";
  if (const Json& images = entry(entry(json, "golden"), "images"); images.is_object())
    for (const auto& [key, value] : images.items())
      said += "<tr><td>file " + escape(key) + "<td>" + escape(plain(value)) + "</tr>\n";
  const Json& render = entry(entry(json, "provenance"), "render");
  const Json& golden = entry(entry(json, "provenance"), "golden");
  std::set<std::string> keys;
  for (const Json* header : {&render, &golden})
    if (header->is_object())
      for (const auto& item : header->items()) keys.insert(item.key());
  for (const std::string& key : keys) {
    const Json &ours = entry(render, key), &theirs = entry(golden, key);
    const bool differs = !ours.is_null() && !theirs.is_null() && ours != theirs;
    made += std::string("<tr") + (differs ? " class=\"differs\"" : "") + "><td>" + escape(key) + "<td>" +
            escape(plain(ours)) + "<td>" + escape(plain(theirs)) + "</tr>\n";
  }
  if (said.empty() && made.empty()) return "";
  if (!made.empty()) made = "<table>\n<tr><th><th>render<th>golden</tr>\n" + made + "</table>\n";
  if (!said.empty()) said = "<table>\n" + said + "</table>\n";
  return "<details class=\"provenance\"><summary>Provenance</summary><div class=\"scroll\">" + said + made +
         "</div></details>\n";
}

// "cornell.glb · path · 64 × 64 · 64 samples in 8 replicates · depth 8 · seed 1 · 0.41 s"
std::string settings_text(const Json& json) {
  std::string out;
  const auto add = [&](const std::string& part) { out += (out.empty() || part.empty() ? "" : " · ") + part; };
  add(text(json, "scene"));
  add(text(json, "shader"));
  const Json& size = entry(json, "size");
  if (size.is_array() && size.size() == 2) add(size[0].dump() + " × " + size[1].dump());
  if (const auto spp = number(json, "spp")) {
    add(number_text(spp) + " samples");
    if (const auto replicates = number(json, "replicates"))
      out += " in " + number_text(replicates) + " replicates";
  }
  for (const char* key : {"depth", "seed"})
    if (const Json& value = entry(json, key); value.is_number()) add(std::string(key) + " " + value.dump());
  if (const auto seconds = number(json, "seconds")) add(number_text(seconds) + " s");
  return out;
}

}  // namespace

bool as_expected(const Json& witness) {
  return text(witness, "expect") == "differs" && flag(witness, "passed");
}

std::string kind_name(const Json& witness) {
  const std::string kind = text(witness, "kind"), quantity = text(witness, "quantity");
  return (kind == "blender"  ? "Blender"
          : kind == "povray" ? "POV-Ray"
                             : text(witness, "label")) +
         (quantity.empty() ? "" : " " + quantity);
}

std::string command_html(const std::string& before, const std::string& command) {
  return "<div class=\"accept\"><span>" + escape(before) + "</span><code>" + escape(command) +
         "</code><button type=\"button\" class=\"copy\" aria-live=\"polite\">Copy</button></div>\n";
}

std::string interval_svg(const Json& difference, double margin, double range, const std::string& css_class) {
  const auto relative = number(difference, "relative"), low = number(difference, "low"),
             high = number(difference, "high");
  const auto x = [&](double fraction) { return 100 + 100 * std::clamp(fraction / range, -1., 1.); };
  std::string out = "<svg viewBox=\"0 0 200 14\" aria-hidden=\"true\"" + attribute("class", css_class) +
                    "><rect x=\"" + coordinate(x(-margin)) + "\" y=\"0\" width=\"" +
                    coordinate(x(margin) - x(-margin)) +
                    "\" height=\"14\" class=\"margin\"/><path d=\"M100 0V14\" class=\"zero\"/>";
  if (low && high)
    out += "<path d=\"M" + coordinate(x(*low)) + " 7H" + coordinate(x(*high)) + "\" class=\"interval\"/>";
  if (relative) {
    // Beyond the plot's end an arrow head stands for the point.
    if (std::fabs(*relative) > range)
      out += *relative > 0 ? "<path d=\"M192 2l7 5-7 5\" class=\"beyond\"/>"
                           : "<path d=\"M8 2L1 7l7 5\" class=\"beyond\"/>";
    else
      out += "<circle cx=\"" + coordinate(x(*relative)) + "\" cy=\"7\" r=\"3\"/>";
  }
  return out + "</svg>";
}

std::string parts_bar(const Parts& p) {
  const double noise = std::max(0., p.noise), bias = std::max(0., p.bias), model = std::max(0., p.model);
  const double sum = noise + bias + model;
  if (!(sum > 0)) return "";
  std::string out = "<span class=\"parts-bar\" aria-hidden=\"true\">";
  for (const auto& [name, share] :
       {std::pair("noise", noise / sum), std::pair("model", model / sum), std::pair("bias", bias / sum)})
    out += "<i class=\"" + std::string(name) + "\" style=\"width:" + coordinate(100 * share) + "%\"></i>";
  return out + "</span>";
}

std::string parts_html(const Parts& p) {
  if (!(p.scale > 0)) return "";
  const auto share = [&](double square) { return percent_text(std::sqrt(std::max(0., square)) / p.scale); };
  // The chance that noise alone exceeds 3.5 standard errors is 0.02 %.
  const double hidden = 3.5 * p.model_error;
  return "<p class=\"parts\">" + parts_bar(p) + " RMS difference " + share(p.total) +
         " of the mean: <b class=\"noise\">noise</b> " + share(p.noise) +
         ", <b class=\"model\">model</b>, differences in places, " +
         (p.model > hidden ? share(p.model) : "none above the " + share(hidden) + " that this noise hides") +
         ", <b class=\"bias\">bias</b> of the image " + share(p.bias) + "</p>\n";
}

std::vector<std::string> filter_words(const CaseResult& result) {
  std::vector<std::string> words = {"verdict:" + result.verdict()};
  words.push_back(result.passed() ? "status:passing" : "status:failing");
  if (!text(result.json, "accept").empty()) words.push_back("status:pending");
  for (const Json& w : entry(result.json, "witnesses")) {
    words.push_back("witness:" + text(w, "verdict") + (as_expected(w) ? " as expected" : ""));
    const std::string kind = text(w, "kind");
    words.push_back("by:" + std::string(kind == "blender"  ? "Blender"
                                        : kind == "povray" ? "POV-Ray"
                                                           : "closed form"));
  }
  for (const Json& tag : entry(result.json, "tags"))
    if (tag.is_string()) words.push_back("tag:" + tag.get<std::string>());
  std::sort(words.begin(), words.end());
  words.erase(std::unique(words.begin(), words.end()), words.end());
  return words;
}

std::string card_html(const CaseResult& result, const std::string& build, Floats& floats,
                      std::vector<WitnessRow>& rows) {
  const Json& json = result.json;
  Gallery gallery(build, result, floats);
  const std::string golden = golden_html(result, gallery);  // first: its pictures come first
  std::string badges = badge(result.verdict(), golden_passed(result.verdict()));
  std::string witnesses;
  std::vector<Json> analytic;
  std::size_t analytic_passed = 0;
  for (const Json& w : entry(json, "witnesses")) {
    if (is_analytic(w)) {
      analytic.push_back(w);
      analytic_passed += flag(w, "passed");
      rows.push_back({result.name, w, std::nullopt});
      continue;
    }
    badges += badge(text(w, "verdict"), flag(w, "passed"), kind_name(w), as_expected(w));
    const Gallery::Witness pictures = gallery.witness(w);
    witnesses += witness_html(w, pictures);
    rows.push_back({result.name, w, pictures.parts});
  }
  if (!analytic.empty()) {
    const bool all = analytic_passed == analytic.size();
    badges +=
        badge(all ? "AGREES" : "DIFFERS", all,
              "closed forms " + std::to_string(analytic_passed) + "/" + std::to_string(analytic.size()));
  }
  std::string words;
  for (const std::string& word : filter_words(result)) words += (words.empty() ? "" : "|") + word;
  std::string tags;
  for (const Json& tag : entry(json, "tags"))
    if (tag.is_string()) tags += " <span class=\"tag\">" + escape(tag.get<std::string>()) + "</span>";

  std::string out = "<details class=\"case\"" + attribute("id", "case-" + result.name) +
                    attribute("data-name", result.name) + attribute("data-words", words) +
                    (result.passed() ? "" : " open") +
                    "><summary><canvas width=\"72\" height=\"72\" aria-hidden=\"true\"></canvas><h2>" +
                    escape(result.name) + "</h2><span class=\"badges\">" + badges +
                    "</span></summary>\n<p class=\"why\">" + escape(text(json, "why")) +
                    "</p>\n<p class=\"facts\">" + escape(settings_text(json)) + tags + "</p>\n";
  if (const std::string accept = text(json, "accept"); !accept.empty())
    out += command_html("If the new picture is right:", accept);
  out += golden + witnesses + analytic_html(analytic) + provenance_html(json);
  return out + "</details>\n";
}

}  // namespace report
