#include "app/text.h"

#include <CLI/StringTools.hpp>
#include <algorithm>
#include <charconv>
#include <numeric>

namespace app {
namespace {

// Levenshtein's distance, one row at a time.
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i + 1);
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string wrapped(std::string text, size_t columns) {
  for (size_t begin = 0; text.size() > begin + columns;) {
    const size_t blank = text.rfind(' ', begin + columns);
    text[blank] = '\n';
    begin = blank + 1;
  }
  return text;
}

std::string quoted(const std::string& text) { return text.empty() ? "nothing" : "'" + text + "'"; }

std::string nearest(const std::string& word, const std::vector<std::string>& candidates,
                    const std::string& before, const std::string& after) {
  std::string best;
  size_t best_distance = 1 + std::max<size_t>(1, (word.size() + 2) / 3);
  for (const std::string& candidate : candidates) {
    const bool begins_so = word.size() >= 3 && candidate.starts_with(word);
    const size_t distance = begins_so ? 1 : edit_distance(word, candidate);
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = before + candidate + after;
  }
  return best;
}

std::string flat(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.is_null() ? "" : value.dump();
  std::vector<std::string> parts;
  for (const nlohmann::json& part : value) parts.push_back(part.is_array() ? part.dump() : flat(part));
  return CLI::detail::join(parts, ",");
}

nlohmann::json decimal(float value) {
  char text[32];
  return nlohmann::json::parse(text, std::to_chars(text, text + sizeof text, value).ptr);
}

}  // namespace app
