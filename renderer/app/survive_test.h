// One input of any kind through everything that reads files: refused in one line, or rendered. Shared by the
// corpus's test and the fuzzer.
#pragma once

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include "app/defaults.h"
#include "base/error.h"
#include "gltf/load.h"
#include "image/decode.h"
#include "integrator/render.h"

namespace app {

// What was wrong with the input; "" if it was rendered. Ends the process if the program breaks a promise.
inline std::string survive(const std::string& bytes, const std::string& file) {
  const auto demand = [](bool holds, const std::string& what) {
    if (holds) return;
    std::fprintf(stderr, "broken promise: %s\n", what.c_str());
    std::abort();
  };
  const auto write = [&](const std::string& text) {
    std::ofstream(file, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
  };
  try {
    const auto starts = [&](const char* magic) { return bytes.rfind(magic, 0) == 0; };
    if (starts("\x89PNG") || starts("\xff\xd8")) {
      image::Limits limits;
      limits.pixels = 1 << 20;
      const image::Decoded image =
          image::decode(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), "image", limits);
      demand(image.texels.size() == static_cast<size_t>(image.width) * static_cast<size_t>(image.height),
             "an image has all its texels");
      return "";
    }
    if (starts("\x76\x2f\x31\x01") || starts("#?")) {
      const std::string map = file + (bytes[0] == '#' ? ".hdr" : ".exr");
      std::ofstream(map, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      image::Limits limits;
      limits.pixels = 1 << 20;
      for (const math::Vec3& texel : image::read_environment(map, limits).pixels)
        demand(math::is_finite(texel), "an environment is finite");
      return "";
    }
    write(bytes);
    gltf::Options options;
    options.limits.memory = 50'000'000;
    scene::Scene scene = gltf::load(file, options);
    if (scene.cameras.empty()) scene.cameras.push_back(framing_camera(scene, 1));
    if (!has_light(scene)) scene.environment = neutral_environment();
    integrator::Settings settings;
    settings.width = settings.height = 4;
    settings.spp = settings.replicates = 2;
    settings.threads = 1;
    const integrator::Renderer renderer(scene, settings);
    image::Film film = renderer.film();
    renderer.render(film, 0, settings.spp);
    demand(film.rejected() == 0, "every sample is finite and not negative");
    return "";
  } catch (const base::Error& error) {
    const std::string line = error.what();
    demand(!line.empty() && line.find('\n') == std::string::npos && line.size() < 1000,
           "an error is one short line: " + line);
    return line;
  }
}

}  // namespace app
