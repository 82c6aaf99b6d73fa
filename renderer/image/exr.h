// OpenEXR files with provenance: the layout of docs/formats.md, "EXR written by assay-render".
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "image/image.h"

namespace image {

// Header entries in the order written, names with their prefix ("assay:spp").
struct Metadata {
  using Value = std::variant<std::string, int, float>;
  std::vector<std::pair<std::string, Value>> entries;
  void set(const std::string& name, Value value) { entries.emplace_back(name, std::move(value)); }
  const Value* find(const std::string& name) const;
};

// A further image in the same file, stored as float.
struct Layer {
  std::string name;      // "albedo", "replicate0"
  std::string channels;  // one letter each, of the image's first components: "RGB", "XYZ", "Z"
  Image image;
};

struct Exr {
  Image mean;
  Image variance;  // of the mean; empty: none
  std::vector<Layer> layers;
  Metadata metadata;
};

// Writes R, G, B as float, the variance as half with its scale, the layers and the metadata, ZIP-compressed.
// The same input gives the same bytes but for the date that OpenImageIO puts into the header. The file appears whole or not at all; throws base::Error naming it and
// the reason.
void write_exr(const std::string& path, const Exr& exr);

}  // namespace image
