// Strict readers of option values: the whole text or nothing. They throw base::Error "wanted W, found F".
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/error.h"

namespace app {

int parse_integer(const std::string& text, int least, int most);
double parse_number(const std::string& text, double least, double most);
std::vector<std::string> split(const std::string& text, char separator);

// Of a file's name: lower case, with the dot.
std::string extension_of(const std::string& file);

// A number as the shortest text that reads back as the same float.
std::string shortest(float value);

// The candidate most like `word`, or "" if none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

// Index of `text` among `names`.
size_t parse_choice(const std::string& text, const std::vector<std::string>& names);

}  // namespace app
