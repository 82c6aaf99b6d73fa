// Checks JSON values against a JSON Schema: the part of draft 2020-12 that regression/cases/schema.json uses.
//
// The schema file is compiled into the judge and *is* the check, so the two cannot drift apart. Understood:
// type, properties, required, additionalProperties (false or a schema), propertyNames, items, minItems,
// maxItems, minimum, maximum, exclusiveMinimum, minLength, pattern, enum, const, not (of an enum), $ref into
// $defs, and oneOf whose branches are told apart by a const property. Any other keyword that would constrain
// is a programming error.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace suite {

// The text of regression/cases/schema.json as it was when the judge was built, parsed.
const nlohmann::json& case_schema();

// Parses a file. Throws base::Error naming file, line and column; a repeated key is an error too.
nlohmann::json read_json(const std::string& file);

// Throws base::Error "file: json.path: wanted W, found F" for the first violation.
void check_schema(const std::string& file, const nlohmann::json& value, const nlohmann::json& schema);

// The word of `words` closest to `word` by edit distance; empty if none is near (more than a third of it
// wrong).
std::string near_miss(const std::string& word, const std::vector<std::string>& words);

}  // namespace suite
