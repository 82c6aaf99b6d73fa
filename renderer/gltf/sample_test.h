// For tests: small glTF files built in memory, written to a folder of their own.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "gltf/load.h"

namespace gltf::sample {

using nlohmann::json;
using Bytes = std::vector<unsigned char>;

// A temporary folder that vanishes with the object.
class Folder {
 public:
  Folder() {
    // In memory where there is such a place: these tests write thousands of files.
    const bool memory = std::filesystem::is_directory("/dev/shm");
    std::string name =
        (memory ? "/dev/shm" : std::filesystem::temp_directory_path().string()) + "/assay-gltf-XXXXXX";
    path_ = ::mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + '/' + name; }
  std::string write(const std::string& name, std::string_view bytes) const {
    std::ofstream(path_ + '/' + name, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path_ + '/' + name;
  }

 private:
  std::string path_;
};

template <typename T>
void append(Bytes& bytes, std::initializer_list<T> values) {
  for (const T value : values) {
    unsigned char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.insert(bytes.end(), raw, raw + sizeof(T));
  }
}

inline void put32(std::string& out, std::uint64_t value) {
  for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(value >> shift & 255);
}

inline std::string glb(std::string text, Bytes binary) {
  while (text.size() % 4 != 0) text += ' ';
  while (binary.size() % 4 != 0) binary.push_back(0);
  std::string out = "glTF";
  put32(out, 2);
  put32(out, 12 + 8 + text.size() + (binary.empty() ? 0 : 8 + binary.size()));
  put32(out, text.size());
  out += "JSON" + text;
  if (binary.empty()) return out;
  put32(out, binary.size());
  (out += "BIN") += '\0';
  return out.append(reinterpret_cast<const char*>(binary.data()), binary.size());
}

inline std::string base64(const Bytes& bytes) {
  static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

// A file under construction: each data() call adds a bufferView and an accessor over it.
struct File {
  json root = json::parse(R"({"asset": {"version": "2.0"}, "scene": 0})");
  Bytes binary;

  size_t view(const Bytes& bytes) {
    while (binary.size() % 4 != 0) binary.push_back(0);
    json view;
    view["buffer"] = 0;
    view["byteOffset"] = binary.size();
    view["byteLength"] = bytes.size();
    root["bufferViews"].push_back(view);
    binary.insert(binary.end(), bytes.begin(), bytes.end());
    root["buffers"][0]["byteLength"] = binary.size();
    return root["bufferViews"].size() - 1;
  }

  template <typename T>
  size_t data(const std::string& type, int component_type, size_t count, std::initializer_list<T> values,
              bool normalized = false) {
    Bytes bytes;
    append(bytes, values);
    json accessor;
    accessor["bufferView"] = view(bytes);
    accessor["componentType"] = component_type;
    accessor["count"] = count;
    accessor["type"] = type;
    if (normalized) accessor["normalized"] = true;
    root["accessors"].push_back(accessor);
    return root["accessors"].size() - 1;
  }

  std::string to_glb() const { return glb(root.dump(), binary); }
};

// One triangle under one node.
inline File triangle() {
  File f;
  f.data<float>("VEC3", 5126, 3, {0, 0, 0, 1, 0, 0, 0, 1, 0});
  f.data<std::uint16_t>("SCALAR", 5123, 3, {0, 1, 2});
  f.root["meshes"] =
      json::parse(R"([{"name": "tri", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}])");
  f.root["nodes"] = json::parse(R"([{"mesh": 0}])");
  f.root["scenes"] = json::parse(R"([{"nodes": [0]}])");
  return f;
}

inline scene::Scene load_bytes(std::string_view bytes, const Options& options = {}) {
  const Folder folder;
  return load(folder.write("scene.glb", bytes), options);
}
inline scene::Scene load_file(const File& file, const Options& options = {}) {
  return load_bytes(file.to_glb(), options);
}

// What load() says about wrong bytes; "" if it takes them.
inline std::string complaint(std::string_view bytes, const Options& options = {}) {
  try {
    load_bytes(bytes, options);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}
inline std::string complaint(const File& file, const Options& options = {}) {
  return complaint(file.to_glb(), options);
}

// Refused in one line that starts with the file's name and names `place`.
inline void expect_refused(const std::string& message, const std::string& place) {
  EXPECT_NE(message, "") << "it was loaded; expected a refusal naming " << place;
  EXPECT_NE(message.find(".gl"), std::string::npos) << message;
  EXPECT_NE(message.find(place), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

inline bool warned(const scene::Scene& scene, const std::string& text) {
  for (const std::string& line : scene.warnings)
    if (line.find(text) != std::string::npos) return true;
  return false;
}

}  // namespace gltf::sample
