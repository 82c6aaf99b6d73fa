#include "app/output.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/describe.h"
#include "app/parse.h"
#include "app/version.h"
#include "base/error.h"
#include "image/decode.h"
#include "image/display.h"
#include "image/exr.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using integrator::Shader;

image::Metadata provenance(const Options& options, const scene::Scene& scene,
                           const integrator::Renderer& renderer, const image::Film& film, int samples,
                           bool partial) {
  const integrator::Settings& r = options.render;
  const std::int64_t most_int = std::numeric_limits<int>::max();
  image::Metadata data;
  data.set("assay:version", version());
  data.set("assay:commit", commit());
  data.set("assay:scene_hash", scene.hash);
  data.set("assay:command", command(options, false));
  data.set("assay:shader", shader_name(r.shader));
  data.set("assay:isa", renderer.isa());
  data.set("assay:options", decisive(options, scene).dump());
  data.set("assay:spp", samples);
  data.set("assay:replicates", r.replicates);
  data.set("assay:seed", static_cast<int>(r.seed));
  data.set("assay:depth", r.depth);
  data.set("assay:rejected", static_cast<int>(std::min(film.rejected(), most_int)));
  data.set("assay:partial", partial ? 1 : 0);
  data.set("assay:biased", r.clamp > 0 ? 1 : 0);
  return data;
}

image::Image replicate_image(const image::Film& film, int replicate) {
  image::Image out(film.width(), film.height());
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) out.at(x, y) = film.replicate_mean(x, y, replicate);
  return out;
}

}  // namespace

void check_writable(const std::string& file) {
  std::error_code error;
  if (fs::is_directory(file, error)) base::fail(file, ": cannot write: it is a folder");
  if (fs::exists(file, error) && !fs::is_regular_file(file, error))
    base::fail(file, ": cannot write: it is not a file");
  const fs::path folder = fs::path(file).has_parent_path() ? fs::path(file).parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    base::fail(file, ": cannot write: there is no folder ", folder.string());
  const fs::path probe = folder / (".assay-probe-" + std::to_string(getpid()));
  const bool open = std::ofstream(probe).is_open();
  fs::remove(probe, error);
  if (!open) base::fail(file, ": cannot write: no permission to create files in ", folder.string());
}

void write_picture(const Options& options, const scene::Scene& scene, const integrator::Renderer& renderer,
                   const image::Film& film, int samples, bool partial) {
  if (extension_of(options.out) != ".exr") {
    const image::Display display{options.exposure, options.gamma.value_or(0), options.filmic};
    image::write_display(options.out, film.mean_image(), display);
    return;
  }
  image::Exr exr;
  exr.mean = film.mean_image();
  if (film.replicates() > 1) exr.variance = film.variance_image();
  exr.metadata = provenance(options, scene, renderer, film, samples, partial);
  if (options.layer_albedo) exr.layers.push_back({"albedo", "RGB", renderer.first_hit(Shader::albedo)});
  if (options.layer_normal) exr.layers.push_back({"normal", "XYZ", renderer.first_hit(Shader::normal)});
  if (options.layer_depth) exr.layers.push_back({"depth", "Z", renderer.first_hit(Shader::position, true)});
  if (options.layer_position) exr.layers.push_back({"position", "XYZ", renderer.first_hit(Shader::position)});
  if (options.layer_replicates)
    for (int k = 0; k < film.replicates(); ++k)
      exr.layers.push_back({"replicate" + std::to_string(k), "RGB", replicate_image(film, k)});
  image::write_exr(options.out, exr);
}

scene::Environment read_environment(const std::string& file) {
  const image::Image map = image::read_environment(file);
  scene::Environment environment;
  environment.map.name = fs::path(file).filename().string();
  environment.map.width = map.width;
  environment.map.height = map.height;
  environment.map.texels.reserve(map.pixels.size());
  for (const math::Vec3& p : map.pixels) environment.map.texels.push_back({p.x, p.y, p.z, 1});
  return environment;
}

}  // namespace app
