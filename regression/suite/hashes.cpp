#include "suite/hashes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/error.h"
#include "image/hash.h"
#include "suite/schema.h"

namespace suite {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A double as Python's repr() writes it: the shortest digits that read back the same; plain between 1e-4 and
// 1e16, always with a point or an exponent of at least two digits.
std::string python_repr(double x) {
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, x, std::chars_format::scientific).ptr;
  const std::string text(buffer, end);  // -d.ddde+xx
  const bool negative = text[0] == '-';
  const size_t e = text.find('e');
  std::string digits = text.substr(negative, e - negative);
  digits.erase(std::remove(digits.begin(), digits.end(), '.'), digits.end());
  const int exponent = std::stoi(text.substr(e + 1));
  const int count = static_cast<int>(digits.size());
  std::string out;
  if (exponent < -4 || exponent >= 16) {
    out = digits.substr(0, 1) + (count > 1 ? "." + digits.substr(1) : "") + text.substr(e);
  } else if (exponent < 0) {
    out = "0." + std::string(static_cast<size_t>(-exponent - 1), '0') + digits;
  } else if (count <= exponent + 1) {
    out = digits + std::string(static_cast<size_t>(exponent + 1 - count), '0') + ".0";
  } else {
    out = digits.substr(0, static_cast<size_t>(exponent + 1)) + "." +
          digits.substr(static_cast<size_t>(exponent + 1));
  }
  return (negative ? "-" : "") + out;
}

void write_canonical(const json& value, std::string& out) {
  if (value.is_object()) {  // nlohmann's objects are sorted by UTF-8 bytes: the order of code points, as
                            // Python's
    out += '{';
    bool first = true;
    for (const auto& [key, element] : value.items()) {
      if (!first) out += ',';
      first = false;
      out += json(key).dump() + ':';
      write_canonical(element, out);
    }
    out += '}';
  } else if (value.is_array()) {
    out += '[';
    for (size_t i = 0; i < value.size(); ++i) {
      if (i) out += ',';
      write_canonical(value[i], out);
    }
    out += ']';
  } else if (value.is_number_float()) {
    if (!std::isfinite(value.get<double>())) throw std::logic_error("canonical_json: non-finite number");
    out += python_repr(value.get<double>());
  } else {
    out += value.dump();
  }
}

std::string percent_decoded(const std::string& uri) {
  std::string out;
  for (size_t i = 0; i < uri.size(); ++i) {
    unsigned char byte = 0;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(&uri[i + 1], &uri[i + 1] + 2, byte, 16).ptr == &uri[i + 1] + 2) {
      out += static_cast<char>(byte);
      i += 2;
    } else {
      out += uri[i];
    }
  }
  return out;
}

// The JSON text of a scene: the file itself, or the first chunk of a .glb.
std::string scene_json(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  if (!stream) base::fail_in(file, "", "a readable scene", "none");
  const std::string text = bytes.str();
  if (text.compare(0, 4, "glTF") != 0) return text;
  if (text.size() < 20) base::fail_in(file, "", "a .glb header of 20 bytes", std::to_string(text.size()));
  std::uint32_t length = 0;
  std::memcpy(&length, text.data() + 12, 4);  // little-endian, like every machine this runs on
  if (length > text.size() - 20)
    base::fail_in(file, "chunk 0", "a length inside the file", std::to_string(length));
  return text.substr(20, length);
}

// Adds the bytes of a file beside the scene. Data URIs are part of the scene file already.
void add_external(image::Hasher& hasher, const std::string& scene, const std::string& place,
                  const json& holder, const char* key) {
  if (!holder.is_object() || !holder.contains(key) || !holder[key].is_string()) return;
  const std::string uri = holder[key];
  if (uri.compare(0, 5, "data:") == 0) return;
  const fs::path relative = fs::path(percent_decoded(uri)).lexically_normal();
  if (relative.is_absolute() || (!relative.empty() && *relative.begin() == ".."))
    base::fail_in(scene, place, "a file beside the scene", "\"" + uri + "\"");
  const fs::path path = fs::path(scene).parent_path() / relative;
  if (!fs::is_regular_file(path)) base::fail_in(scene, place, "the file " + path.string(), "none");
  hasher.add_file(path.string());
}

}  // namespace

std::string canonical_json(const json& value) {
  std::string out;
  write_canonical(value, out);
  return out;
}

std::string scene_hash(const std::string& scene_file) {
  json scene;
  try {
    scene = json::parse(scene_json(scene_file));
  } catch (const json::exception& error) {
    base::fail(scene_file, ": wanted glTF, found: ", error.what());
  }
  image::Hasher hasher;
  hasher.add_file(scene_file);
  for (const char* list : {"buffers", "images"}) {
    const json entries = scene.is_object() ? scene.value(list, json::array()) : json::array();
    for (size_t i = 0; i < entries.size(); ++i)
      add_external(hasher, scene_file, std::string(list) + "[" + std::to_string(i) + "].uri", entries[i],
                   "uri");
  }
  const json scenes = scene.is_object() ? scene.value("scenes", json::array()) : json::array();
  const size_t index = scene.is_object() && scene.contains("scene") && scene["scene"].is_number_unsigned()
                           ? scene["scene"].get<size_t>()
                           : 0;
  if (index < scenes.size() && scenes[index].is_object() && scenes[index].contains("extras"))
    add_external(hasher, scene_file, "extras.environment", scenes[index]["extras"], "environment");
  return hasher.hex();
}

Hashes hashes_of(const Layout& layout, const Case& c) {
  Hashes hashes;
  hashes.scene = scene_hash(layout.scene_file(c));
  json object = {{"camera", c.camera},         {"depth", c.depth},   {"options", c.options},
                 {"scene_hash", hashes.scene}, {"shader", c.shader}, {"size", {c.width, c.height}}};
  hashes.picture = image::sha256(canonical_json(object));
  object.update({{"replicates", c.replicates}, {"seed", c.seed}, {"spp", c.spp}});
  hashes.a_case = image::sha256(canonical_json(object));
  return hashes;
}

std::string script_hash(const std::string& folder) {
  std::vector<fs::path> scripts;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".py") scripts.push_back(entry.path());
  std::sort(scripts.begin(), scripts.end());
  image::Hasher hasher;
  for (const fs::path& script : scripts) hasher.add_file(script.string());
  return hasher.hex();
}

}  // namespace suite
