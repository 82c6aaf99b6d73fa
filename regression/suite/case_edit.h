// Changes single values in the text of a case file and leaves everything else - order, blanks, line breaks -
// as its author wrote it.
#pragma once

#include <string>

namespace suite {

// `text` with the top-level member `key` set to `value` (JSON text). A member that is not there is added at
// the end, on a line of its own. `text` must be a JSON object.
std::string with_member(const std::string& text, const std::string& key, const std::string& value);

}  // namespace suite
