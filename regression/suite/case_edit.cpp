#include "suite/case_edit.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace suite {
namespace {

// One past the end of the string that starts at `i`.
std::size_t skip_string(const std::string& text, std::size_t i) {
  for (++i; text[i] != '"'; ++i)
    if (text[i] == '\\') ++i;
  return i + 1;
}

std::size_t skip_blanks(const std::string& text, std::size_t i) {
  return text.find_first_not_of(" \t\r\n", i);
}

// One past the end of the value that starts at `i`.
std::size_t skip_value(const std::string& text, std::size_t i) {
  if (text[i] == '"') return skip_string(text, i);
  if (text[i] != '{' && text[i] != '[') return text.find_first_of(",}] \t\r\n", i);
  for (int depth = 0;;) {
    if (text[i] == '"') {
      i = skip_string(text, i);
      continue;
    }
    if (text[i] == '{' || text[i] == '[') ++depth;
    if (text[i] == '}' || text[i] == ']') --depth;
    ++i;
    if (depth == 0) return i;
  }
}

}  // namespace

std::string with_member(const std::string& text, const std::string& key, const std::string& value) {
  if (!nlohmann::json::accept(text) || text[skip_blanks(text, 0)] != '{')
    throw std::logic_error("with_member: not a JSON object");
  std::size_t i = skip_blanks(text, skip_blanks(text, 0) + 1);
  std::size_t end_of_last = std::string::npos;
  while (text[i] == '"') {
    const std::size_t end_of_key = skip_string(text, i);
    const bool found = nlohmann::json::parse(text.substr(i, end_of_key - i)) == key;
    const std::size_t begin = skip_blanks(text, text.find(':', end_of_key) + 1),
                      end = skip_value(text, begin);
    if (found) return text.substr(0, begin) + value + text.substr(end);
    end_of_last = end;
    i = skip_blanks(text, end);
    if (text[i] == ',') i = skip_blanks(text, i + 1);
  }
  const std::string member = "\n  \"" + key + "\": " + value;
  if (end_of_last == std::string::npos) return text.substr(0, i) + member + "\n" + text.substr(i);
  return text.substr(0, end_of_last) + "," + member + text.substr(end_of_last);
}

}  // namespace suite
