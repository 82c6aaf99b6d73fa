#include "report/html.h"

#include <cmath>
#include <cstdio>

namespace report {

std::string escape(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (const char c : text) {
    switch (c) {
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
      case '\'':
        out += "&#39;";
        break;
      default:
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f)
          out += "\xef\xbf\xbd";
        else
          out += c;
    }
  }
  return out;
}

std::string attribute(const std::string& name, std::string_view value) {
  return " " + name + "=\"" + escape(value) + "\"";
}

std::string number_text(const std::optional<double>& value, int digits) {
  if (!value) return "not finite";
  char text[32];
  const double size = std::fabs(*value);
  // No exponent where the number can be read without.
  if (size >= std::pow(10., digits) && size < 1e7)
    std::snprintf(text, sizeof text, "%.0f", *value);
  else
    std::snprintf(text, sizeof text, "%.*g", digits, *value);
  return text[0] == '-' ? "−" + std::string(text + 1) : text;
}

std::string percent_text(const std::optional<double>& fraction) {
  return fraction ? number_text(100 * *fraction) + " %" : number_text(fraction);
}

std::string signed_percent_text(const std::optional<double>& fraction) {
  return (fraction && *fraction > 0 ? "+" : "") + percent_text(fraction);
}

std::string badge(const std::string& verdict, bool passed, const std::string& before, bool as_expected) {
  // Passed without reserve, passed with a note, failed, or no data to judge.
  const char* kind = "bad";
  if (verdict == "BROKEN" || verdict == "ERROR" || verdict == "NO RESULT") kind = "broken";
  if (verdict == "EQUIVALENT" || verdict == "QUIETER" || verdict == "SKIPPED") kind = "note";
  if (passed && (verdict == "IDENTICAL" || verdict == "AGREES" || as_expected)) kind = "good";
  return std::string("<span class=\"badge ") + kind + "\">" +
         (before.empty() ? "" : "<span>" + escape(before) + "</span> ") + escape(verdict) +
         (as_expected ? " as expected" : "") + "</span>";
}

}  // namespace report
