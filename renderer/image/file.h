// Writing a file so that it appears whole or not at all.
#pragma once

#include <cstddef>
#include <string>

namespace image {

// Writes a temporary file beside `path` and renames it. Throws base::Error "PATH: cannot write: REASON" and
// leaves nothing behind (an older file of that name stays as it was).
void write_whole(const std::string& path, const void* bytes, std::size_t size);

}  // namespace image
