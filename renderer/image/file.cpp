#include "image/file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "base/error.h"

namespace image {

void write_whole(const std::string& path, const void* bytes, std::size_t size) {
  const std::string temporary = path + ".part" + std::to_string(getpid());
  const auto give_up = [&] {
    const int reason = errno;
    std::remove(temporary.c_str());
    base::fail(path, ": cannot write: ", std::strerror(reason));
  };
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) give_up();
  // A full disk may show only when the buffers are flushed or the file is closed.
  const bool written = std::fwrite(bytes, 1, size, file) == size && std::fflush(file) == 0;
  const int reason = errno;
  const bool closed = std::fclose(file) == 0;
  if (!written) errno = reason;
  if (!written || !closed) give_up();
  if (std::rename(temporary.c_str(), path.c_str()) != 0) give_up();
}

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

}  // namespace image
