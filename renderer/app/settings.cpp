// From the options' values to the settings of a render, and what does not go together.
#include <algorithm>
#include <cmath>

#include "app/options.h"
#include "base/error.h"
#include "image/file.h"
#include "integrator/adaptive.h"

namespace app {

void complete_settings(Options& o) {
  if (o.text("scene").empty()) base::fail("no scene given (see assay-render --help)");
  integrator::Settings& r = o.render;
  r.shader = static_cast<integrator::Shader>(o.index("shader"));
  r.d_gamma = o["d-gamma"];
  if (o["d-constant"] != "auto") r.d_constant = o["d-constant"].get<float>();
  r.depth = o["depth"];
  r.clamp = o["clamp"];
  r.fastest_isa = o["fastest-isa"];
  r.spp = o.has("time") && !o.has("spp") ? 1 << 24 : o["spp"].get<int>();
  r.seed = o["seed"];
  r.sampler = static_cast<integrator::SamplerKind>(o.index("sampler"));
  r.filter = static_cast<integrator::Filter>(o.index("filter"));
  r.hide_environment = o["hide-environment"];
  r.threads = o["threads"];
  o.load.punctual_units = static_cast<gltf::PunctualUnits>(o.index("punctual-units"));
  o.load.limits.memory = static_cast<std::uint64_t>(o["max-memory"].get<double>() * 1e9);

  // Replicates divide the samples. Whichever was left open gives way. Adaptive sampling needs a spread within
  // the first quarter of the samples: between replicates, or two parts of few.
  const bool adaptive = o["adaptive"];
  const auto least_samples_each = [](int replicates) {
    return replicates < integrator::enough_replicates ? 8 : 4;
  };
  const auto fits = [&](int replicates) {
    return r.spp % replicates == 0 &&
           (!adaptive || r.spp >= std::max(16, least_samples_each(replicates) * replicates));
  };
  if (o.has("replicates")) {
    r.replicates = o["replicates"];
    if (!o.has("spp")) r.spp = (r.spp + r.replicates - 1) / r.replicates * r.replicates;
    if (r.spp % r.replicates != 0)
      base::fail("--replicates: wanted a divisor of --spp ", r.spp, ", found ", r.replicates);
  } else {
    for (r.replicates = 8; r.replicates > 1 && !fits(r.replicates);) --r.replicates;
    o.choices.push_back("replicates " + std::to_string(r.replicates) + ": the largest divisor of " +
                        std::to_string(r.spp) + " samples up to 8" +
                        (r.replicates == 1 ? ", so there will be no variance" : ""));
  }

  if (!fits(r.replicates))
    base::fail("--adaptive: wanted at least 16 --spp, a multiple of --replicates and at least ",
               least_samples_each(r.replicates), " times as many, found ", r.spp, " and ", r.replicates);
  if (o.has("noise") && !adaptive) base::fail("--noise: only --adaptive has it");
  if (o.has("noise") && r.replicates < 8)
    base::fail("--noise: wanted at least 8 --replicates, found ", r.replicates);
  if (o.has("noise") && o.has("time"))
    base::fail("--noise and --time both say when to stop: give one of them");

  if (o.has("environment") && o.has("environment-color"))
    base::fail("--environment and --environment-color replace the same thing: give one of them");
  for (const char* name : {"d-gamma", "d-constant"})
    if (o.has(name) && r.shader != integrator::Shader::path_disney)
      base::fail("--", name, ": only --shader path_disney has it, found --shader ", o.text("shader"));
}

void complete(Options& o) {
  complete_settings(o);
  if (o["info"]) return;
  const std::string out = o.text("out"), extension = image::lower_extension(out);
  const bool eight_bit = extension == ".png" || extension == ".jpg" || extension == ".jpeg";
  if (out.empty()) base::fail("no output given: add -o FILE.exr");
  if (!eight_bit && extension != ".exr" && extension != ".hdr")
    base::fail("--out: wanted a name ending in .exr, .hdr, .png or .jpg, found '", out, "'");
  if (extension != ".exr" && o.has("layers"))
    base::fail("--layers: only .exr holds layers, found --out ", out);
  for (const char* name : {"exposure", "gamma", "filmic"})
    if (!eight_bit && o.has(name)) base::fail("--", name, ": only .png and .jpg use it, found --out ", out);
}

void choose_size(Options& o, float camera_aspect) {
  integrator::Settings& r = o.render;
  const bool usable = camera_aspect > .01f && camera_aspect < 100;
  const double aspect = usable ? camera_aspect : 16. / 9;
  const auto rounded = [](double side) {
    return std::clamp(static_cast<int>(std::lround(side)), 1, Options::most_side);
  };
  r.height = o.has("height")  ? o["height"].get<int>()
             : o.has("width") ? rounded(o["width"].get<int>() / aspect)
                              : 540;
  r.width = o.has("width") ? o["width"].get<int>() : rounded(r.height * aspect);
  if (!o.has("width") || !o.has("height"))
    o.choices.push_back("size " + std::to_string(r.width) + " x " + std::to_string(r.height) +
                        (usable ? ", in the camera's aspect" : ", 16:9"));
  if (!o.has("crop")) return;
  const std::vector<int> crop = o["crop"];
  r.crop_x = crop[0], r.crop_y = crop[1], r.crop_width = crop[2], r.crop_height = crop[3];
  if (crop[2] == 0 || crop[3] == 0 || crop[0] + crop[2] > r.width || crop[1] + crop[3] > r.height)
    base::fail("--crop: wanted a part of the ", r.width, " x ", r.height, " picture, found ", o.text("crop"));
}

}  // namespace app
