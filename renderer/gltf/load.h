// glTF 2.0 (.gltf, .glb) -> scene::Scene. This room owns tinygltf, and does not trust it: tinygltf 2.7 checks
// almost no index, range or path, so guard() (guard.h) judges the whole file first and tinygltf then parses a
// document that names no file and holds no reference out of range. What is read, ignored or refused:
// docs/gltf.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "scene/scene.h"

namespace gltf {

// docs/formats.md, "Scene". automatic: candela if asset.generator names Blender, else watt.
enum class PunctualUnits { automatic, watt, candela };

// What a file may ask for before it is refused: generous for real scenes, small against amplification.
struct Limits {
  // Bytes: the files, what is read from them, and what the renderer builds over that.
  std::uint64_t memory = 1'000'000'000;
  int json_depth = 64;
  std::uint64_t nodes = 500'000;
  int node_depth = 1024;
  std::uint64_t accessors = 200'000;
  std::uint64_t materials = 16'384;
  std::uint64_t images = 1024;
};

struct Options {
  PunctualUnits punctual_units = PunctualUnits::automatic;
  Limits limits;
};

// Throws base::Error, one line naming the file, the place in it, what was wanted and what was found.
scene::Scene load(const std::string& file, const Options& options = {});

// The rigid frame of a camera whose node has this transform: viewing direction kept, up made perpendicular to
// it, scale, shear and mirroring removed. nullopt if nothing is left of a direction.
std::optional<math::Mat4> camera_frame(const math::DMat4& to_world);

// SHA-256 of a file's bytes, as sha256sum prints it. Throws base::Error.
std::string hash(const std::string& file);

}  // namespace gltf
