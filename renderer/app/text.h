// Small dealings with text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace app {

// Breaks at blanks, of which there have to be enough, so that no line is longer than `columns`.
std::string wrapped(std::string text, size_t columns);

// For a message: "'text'", or "nothing".
std::string quoted(const std::string& text);

// ", near 'candidate'": the candidate most like `word`; "" if none is.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates,
                    const std::string& before = ", near '", const std::string& after = "'");

// A string as it is, the parts of a list with commas between, nothing for null, other values as JSON has
// them.
std::string flat(const nlohmann::json& value);

// A float as the shortest decimal that reads back the same, not as the double next to it.
nlohmann::json decimal(float value);

}  // namespace app
