// The hashes of docs/formats.md: SHA-256, lower-case hexadecimal. They decide what is stale.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "suite/case_file.h"

namespace suite {

// Byte for byte what Python's json.dumps(value, sort_keys=True, separators=(",", ":")) gives: ASCII with \u
// escapes, shortest floats in Python's spelling (1e-05, 1e+16, 0.0001, 2.0). The value may hold no NaN or
// infinity.
std::string canonical_json(const nlohmann::json& value);

// Of the scene file's bytes and those of the files it names (buffers, images, then extras.environment of its
// default scene). Throws base::Error if one of them is missing or lies outside the scene's folder.
std::string scene_hash(const std::string& scene_file);

struct Hashes {
  std::string scene, picture, a_case;
};
Hashes hashes_of(const Layout& layout, const Case& c);

// Of the *.py files of a witness's folder, in the order of their names.
std::string script_hash(const std::string& folder);

}  // namespace suite
