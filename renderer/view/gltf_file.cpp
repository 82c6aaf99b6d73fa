#include "view/gltf_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "gltf/guard.h"
#include "image/exr.h"
#include "image/file.h"
#include "view/gltf_editor.h"

namespace view {
namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using gltf::Bytes, gltf::Document, gltf::Span;

bool is_glb(const Bytes& bytes) {
  return bytes.size() >= 20 && std::equal(bytes.begin(), bytes.begin() + 4, "glTF");
}

// The JSON as it stands in the file; guard() has judged its framing.
Json read_json(const Document& document) {
  const Bytes& bytes = *document.files[0];
  if (!is_glb(bytes)) return Json::parse(bytes.begin(), bytes.end());
  const size_t length = bytes[12] | bytes[13] << 8 | bytes[14] << 16 | size_t{bytes[15]} << 24;
  return Json::parse(bytes.begin() + 20, bytes.begin() + 20 + static_cast<std::ptrdiff_t>(length));
}

bool names_file(const Json& object) {
  return object.contains("uri") && !object["uri"].get_ref<const std::string&>().starts_with("data:");
}

// All buffers one after the other, and images from files behind them.
std::string pack(Json& root, const Document& document) {
  std::string blob;
  const auto append = [&](Span bytes) {
    blob.resize((blob.size() + 3) / 4 * 4);
    const size_t offset = blob.size();
    blob.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return offset;
  };
  std::vector<size_t> offsets;
  for (const Span buffer : document.buffers) offsets.push_back(append(buffer));
  if (root.contains("bufferViews"))
    for (Json& view : root["bufferViews"]) {
      const size_t offset = offsets[view["buffer"].get<size_t>()];
      view["buffer"] = 0;
      if (offset > 0) view["byteOffset"] = view.value("byteOffset", size_t{0}) + offset;
    }
  if (root.contains("images"))
    for (size_t i = 0; i < root["images"].size(); ++i) {
      Json& image = root["images"][i];
      if (!names_file(image)) continue;
      const Span bytes = document.images[i].bytes;
      image.erase("uri");
      image["mimeType"] = bytes[0] == 0x89 ? "image/png" : "image/jpeg";
      image["bufferView"] = root["bufferViews"].size();
      root["bufferViews"].push_back(
          {{"buffer", 0}, {"byteOffset", append(bytes)}, {"byteLength", bytes.size()}});
    }
  if (blob.empty()) return blob;
  Json first = root.contains("buffers") ? root["buffers"][0] : Json::object();
  first.erase("uri");
  first["byteLength"] = blob.size();
  root["buffers"] = Json::array({first});
  return blob;
}

void put32(std::string& out, size_t value) {
  for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(value >> shift & 255);
}

std::string to_glb(std::string text, std::string blob) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  blob.resize((blob.size() + 3) / 4 * 4);
  std::string out = "glTF";
  put32(out, 2);
  put32(out, 20 + text.size() + (blob.empty() ? 0 : 8 + blob.size()));
  put32(out, text.size());
  (out += "JSON") += text;
  if (blob.empty()) return out;
  put32(out, blob.size());
  return (out.append("BIN\0", 4)) += blob;
}

void write(const std::string& path, const std::string& bytes) {
  image::write_whole(path, bytes.data(), bytes.size());
}

// The file name as a URI: what is not plain is percent-encoded.
std::string to_uri(const std::string& name) {
  std::string uri;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) || std::string("-._~").find(c) != std::string::npos) {
      uri += c;
      continue;
    }
    uri += '%';
    for (const int digit : {c >> 4 & 15, c & 15}) uri += "0123456789ABCDEF"[digit];
  }
  return uri;
}

bool is_constant(const scene::Bitmap& map) {
  return std::all_of(map.texels.begin(), map.texels.end(),
                     [&](const math::Vec4& texel) { return texel == map.texels[0]; });
}

// Sets the scene's environment, with its map in a file beside `target` unless it is constant.
void write_environment(Json& extras, const EnvironmentEdit& edit, const fs::path& target) {
  for (const char* key : {"environment", "environment_color"}) extras.erase(key);
  const scene::Bitmap& map = edit.environment.map;
  if (is_constant(map)) {
    const math::Vec4& c = map.texels[0];
    extras["environment_color"] = {decimal(c.x), decimal(c.y), decimal(c.z)};
  } else {
    image::Exr exr;
    exr.mean = image::Image(map.width, map.height);
    for (size_t i = 0; i < map.texels.size(); ++i) exr.mean.pixels[i] = math::Vec3(map.texels[i]);
    const std::string name = target.stem().string() + ".environment.exr";
    image::write_exr((target.parent_path() / name).string(), exr);
    extras["environment"] = to_uri(name);
  }
  extras["environment_strength"] = decimal(edit.environment.strength);
  extras["environment_rotation"] = decimal(edit.rotation_degrees);
}

}  // namespace

void write_gltf(const std::string& original, const std::string& hash, const std::string& target,
                const Edits& edits, const gltf::Options& options) {
  const fs::path path = target;
  const std::string extension = image::lower_extension(target);
  if (extension != ".gltf" && extension != ".glb")
    base::fail(target, ": wanted a name ending in .gltf or .glb");
  std::error_code none;
  if (fs::equivalent(original, target, none))
    base::fail(target, ": wanted another file than the scene it was read from");
  std::vector<std::string> lines;
  gltf::Warnings warnings(lines);
  const Document document = gltf::guard(original, options.limits, warnings);
  if (document.hash != hash) base::fail(original, ": it has changed since it was loaded");

  Json root = read_json(document);
  Editor editor(root, document, options.punctual_units);
  for (const MaterialEdit& edit : edits.materials) editor.write(edit);
  for (const scene::Light& light : edits.lights) editor.write(light);
  if (edits.camera) editor.add(*edits.camera);

  const bool moved =
      !fs::equivalent(fs::absolute(original).parent_path(), fs::absolute(path).parent_path(), none);
  if (edits.environment) {
    write_environment(editor.extras(), *edits.environment, path);
  } else if (moved && !document.environment.empty()) {
    const std::string name =
        path.stem().string() + ".environment" + image::lower_extension(document.environment);
    const Bytes bytes = gltf::read_file(document, document.environment, "environment");
    write((path.parent_path() / name).string(), {bytes.begin(), bytes.end()});
    editor.extras()["environment"] = to_uri(name);
  }

  if (extension == ".glb") {
    const std::string blob = pack(root, document);
    return write(target, to_glb(root.dump(), blob));
  }
  for (const char* list : {"buffers", "images"})
    for (const Json& object : root.value(list, Json::array()))
      if (moved && names_file(object))
        base::fail(target, ": wanted the folder of ", original, ", which names files there, or a .glb");
  if (is_glb(*document.files[0]) && !document.buffers.empty() && !root["buffers"][0].contains("uri")) {
    const std::string name = path.stem().string() + ".bin";
    const Span bytes = document.buffers[0];
    image::write_whole((path.parent_path() / name).string(), bytes.data(), bytes.size());
    root["buffers"][0]["uri"] = to_uri(name);
  }
  write(target, root.dump(1) + "\n");
}

}  // namespace view
