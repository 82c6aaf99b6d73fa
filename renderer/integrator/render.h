// From a scene and settings to a film: tiles, threads (this room owns oneTBB), passes.
//
// The same scene, settings and seed give the same bits for any thread count, tile order and split into
// passes: every random number is a function of (pixel, sample, dimension, seed) and one owner sums a pixel in
// sample order.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "image/film.h"
#include "scene/scene.h"

namespace surface {
struct Point;
}

namespace integrator {

enum class Shader {
  path,
  path_disney,
  principled,
  disney,
  eyelight,
  direct,
  path_nomis,
  normal,
  albedo,
  texcoord,
  position
};
enum class Filter { box, triangle, blackman_harris };
enum class SamplerKind { sobol, random };

struct Settings {
  Shader shader = Shader::disney;
  float d_gamma = 2;                // path_disney: exponent of its D, in (0, 10]
  std::optional<float> d_constant;  // path_disney: factor of its D; absent: the normalised one
  int width = 512, height = 512;
  int crop_x = 0, crop_y = 0, crop_width = 0,
      crop_height = 0;  // pixels of the full image; width 0: all of it
  int camera = 0;       // index into Scene::cameras
  int depth = 8;        // scattering events; 0: emission only, 1: direct light
  int spp = 256;
  int replicates = 8;  // independently scrambled parts of the samples, spread -> variance; must divide spp
  std::uint32_t seed = 1;
  float clamp = 0;  // > 0: each sample's radiance is scaled to at most this vector length (biased)
  bool hide_environment = false;  // camera rays that leave the scene see black
  Filter filter = Filter::box;
  SamplerKind sampler = SamplerKind::sobol;
  int threads = 0;           // 0: all
  bool fastest_isa = false;  // let Embree use FMA instruction sets: faster, bits then depend on the CPU
};

struct Status {
  double fraction = 0;  // of the work of this call
  std::uint64_t rays = 0;
};
// Called about ten times a second, from one thread at a time; returning false stops the render at the next
// pixel.
using Progress = std::function<bool(const Status&)>;

// "emission", "diffuse.direct", "diffuse.indirect", "sheen.direct", ...: see integrator::Parts.
std::span<const std::string> part_names();

// Pixels that may share paths: blocks of 2 x 2, or what of them is in the picture.
inline constexpr int block_side = 2, block_size = block_side * block_side;

// How samples, which are paths, are made. Reuse is left out where some surface lets rays pass by chance.
struct Technique {
  int together = 1;    // paths that go on from what one camera ray finds
  bool reuse = false;  // the paths of a block share what they meet at their second surfaces (reuse.h)
};

// Of each replicate the samples from number `from` on; those before had `rays` camera rays.
struct Sharing {
  int from = 0, rays = 0;
  std::function<Technique(int x, int y)> technique;  // the same for a whole block; none: Technique()
};

// How samples differ two by two, those that share a camera ray if any do; both films hold data.
struct Spread {
  // Half the square of their difference, the square of their mean, both summed over channels; rays of reuse.
  image::Film pairs;
  // Half the square of the difference in what reuse has no part in; in the rest; in that without reuse.
  image::Film reuse;
};

class Renderer {
 public:
  // Reduces the scene to what it uses, builds the acceleration structure and the light tables. Keeps a
  // reference to `scene`. Throws base::Error for settings that make no sense (naming the option as
  // assay-render spells it).
  Renderer(const scene::Scene& scene, const Settings& settings);
  ~Renderer();

  // After an edit in place of the scene's cameras, materials (but not which textures they have), lights or
  // environment, and with new settings: rebuilds what that touches and keeps the rest. From then on every bit
  // is a new Renderer's. `lights_changed`: a light, the environment, or a material that emits or did. Not
  // while another thread calls anything else.
  void refresh(const Settings& settings, bool lights_changed);

  // An empty film of the right size (the crop's) and replicates.
  image::Film film() const;

  // Adds samples [first, first + count) of every pixel to `film`; sample s belongs to replicate s %
  // replicates. False if stopped by `progress`: the film then holds whole tiles of this call only where they
  // were finished.
  // `parts`, if not empty, takes the radiance apart by the first surface's lobes (part_names() films from
  // film()); path-tracing shaders without clamp only. `stop`, if not null, ends the call as `progress` does,
  // but at once.
  bool render(image::Film& film, int first, int count, const Progress& progress = {},
              std::span<image::Film> parts = {}, const std::atomic<bool>* stop = nullptr) const;
  // The same for counts that differ from pixel to pixel: of each replicate, samples from `done` until
  // `wanted`.
  using Counts = std::function<int(int x, int y, int replicate)>;
  // They are the same for a whole block if its paths are reused. `spread`, if not null (of the size of
  // `film`), takes how the samples of this call differ.
  bool render(image::Film& film, const Counts& done, const Counts& wanted, const Sharing& sharing = {},
              Spread* spread = nullptr, const Progress& progress = {}, std::span<image::Film> parts = {},
              const std::atomic<bool>* stop = nullptr) const;

  // What is seen at a point of the image (pixels, as CameraRays has them; not of the crop); nullopt: nothing.
  std::optional<surface::Point> first_surface(float x, float y) const;

  // Noise-free layer of the first hit through each pixel centre: shader is one of normal, albedo, position (3
  // channels) or, with `depth` true, the distance along the ray (all three channels alike; 0 where nothing is
  // hit).
  image::Image first_hit(Shader shader, bool depth = false) const;

  std::uint64_t rays() const;    // traced so far, camera, bounce and shadow
  double build_seconds() const;  // acceleration structure and light tables
  std::string isa() const;       // Embree's instruction set, for the provenance
  std::string summary() const;   // what the scene was reduced to, for --info: several lines

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace integrator
