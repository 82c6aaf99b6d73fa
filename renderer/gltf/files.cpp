// Which bytes outside the scene file may be read, and reading them: relative paths that stay inside the
// scene's folder after percent-decoding and after following symbolic links, regular files only, nothing from
// the current directory; data: URIs in base64.
#include <openssl/evp.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "gltf/guard.h"

namespace gltf {
namespace fs = std::filesystem;
using base::fail_in;

namespace {

int hex(char c) {
  return c >= '0' && c <= '9'   ? c - '0'
         : c >= 'a' && c <= 'f' ? c - 'a' + 10
         : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                : -1;
}

}  // namespace

std::string resolve(const Document& document, const std::string& place, const std::string& uri) {
  const auto refuse = [&](const std::string& wanted) { fail_in(document.file, place, wanted, shown(uri)); };
  // A scheme or a drive letter: anything with a colon before the first slash.
  if (uri.find(':') < uri.find('/')) refuse("a relative path or a data: URI");
  std::string name;
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      name += uri[i];
      continue;
    }
    const int high = i + 2 < uri.size() ? hex(uri[i + 1]) : -1,
              low = i + 2 < uri.size() ? hex(uri[i + 2]) : -1;
    if (high < 0 || low < 0) refuse("two hexadecimal digits after each %");
    name += static_cast<char>(high * 16 + low);
    i += 2;
  }
  // Judge the decoded name: what the file system will see.
  if (name.empty()) refuse("the name of a file");
  for (const char c : name)
    if (static_cast<unsigned char>(c) < 32 || c == '\\')
      refuse("a path without control characters and backslashes");
  const fs::path relative(name);
  if (relative.is_absolute()) refuse("a relative path");
  for (const fs::path& part : relative)
    if (part == "..") refuse("a path inside the scene's folder");
  // Judge what it leads to.
  std::error_code error;
  const fs::path parent = fs::path(document.file).parent_path();
  const fs::path folder = fs::canonical(parent.empty() ? fs::path(".") : parent, error);
  if (error) refuse("a readable folder around the scene file");
  const fs::path target = fs::canonical(folder / relative, error);
  if (error) refuse("a file in the scene's folder");
  const auto [in_folder, in_target] =
      std::mismatch(folder.begin(), folder.end(), target.begin(), target.end());
  if (in_folder != folder.end()) refuse("a path inside the scene's folder, symbolic links followed");
  if (!fs::is_regular_file(target, error)) refuse("a regular file");
  return target.string();
}

Bytes read_file(const std::string& file, const std::string& path, const std::string& place,
                std::uint64_t limit) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) fail_in(file, place, "a file", "none");
  if (!fs::is_regular_file(status)) fail_in(file, place, "a regular file", "something else");
  const std::uint64_t size = fs::file_size(path, error);
  if (error || size > limit)
    fail_in(file, place, "at most " + std::to_string(limit) + " bytes", std::to_string(size) + " bytes");
  Bytes bytes(size);
  std::ifstream stream(path, std::ios::binary);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    fail_in(file, place, "a readable file", "an error while reading");
  return bytes;
}

Bytes decode_data_uri(const Document& document, const std::string& place, const std::string& uri) {
  const size_t comma = uri.find(',');
  const std::string_view tag = ";base64";
  if (comma == std::string::npos || comma < 5 + tag.size() ||
      uri.compare(comma - tag.size(), tag.size(), tag) != 0)
    fail_in(document.file, place, "a data: URI with ;base64,", shown(uri));
  const size_t size = uri.size() - comma - 1;
  Bytes bytes(size / 4 * 3 + 3);
  const int decoded = EVP_DecodeBlock(bytes.data(), reinterpret_cast<const unsigned char*>(&uri[comma + 1]),
                                      static_cast<int>(size));
  if (decoded < 0) fail_in(document.file, place, "base64", shown(uri));
  const size_t padding = size > 1 ? (uri[uri.size() - 1] == '=') + (uri[uri.size() - 2] == '=') : 0;
  bytes.resize(static_cast<size_t>(decoded) - std::min(padding, static_cast<size_t>(decoded)));
  return bytes;
}

}  // namespace gltf
