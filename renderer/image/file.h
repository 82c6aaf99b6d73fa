// Files and their names.
#pragma once

#include <cstddef>
#include <string>

namespace image {

// Writes a temporary file beside `path` and renames it. Throws base::Error "PATH: cannot write: REASON" and
// leaves nothing behind (an older file of that name stays as it was).
void write_whole(const std::string& path, const void* bytes, std::size_t size);

// ".exr" of "a/B.EXR": the extension in lower case; empty if there is none.
std::string lower_extension(const std::string& path);

}  // namespace image
