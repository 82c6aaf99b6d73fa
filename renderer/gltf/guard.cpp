// The order of judgement: framing, JSON and its nesting, types and references, version, required extensions,
// byte ranges and the node graph, then the files it names. Each step relies only on what the steps before it
// proved.
#include "gltf/guard.h"

#include <openssl/evp.h>

#include <algorithm>
#include <map>
#include <optional>

namespace gltf {
using nlohmann::json;

namespace {

// SHA-256 of the parts one after the other, in hexadecimal.
std::string sha256(const std::vector<Span>& parts) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  for (const Span part : parts) EVP_DigestUpdate(context.get(), part.data(), part.size());
  unsigned char digest[32];
  EVP_DigestFinal_ex(context.get(), digest, nullptr);
  std::string out;
  for (const unsigned char byte : digest)
    (out += "0123456789abcdef"[byte >> 4]) += "0123456789abcdef"[byte & 15];
  return out;
}

// GLB: "glTF", version, length; then chunks of length, type and payload: JSON, then perhaps BIN, then unknown
// ones, which the specification wants skipped. Returns the JSON; plain JSON is itself.
Span unframe(const Document& document, Span bytes, std::optional<Span>& binary) {
  const auto number = [&](size_t at) {  // little-endian
    return std::uint32_t{bytes[at]} | std::uint32_t{bytes[at + 1]} << 8 | std::uint32_t{bytes[at + 2]} << 16 |
           std::uint32_t{bytes[at + 3]} << 24;
  };
  constexpr std::uint32_t magic = 0x46546C67, json_type = 0x4E4F534A, binary_type = 0x004E4942;
  if (bytes.size() < 4 || number(0) != magic) return bytes;
  document.want(bytes.size() >= 12, "GLB header", "12 bytes", bytes.size());
  document.want(number(4) == 2, "GLB header", "version 2", number(4));
  document.want(number(8) == bytes.size(), "GLB header", "the file's length, " + std::to_string(bytes.size()),
                number(8));
  Span text;
  size_t at = 12;
  for (size_t chunk = 0; at < bytes.size(); ++chunk) {
    const std::string place = "GLB chunk " + std::to_string(chunk);
    document.want(bytes.size() - at >= 8, place, "a header of 8 bytes", bytes.size() - at);
    const std::uint32_t length = number(at), type = number(at + 4);
    at += 8;
    document.want(length <= bytes.size() - at, place,
                  "at most the " + std::to_string(bytes.size() - at) + " bytes that follow", length);
    document.want(length % 4 == 0, place, "a length divisible by 4", length);
    document.want((type == json_type) == (chunk == 0), place, "the JSON chunk first and only there", type);
    document.want(type != binary_type || chunk == 1, place, "the BIN chunk second and only there", type);
    if (type == json_type) text = bytes.subspan(at, length);
    if (type == binary_type) binary = bytes.subspan(at, length);
    at += length;
  }
  return text;
}

// Of a comma or bracket with the key, the value and what is made of it (measured, at worst).
constexpr std::uint64_t json_value_bytes = 400;

// Depth and number of values, on the bytes: a parser that recursed or allocated first would be too late.
void check_nesting(const Document& document, Span text, const Limits& limits) {
  int depth = 0;
  std::uint64_t values = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const unsigned char c = text[i];
    if (c == '"') in_string = !in_string;
    if (in_string && c == '\\') ++i;
    if (in_string) continue;
    const bool opens = c == '[' || c == '{';
    if (opens || c == ',') ++values;
    depth += opens - (c == ']' || c == '}');
    if (depth > limits.json_depth)
      document.fail("JSON byte " + std::to_string(i),
                    at_most(static_cast<std::uint64_t>(limits.json_depth)) + " nested levels", "more");
  }
  // Once parsed by us and once by tinygltf.
  document.take("JSON", values, json_value_bytes);
  document.take("JSON", text.size(), 3);
}

// Bring every byte the document needs into `files`, and what is external into the hash.
void read_files(Document& document, const std::optional<Span>& binary) {
  std::vector<Span> hashed{*document.files[0]};
  std::map<std::string, Span> known;  // a file named twice is read once
  const auto keep = [&](Bytes bytes) -> Span {
    return *document.files.emplace_back(std::make_unique<const Bytes>(std::move(bytes)));
  };
  const auto read = [&](const std::string& place, const std::string& path) {
    const auto [file, fresh] = known.try_emplace(path);
    if (fresh) file->second = keep(read_file(document, path, place));
    return hashed.emplace_back(file->second);
  };
  const auto take = [&](const std::string& place, const std::string& uri) {
    return uri.starts_with("data:") ? keep(decode_data_uri(document, place, uri))
                                    : read(place, resolve(document, place, uri));
  };
  for (const json& buffer : list(document.json, "buffers")) {
    const size_t i = document.buffers.size(), wanted = buffer["byteLength"];
    const std::string place = at("buffers", i);
    const bool named = buffer.contains("uri");
    document.want(named || (i == 0 && binary), place, i == 0 ? "a uri or a BIN chunk" : "a uri", "none");
    const Span bytes = named ? take(place + ".uri", buffer["uri"]) : *binary;
    document.want(bytes.size() >= wanted, place + ".byteLength",
                  "at most the " + std::to_string(bytes.size()) + " bytes there are", wanted);
    document.buffers.push_back(bytes.first(wanted));
  }
  for (const json& image : list(document.json, "images")) {
    const std::string place = at("images", document.images.size());
    Span bytes;
    if (image.contains("uri")) {
      bytes = take(place + ".uri", image["uri"]);
    } else {
      document.want(image.contains("bufferView"), place, "either uri or bufferView", "neither");
      const json& view = document.json["bufferViews"][image["bufferView"].get<size_t>()];
      bytes = document.buffers[view["buffer"].get<size_t>()].subspan(view.value("byteOffset", size_t{0}),
                                                                     view["byteLength"].get<size_t>());
    }
    document.want(!bytes.empty(), place, "an image", "no bytes");
    document.images.push_back({bytes, name_of(image), image["mimeType"]});
  }
  if (const json& extras = document.extras(); extras.contains("environment")) {
    const std::string place = at("scenes", static_cast<size_t>(document.scene)) + ".extras.environment";
    document.environment = resolve(document, place, extras["environment"]);
    read(place, document.environment);
  }
  document.hash = sha256(hashed);
}

}  // namespace

Document guard(const std::string& file, const Limits& limits, Warnings& warnings) {
  Document document;
  document.file = file;
  document.memory_left = limits.memory;
  document.files.push_back(std::make_unique<const Bytes>(read_file(document, file, "")));
  std::optional<Span> binary;
  const Span text = unframe(document, *document.files[0], binary);
  check_nesting(document, text, limits);
  json& root = document.json;
  try {
    root = json::parse(text.begin(), text.end());
  } catch (const json::exception& error) {
    document.fail("JSON", "a glTF document", std::string(error.what()).substr(0, 200));
  }
  // Counted before defaults are filled in, which make the document larger.
  const std::pair<const char*, std::uint64_t> most[] = {{"nodes", limits.nodes},
                                                        {"accessors", limits.accessors},
                                                        {"materials", limits.materials},
                                                        {"images", limits.images}};
  for (const auto& [array, limit] : most)
    document.want(list(root, array).size() <= limit, array, at_most(limit), "more");
  check_schema(document, warnings);
  const std::string version = root["asset"]["version"];
  document.want(version.starts_with("2."), "asset.version", "2.0", version);
  check_ranges(document);
  document.scene = root.value("scene", list(root, "scenes").empty() ? -1 : 0);
  document.roots = check_nodes(document, limits);
  read_files(document, binary);
  document.materials.swap(root["materials"]);
  for (const char* read : {"materials", "buffers", "images"}) root.erase(read);
  return document;
}

std::string hash(const std::string& file) {
  Document document;
  document.file = file;
  document.memory_left = ~std::uint64_t{0};
  return sha256({read_file(document, file, "")});
}

}  // namespace gltf
