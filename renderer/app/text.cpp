#include "app/text.h"

#include <CLI/StringTools.hpp>
#include <charconv>

#include "base/text.h"

namespace app {
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
    const size_t distance = begins_so ? 1 : base::edit_distance(word, candidate);
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
