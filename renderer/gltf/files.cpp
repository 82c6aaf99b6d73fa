// Which bytes outside the scene file may be read, and reading them: relative paths that stay inside the
// scene's folder after percent-decoding and after following symbolic links, regular files only, nothing from
// the current directory; data: URIs in base64.
#include <openssl/evp.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

#include "gltf/guard.h"

namespace gltf {
namespace fs = std::filesystem;

std::string resolve(const Document& document, const std::string& place, const std::string& uri) {
  const auto want = [&](bool holds, const std::string& wanted) {
    if (!holds) document.fail(place, wanted, uri.substr(0, 60));
  };
  // A scheme or a drive letter: anything with a colon before the first slash.
  want(uri.find(':') >= uri.find('/'), "a relative path or a data: URI");
  std::string name;
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      name += uri[i];
      continue;
    }
    const std::string code = uri.substr(i + 1, 2);
    want(code.size() == 2 &&
             std::all_of(code.begin(), code.end(), [](unsigned char c) { return std::isxdigit(c); }),
         "two hexadecimal digits after each %");
    name += static_cast<char>(std::stoi(code, nullptr, 16));
    i += 2;
  }
  // Judge the decoded name: what the file system will see.
  want(std::none_of(name.begin(), name.end(), [](unsigned char c) { return c < 32 || c == '\\'; }),
       "a path without control characters and backslashes");
  const fs::path relative(name);
  want(relative.is_relative() && std::find(relative.begin(), relative.end(), "..") == relative.end(),
       "a relative path inside the scene's folder");
  // Judge what it leads to.
  std::error_code error;
  const fs::path folder = fs::canonical(fs::absolute(document.file, error).parent_path(), error);
  want(!error, "a readable folder around the scene file");
  const fs::path target = fs::canonical(folder / relative, error);
  want(!error, "a file in the scene's folder");
  const auto [in_folder, in_target] =
      std::mismatch(folder.begin(), folder.end(), target.begin(), target.end());
  want(in_folder == folder.end(), "a path inside the scene's folder, symbolic links followed");
  want(fs::is_regular_file(target, error), "a regular file");
  return target.string();
}

Bytes read_file(const Document& document, const std::string& path, const std::string& place) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  document.want(fs::is_regular_file(status), place, "a regular file",
                fs::exists(status) ? "something else" : "none");
  const std::uint64_t size = fs::file_size(path, error);
  constexpr std::uint64_t most = 0x7FFFFFFF;  // lengths are ints in OpenSSL and tinygltf
  document.want(!error && size <= most, place, at_most(most) + " bytes", size);
  document.take(place, size, 1);
  Bytes bytes(size);
  std::ifstream stream(path, std::ios::binary);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  document.want(bool(stream), place, "a readable file", "an error while reading");
  return bytes;
}

Bytes decode_data_uri(const Document& document, const std::string& place, const std::string& uri) {
  const std::string tag = ";base64,", start = uri.substr(0, 60);
  const size_t first = uri.find(',') + 1;  // 0 without a comma
  document.want(first >= 5 + tag.size() && uri.compare(first - tag.size(), tag.size(), tag) == 0, place,
                "a data: URI with ;base64,", start);
  const size_t size = uri.size() - first;
  document.take(place, size, 1);
  Bytes bytes(size / 4 * 3 + 3);
  const int decoded = EVP_DecodeBlock(bytes.data(), reinterpret_cast<const unsigned char*>(&uri[first]),
                                      static_cast<int>(size));
  document.want(decoded >= 0, place, "base64", start);
  // Padding decodes to zeros that are not there.
  const auto padding =
      std::count(uri.end() - static_cast<std::ptrdiff_t>(std::min<size_t>(size, 2)), uri.end(), '=');
  bytes.resize(static_cast<size_t>(decoded) - static_cast<size_t>(padding));
  return bytes;
}

}  // namespace gltf
