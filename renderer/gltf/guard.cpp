// The order of judgement: framing, nesting, JSON, version, required extensions, types and references, then
// the files it names, then byte ranges and the node graph. Each step relies only on what the steps before it
// proved.
#include "gltf/guard.h"

#include <openssl/evp.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "base/error.h"

namespace gltf {
using base::fail;
using base::fail_in;
using nlohmann::json;

namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }
  void add(const Bytes& bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  std::string hexadecimal() {
    unsigned char digest[32];
    EVP_DigestFinal_ex(context_.get(), digest, nullptr);
    std::string out;
    for (const unsigned char byte : digest)
      (out += "0123456789abcdef"[byte >> 4]) += "0123456789abcdef"[byte & 15];
    return out;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

struct Framed {
  std::string_view json;
  const unsigned char* binary = nullptr;  // null: no BIN chunk
  std::uint64_t binary_size = 0;
};

std::uint32_t little_endian(const unsigned char* p) {
  return std::uint32_t{p[0]} | std::uint32_t{p[1]} << 8 | std::uint32_t{p[2]} << 16 |
         std::uint32_t{p[3]} << 24;
}

// GLB: "glTF", version, length; then chunks of length, type and payload: JSON, then perhaps BIN, then unknown
// ones, which the specification wants skipped.
Framed unframe(const std::string& file, const Bytes& bytes) {
  Framed framed;
  if (bytes.size() < 4 || std::memcmp(bytes.data(), "glTF", 4) != 0) {
    framed.json = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    return framed;
  }
  const std::string size = std::to_string(bytes.size());
  if (bytes.size() < 12) fail_in(file, "GLB header", "12 bytes", size);
  if (const auto version = little_endian(&bytes[4]); version != 2)
    fail_in(file, "GLB header", "version 2", std::to_string(version));
  if (const auto length = little_endian(&bytes[8]); length != bytes.size())
    fail_in(file, "GLB header", "the file's length, " + size, std::to_string(length));
  std::uint64_t at = 12;
  for (int chunk = 0; at < bytes.size(); ++chunk) {
    const std::string place = "GLB chunk " + std::to_string(chunk);
    if (bytes.size() - at < 8) fail_in(file, place, "a header of 8 bytes", std::to_string(bytes.size() - at));
    const std::uint64_t length = little_endian(&bytes[at]), left = bytes.size() - at - 8;
    const std::uint32_t type = little_endian(&bytes[at + 4]);
    at += 8;
    if (length > left)
      fail_in(file, place, "at most the " + std::to_string(left) + " bytes that follow",
              std::to_string(length));
    if (length % 4 != 0) fail_in(file, place, "a length divisible by 4", std::to_string(length));
    const bool is_json = type == 0x4E4F534A, is_binary = type == 0x004E4942;
    if (is_json != (chunk == 0)) fail_in(file, place, "the JSON chunk first and only there", "another type");
    if (is_binary && chunk != 1)
      fail_in(file, place, "the BIN chunk second and only there", "another BIN chunk");
    const unsigned char* payload = bytes.data() + at;
    if (is_json) framed.json = {reinterpret_cast<const char*>(payload), length};
    if (is_binary) framed.binary = payload, framed.binary_size = length;
    at += length;
  }
  if (framed.json.empty()) fail_in(file, "GLB", "a JSON chunk", "none");
  return framed;
}

// Depth and number of values, on the bytes: a parser that recursed or allocated first would be too late.
void check_nesting(const std::string& file, std::string_view text, const Limits& limits) {
  int depth = 0;
  std::uint64_t values = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == ',' || c == '[' || c == '{') ++values;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > limits.json_depth)
      fail_in(file, "JSON byte " + std::to_string(i),
              "at most " + std::to_string(limits.json_depth) + " nested levels", "more");
  }
  if (values > limits.json_values)
    fail_in(file, "JSON", "at most " + std::to_string(limits.json_values) + " values",
            std::to_string(values));
}

void check_extensions(Document& document) {
  const auto& supported = supported_extensions();
  const auto known = [&](const std::string& name) {
    return std::find(supported.begin(), supported.end(), name) != supported.end();
  };
  std::string names;
  for (const std::string& name : supported) names += (names.empty() ? "" : ", ") + name;
  for (const json& name : list(document.json, "extensionsRequired"))
    if (!known(name))
      fail_in(document.file, "extensionsRequired", "one of " + names, name.get<std::string>());
  for (const json& name : list(document.json, "extensionsUsed"))
    if (!known(name)) document.ignored.push_back("extension " + name.get<std::string>() + " is not rendered");
}

void check_version(const Document& document) {
  const json& asset = document.json["asset"];
  const std::string version = asset["version"], minimum = asset.value("minVersion", "2.0");
  if (version.rfind("2.", 0) != 0) fail_in(document.file, "asset.version", "2.0", version);
  if (minimum != "2.0") fail_in(document.file, "asset.minVersion", "2.0", minimum);
}

// Bring every byte the document needs into `files` and let the uris name them; add external files to the
// hash.
void read_files(Document& document, const Framed& framed, const Limits& limits, Sha256& hash) {
  std::uint64_t total = 0;
  const auto take = [&](const std::string& place, const std::string& uri) {
    Bytes bytes;
    if (uri.rfind("data:", 0) == 0) {
      bytes = decode_data_uri(document, place, uri);
    } else {
      bytes = read_file(document.file, resolve(document, place, uri), place, limits.file_bytes);
      hash.add(bytes);
    }
    if ((total += bytes.size()) > limits.file_bytes)
      fail_in(document.file, place, "at most " + std::to_string(limits.file_bytes) + " bytes in all files",
              "more");
    return bytes;
  };
  for (size_t i = 0; i < list(document.json, "buffers").size(); ++i) {
    json& buffer = document.json["buffers"][i];
    const std::string place = "buffers[" + std::to_string(i) + "]", key = "buffer" + std::to_string(i);
    const std::uint64_t wanted = buffer["byteLength"];
    Bytes bytes;
    if (buffer.contains("uri"))
      bytes = take(place + ".uri", buffer["uri"]);
    else if (i == 0 && framed.binary)
      bytes.assign(framed.binary, framed.binary + framed.binary_size);
    else
      fail_in(document.file, place, "a uri" + std::string(i == 0 ? " or a BIN chunk" : ""), "none");
    if (bytes.size() < wanted)
      fail_in(document.file, place + ".byteLength",
              "at most the " + std::to_string(bytes.size()) + " bytes there are", std::to_string(wanted));
    bytes.resize(wanted);
    buffer["uri"] = key;
    document.files[key] = std::move(bytes);
  }
  for (size_t i = 0; i < list(document.json, "images").size(); ++i) {
    json& image = document.json["images"][i];
    const std::string place = "images[" + std::to_string(i) + "]", key = "image" + std::to_string(i);
    if (image.contains("uri") == image.contains("bufferView"))
      fail_in(document.file, place, "either uri or bufferView", image.contains("uri") ? "both" : "neither");
    if (!image.contains("uri")) continue;
    document.files[key] = take(place + ".uri", image["uri"]);
    if (document.files[key].empty()) fail_in(document.file, place + ".uri", "an image", "no bytes");
    image["uri"] = key;
  }
  if (document.scene < 0) return;
  const json& extras = list(document.json["scenes"][static_cast<size_t>(document.scene)], "extras");
  if (!extras.contains("environment")) return;
  const std::string place = "scenes[" + std::to_string(document.scene) + "].extras.environment";
  if (!extras["environment"].is_string())
    fail_in(document.file, place, "the name of a file", shown(extras["environment"]));
  document.environment = resolve(document, place, extras["environment"]);
  hash.add(read_file(document.file, document.environment, place, limits.file_bytes));
}

}  // namespace

const std::vector<std::string>& supported_extensions() {
  static const std::vector<std::string> names = {"KHR_lights_punctual",     "KHR_materials_anisotropy",
                                                 "KHR_materials_clearcoat", "KHR_materials_emissive_strength",
                                                 "KHR_materials_ior",       "KHR_materials_sheen",
                                                 "KHR_materials_specular",  "KHR_texture_transform"};
  return names;
}

Document guard(const std::string& file, const Limits& user_limits) {
  Limits limits = user_limits;
  limits.file_bytes = std::min<std::uint64_t>(limits.file_bytes, 0x7FFFFFFF);
  const Bytes bytes = read_file(file, file, "", limits.file_bytes);
  const Framed framed = unframe(file, bytes);
  check_nesting(file, framed.json, limits);

  Document document;
  document.file = file;
  try {
    document.json = json::parse(framed.json);
  } catch (const json::exception& error) {
    fail_in(file, "JSON", "a glTF document", std::string(error.what()).substr(0, 200));
  }
  check_schema(document, limits);
  check_version(document);
  check_extensions(document);

  document.scene = document.json.value("scene", list(document.json, "scenes").empty() ? -1 : 0);
  Sha256 hash;
  hash.add(bytes);
  read_files(document, framed, limits, hash);
  document.hash = hash.hexadecimal();
  check_ranges(document);
  document.roots = check_nodes(document, limits);

  // Nothing reads these, so nothing needs to parse them.
  for (const char* key : {"animations", "skins"})
    if (document.json.erase(key) != 0)
      document.ignored.push_back(std::string(key) + " are ignored: the base pose is rendered");
  return document;
}

std::string hash(const std::string& file) {
  Sha256 sha;
  sha.add(read_file(file, file, "", Limits{}.file_bytes));
  return sha.hexadecimal();
}

}  // namespace gltf
