#include "image/floats.h"

#include <charconv>

namespace image {

std::string floats_to_text(const std::vector<float>& floats) {
  std::string text = "float[" + std::to_string(floats.size()) + "]";
  char number[32];
  for (const float f : floats) {
    const auto end =
        std::to_chars(number, number + sizeof number, f);  // the shortest text that reads back the same
    text += ' ';
    text.append(number, end.ptr);
  }
  return text;
}

std::optional<std::vector<float>> floats_from_text(const std::string& text) {
  const char* at = text.data();
  const char* const end = at + text.size();
  if (text.rfind("float[", 0) != 0) return std::nullopt;
  std::size_t count = 0;
  const auto head = std::from_chars(at + 6, end, count);
  if (head.ec != std::errc() || head.ptr == end || *head.ptr != ']') return std::nullopt;
  at = head.ptr + 1;
  std::vector<float> floats;
  while (at != end && *at == ' ') {
    float f = 0;
    const auto number = std::from_chars(at + 1, end, f);
    if (number.ec != std::errc()) return std::nullopt;
    floats.push_back(f);
    at = number.ptr;
  }
  if (at != end || floats.size() != count) return std::nullopt;
  return floats;
}

}  // namespace image
