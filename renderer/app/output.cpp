#include "app/output.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "app/version.h"
#include "base/error.h"
#include "image/decode.h"
#include "image/display.h"
#include "image/exr.h"
#include "image/file.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using integrator::Shader;

image::Exr to_exr(const Options& options, const scene::Scene& scene, const integrator::Renderer& renderer,
                  const image::Film& film, std::span<const image::Film> parts, int samples, bool partial) {
  const integrator::Settings& r = options.render;
  image::Exr exr;
  exr.mean = film.mean_image();
  if (film.replicates() > 1) exr.variance = film.variance_image();

  const std::vector<std::string> layers = options["layers"];
  const auto add = [&](const char* name, const char* channels, Shader shader, bool depth) {
    if (std::count(layers.begin(), layers.end(), name) > 0)
      exr.layers.push_back({name, channels, renderer.first_hit(shader, depth)});
  };
  add("albedo", "RGB", Shader::albedo, false);
  add("normal", "XYZ", Shader::normal, false);
  add("depth", "Z", Shader::position, true);
  add("position", "XYZ", Shader::position, false);
  if (std::count(layers.begin(), layers.end(), "samples") > 0) {
    image::Image counts(film.width(), film.height());
    for (int y = 0; y < film.height(); ++y)
      for (int x = 0; x < film.width(); ++x)
        counts.at(x, y) = math::Vec3(static_cast<float>(film.samples(x, y)));
    exr.layers.push_back({"samples", "N", std::move(counts)});
  }
  for (int k = 0; k < film.replicates() && std::count(layers.begin(), layers.end(), "replicates") > 0; ++k) {
    image::Image replicate(film.width(), film.height());
    for (int y = 0; y < film.height(); ++y)
      for (int x = 0; x < film.width(); ++x) replicate.at(x, y) = film.replicate_mean(x, y, k);
    exr.layers.push_back({"replicate" + std::to_string(k), "RGB", std::move(replicate)});
  }

  for (size_t i = 0; i < parts.size(); ++i) {
    exr.layers.push_back({integrator::part_names()[i], "RGB", parts[i].mean_image()});
    if (parts[i].replicates() > 1)
      exr.layers.push_back({integrator::part_names()[i] + ".variance", "RGB", parts[i].variance_image()});
  }

  nlohmann::json decides = decisive(options);
  decides["scene_hash"] = scene.hash;
  const std::int64_t most_int = std::numeric_limits<int>::max();
  exr.metadata.entries = {{"assay:version", version},
                          {"assay:commit", commit},
                          {"assay:scene_hash", scene.hash},
                          {"assay:command", command(options, false)},
                          {"assay:shader", options.text("shader")},
                          {"assay:isa", renderer.isa()},
                          {"assay:options", decides.dump()},
                          {"assay:spp", samples},
                          {"assay:replicates", r.replicates},
                          {"assay:seed", static_cast<int>(r.seed)},
                          {"assay:depth", r.depth},
                          {"assay:rejected", static_cast<int>(std::min(film.rejected(), most_int))},
                          {"assay:partial", partial ? 1 : 0},
                          {"assay:biased", r.clamp > 0 ? 1 : 0}};
  return exr;
}

// What `action` returns; an error of it names the option.
template <typename Action>
auto naming(const char* option, const Action& action) {
  try {
    return action();
  } catch (const base::Error& error) {
    base::fail(option, ": ", error.what());
  }
}

}  // namespace

void check_writable(const Options& options) {
  const fs::path file = options.text("out");
  const auto refuse = [&](const std::string& why) {
    base::fail("--out: ", file.string(), ": cannot write: ", why);
  };
  std::error_code error;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (!fs::is_directory(folder, error)) refuse("there is no folder " + folder.string());
  const bool exists = fs::exists(file, error);
  if (fs::is_directory(file, error)) refuse("it is a folder");
  if (exists && !fs::is_regular_file(file, error)) refuse("it is not a file");
  for (const fs::path& place : {folder, exists ? file : folder})
    if (faccessat(AT_FDCWD, place.c_str(), W_OK, AT_EACCESS) != 0)
      refuse(place.string() + ": " + std::strerror(errno));
  for (const char* name : {"scene", "environment", "log", "batch"})
    if (options.has(name) && fs::equivalent(file, options.text(name), error))
      refuse(std::string("it is the file of --") + name);
}

void write_picture(const Options& options, const scene::Scene& scene, const integrator::Renderer& renderer,
                   const image::Film& film, std::span<const image::Film> parts, int samples, bool partial) {
  const std::string out = options.text("out");
  naming("--out", [&] {
    if (image::lower_extension(out) == ".exr")
      return image::write_exr(out, to_exr(options, scene, renderer, film, parts, samples, partial));
    const float gamma = options.has("gamma") ? options["gamma"].get<float>() : 0;
    image::write_display(out, film.mean_image(), {options["exposure"], gamma, options["filmic"]});
  });
}

scene::Environment read_environment(Options& options) {
  const std::string file = options.text("environment");
  return naming("--environment", [&] {
    options.environment_hash = gltf::hash(file);
    const image::Image map = image::read_environment(file);
    scene::Environment environment;
    environment.map = {fs::path(file).filename().string(), map.width, map.height, {}};
    for (const math::Vec3& p : map.pixels) environment.map.texels.push_back({p.x, p.y, p.z, 1});
    return environment;
  });
}

}  // namespace app
