#include "app/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/parse.h"
#include "base/error.h"

namespace app {
namespace {

using integrator::Filter;
using integrator::SamplerKind;
using integrator::Shader;

// In the order of integrator::Shader.
const std::vector<std::string> shader_names = {"path",     "path_disney", "principled", "disney",
                                               "eyelight", "direct",      "path-nomis", "normal",
                                               "albedo",   "texcoord",    "position"};
constexpr int most_pixels_per_side = 32768;
constexpr int default_height = 540;
constexpr int default_spp = 256, default_replicates = 8;

float to_float(const std::string& text, double least, double most) {
  return static_cast<float>(parse_number(text, least, most));
}

void set_crop(Options& o, const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 4)
    base::fail("wanted X,Y,WIDTH,HEIGHT in pixels from the top left, found '", text, "'");
  o.render.crop_x = parse_integer(parts[0], 0, most_pixels_per_side);
  o.render.crop_y = parse_integer(parts[1], 0, most_pixels_per_side);
  o.render.crop_width = parse_integer(parts[2], 1, most_pixels_per_side);
  o.render.crop_height = parse_integer(parts[3], 1, most_pixels_per_side);
}

void set_environment_color(Options& o, const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 3) base::fail("wanted a radiance R,G,B, found '", text, "'");
  o.environment_color =
      math::Vec3{to_float(parts[0], 0, 1e9), to_float(parts[1], 0, 1e9), to_float(parts[2], 0, 1e9)};
}

void set_layers(Options& o, const std::string& text) {
  static const std::vector<std::string> names = {"albedo", "normal", "depth", "position", "replicates"};
  bool* const flags[] = {&o.layer_albedo, &o.layer_normal, &o.layer_depth, &o.layer_position,
                         &o.layer_replicates};
  for (bool* flag : flags) *flag = false;
  for (const std::string& part : split(text, ',')) *flags[parse_choice(part, names)] = true;
}

void set_d_constant(Options& o, const std::string& text) {
  o.render.d_constant.reset();
  if (text != "auto") o.render.d_constant = to_float(text, 0, 1e6);
}

void set_d_gamma(Options& o, const std::string& text) {
  const double value = parse_number(text, 0, 10);
  if (!(value > 0)) base::fail("wanted a number above 0 and up to 10, found '", text, "'");
  o.render.d_gamma = static_cast<float>(value);
}

void set_file(std::string& file, const std::string& text) {
  if (text.empty()) base::fail("wanted a file name, found nothing");
  file = text;
}

const char* const file_value = "FILE";
const char* const g_picture = "Picture";
const char* const g_camera = "Camera and size";
const char* const g_samples = "Samples";
const char* const g_light = "Light";
const char* const g_output = "Output";
const char* const g_running = "Running";

// Applies one option; the error names it.
void store(Options& o, const Row& row, const std::string& value, const std::string& dashes) {
  try {
    row.set(o, value);
  } catch (const base::Error& error) {
    base::fail(dashes, row.name, ": ", error.what());
  }
  o.given[row.name] = value;
}

std::vector<std::string> names(bool jobs_only) {
  std::vector<std::string> list;
  for (const Row& row : table())
    if (row.in_jobs || !jobs_only) list.push_back(row.name);
  return list;
}

// A job's value as the text the command line would have.
std::string text_of(const std::string& name, const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number()) return value.dump();
  if (value.is_array()) {
    std::string list;
    for (const nlohmann::json& part : value) {
      if (!part.is_string() && !part.is_number())
        base::fail(name, ": wanted a list of texts or numbers, found ", value.dump());
      list += (list.empty() ? "" : ",") + text_of(name, part);
    }
    return list;
  }
  base::fail(name, ": wanted a text, a number or a list, found ", value.dump());
}

}  // namespace

const std::vector<Row>& table() {
  using S = const std::string&;
  static const std::vector<Row> rows = {
      {"scene", "", "", file_value, "the scene, .gltf or .glb", true,
       [](Options& o, S v) { set_file(o.scene, v); }},
      {"out", "-o", g_output, file_value,
       "the picture: .exr (layers, variance, provenance), .hdr, .png, .jpg", true,
       [](Options& o, S v) { set_file(o.out, v); }},

      {"shader", "", g_picture, "NAME",
       "disney (default), principled (Blender's), path_disney, path, direct, path-nomis,\n"
       "eyelight, normal, albedo, texcoord, position",
       true, [](Options& o, S v) { o.render.shader = static_cast<Shader>(parse_choice(v, shader_names)); }},
      {"d-gamma", "", g_picture, "G", "path_disney: exponent of its distribution D, in (0, 10] (2)", true,
       set_d_gamma},
      {"d-constant", "", g_picture, "C", "path_disney: factor of D; auto (default) normalises it", true,
       set_d_constant},
      {"depth", "", g_picture, "N",
       "scattering events: 0 emission only, 1 direct light, 2 one bounce more ... (8)", true,
       [](Options& o, S v) { o.render.depth = parse_integer(v, 0, 1024); }},
      {"clamp", "", g_picture, "R",
       "limit each sample's radiance to this vector length; biased, 0 is off (0)", true,
       [](Options& o, S v) { o.render.clamp = to_float(v, 0, 1e9); }},

      {"camera", "", g_camera, "C", "index or name of one of the file's cameras (the first)", true,
       [](Options& o, S v) { set_file(o.camera, v); }},
      {"width", "", g_camera, "W", "pixels (from the height and the camera's aspect, 16:9 if it has none)",
       true, [](Options& o, S v) { o.render.width = parse_integer(v, 1, most_pixels_per_side); }},
      {"height", "", g_camera, "H", "pixels (540, or from the width)", true,
       [](Options& o, S v) { o.render.height = parse_integer(v, 1, most_pixels_per_side); }},
      {"crop", "", g_camera, "X,Y,W,H", "render only these pixels of the full picture", true, set_crop},

      {"spp", "", g_samples, "N", "samples per pixel (256)", true,
       [](Options& o, S v) { o.render.spp = parse_integer(v, 1, 1 << 24); }},
      {"replicates", "", g_samples, "K",
       "independent parts of the samples, whose spread is the variance; divides the\nsamples (the largest "
       "divisor up to 8)",
       true, [](Options& o, S v) { o.render.replicates = parse_integer(v, 1, 64); }},
      {"seed", "", g_samples, "N", "of the random numbers (1)", true,
       [](Options& o, S v) { o.render.seed = static_cast<std::uint32_t>(parse_integer(v, 0, 0x7fffffff)); }},
      {"sampler", "", g_samples, "NAME", "sobol (Owen-scrambled, default), random", true,
       [](Options& o, S v) {
         o.render.sampler = static_cast<SamplerKind>(parse_choice(v, {"sobol", "random"}));
       }},
      {"filter", "", g_samples, "NAME", "box (default), triangle, blackman-harris", true,
       [](Options& o, S v) {
         o.render.filter = static_cast<Filter>(parse_choice(v, {"box", "triangle", "blackman-harris"}));
       }},

      {"environment", "", g_light, file_value,
       "latitude-longitude .exr or .hdr in place of the scene's environment", true,
       [](Options& o, S v) { set_file(o.environment, v); }},
      {"environment-color", "", g_light, "R,G,B", "constant radiance in place of the scene's environment",
       true, set_environment_color},
      {"hide-environment", "", g_light, "", "the camera sees black where it would see the environment", true,
       [](Options& o, S) { o.render.hide_environment = true; }},
      {"punctual-units", "", g_light, "U",
       "auto (default), watt, candela: what the file's lamps are given in", true,
       [](Options& o, S v) {
         o.punctual_units = static_cast<gltf::PunctualUnits>(parse_choice(v, {"auto", "watt", "candela"}));
       }},

      {"layers", "", g_output, "LIST", ".exr: also albedo,normal,depth,position,replicates", true,
       set_layers},
      {"exposure", "", g_output, "STOPS", ".png, .jpg: brighter by this many stops (0)", true,
       [](Options& o, S v) { o.exposure = to_float(v, -64, 64); }},
      {"gamma", "", g_output, "G", ".png, .jpg: display exponent (the sRGB curve)", true,
       [](Options& o, S v) { o.gamma = to_float(v, .1, 10); }},
      {"filmic", "", g_output, "", ".png, .jpg: roll highlights off instead of cutting them", true,
       [](Options& o, S) { o.filmic = true; }},
      {"save-progress", "", g_output, "", "write the picture so far every few seconds", true,
       [](Options& o, S) { o.save_progress = true; }},
      {"log", "", g_output, file_value, "append what happened, with times", true,
       [](Options& o, S v) { set_file(o.log, v); }},

      {"threads", "", g_running, "N", "0 is all (0); the picture does not depend on it", true,
       [](Options& o, S v) { o.render.threads = parse_integer(v, 0, 1024); }},
      {"fastest-isa", "", g_running, "",
       "all of the CPU's vector instructions; last bits then depend on the CPU", true,
       [](Options& o, S) { o.render.fastest_isa = true; }},
      {"batch", "", g_running, "JOBS",
       "run the jobs of a file {\"jobs\": [{\"scene\": ..., \"out\": ..., \"spp\": 64}, ...]}", false,
       [](Options& o, S v) { set_file(o.batch, v); }},
      {"info", "", g_running, "", "say what is in the scene and what would be used; do not render", false,
       [](Options& o, S) { o.info = true; }},
      {"quiet", "", g_running, "", "say nothing but errors", false, [](Options& o, S) { o.quiet = true; }},
      {"json", "", g_running, "", "results as JSON on standard output, one object a line", false,
       [](Options& o, S) { o.json = true; }},
      {"version", "", g_running, "", "version and commit", false, [](Options& o, S) { o.version = true; }},
      {"help", "-h", g_running, "", "this text", false, [](Options& o, S) { o.help = true; }},
  };
  return rows;
}

Options parse_command_line(const std::vector<std::string>& arguments) {
  Options options;
  CLI::App parser;
  parser.set_help_flag();
  parser.allow_extras();
  for (const Row& row : table()) {
    const std::string brief = row.brief.empty() ? "" : row.brief + ",";
    if (row.name == "scene")
      parser.add_option_function<std::string>("scene",
                                              [&](const std::string& v) { store(options, row, v, ""); });
    else if (row.value.empty())
      parser.add_flag_callback(brief + "--" + row.name, [&] { store(options, row, "", "--"); });
    else
      parser.add_option_function<std::string>(brief + "--" + row.name,
                                              [&](const std::string& v) { store(options, row, v, "--"); });
  }
  // CLI11 calls back before it reports leftovers, but the misspelt option is the better thing to hear about.
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  std::optional<base::Error> value_error;
  try {
    parser.parse(reversed);
  } catch (const CLI::Error& error) {
    base::fail(error.what(), " (see assay-render --help)");
  } catch (const base::Error& error) {
    value_error = error;
  }
  for (const std::string& extra : parser.remaining()) {
    if (extra.size() < 2 || extra[0] != '-')
      base::fail("one scene at a time, please: found a second one, '", extra, "'");
    const std::string word =
        extra.substr(extra.find_first_not_of('-') == std::string::npos ? 0 : extra.find_first_not_of('-'));
    const std::string near = nearest(split(word, '=')[0], names(false));
    base::fail("there is no option '", extra, "'",
               near.empty() ? " (see assay-render --help)" : "; nearest: --" + near);
  }
  if (value_error) throw *value_error;
  return options;
}

void apply_job(Options& options, const nlohmann::json& job) {
  if (!job.is_object()) base::fail("wanted an object of options, found ", job.dump());
  for (const auto& item : job.items()) {
    const std::string& key = item.key();
    const nlohmann::json& value = item.value();
    const auto row =
        std::find_if(table().begin(), table().end(), [&](const Row& r) { return r.name == key; });
    if (row == table().end()) {
      const std::string near = nearest(key, names(true));
      base::fail("there is no option '", key, "'", near.empty() ? "" : "; nearest: " + near);
    }
    if (!row->in_jobs) base::fail(key, ": belongs on the command line, not in a job");
    if (row->value.empty()) {  // a flag
      if (!value.is_boolean()) base::fail(key, ": wanted true or false, found ", value.dump());
      if (value.get<bool>()) store(options, *row, "", "");
    } else {
      store(options, *row, text_of(key, value), "");
    }
  }
}

void complete(Options& o) {
  integrator::Settings& r = o.render;
  if (o.scene.empty()) base::fail("no scene given (see assay-render --help)");

  // Replicates divide the samples. Whichever was left open gives way.
  if (r.spp != 0 && r.replicates != 0 && r.spp % r.replicates != 0)
    base::fail("--replicates: wanted a divisor of --spp ", r.spp, ", found ", r.replicates);
  if (r.spp == 0)
    r.spp = r.replicates == 0 ? default_spp : (default_spp + r.replicates - 1) / r.replicates * r.replicates;
  if (r.replicates == 0) {
    r.replicates = default_replicates;
    while (r.spp % r.replicates != 0) --r.replicates;
    o.choices.push_back("replicates " + std::to_string(r.replicates) + ": the largest divisor of " +
                        std::to_string(r.spp) + " samples up to 8" +
                        (r.replicates == 1 ? ", so there will be no variance" : ""));
  }

  if (!o.environment.empty() && o.environment_color)
    base::fail("--environment and --environment-color replace the same thing: give one of them");
  if (r.shader != Shader::path_disney && (o.has("d-gamma") || o.has("d-constant")))
    base::fail(o.has("d-gamma") ? "--d-gamma" : "--d-constant",
               ": only --shader path_disney has it, found --shader ", shader_name(r.shader));

  if (o.info) return;
  if (o.out.empty()) base::fail("no output given: add -o FILE.exr");
  const std::string extension = extension_of(o.out);
  const bool eight_bit = extension == ".png" || extension == ".jpg" || extension == ".jpeg";
  if (!eight_bit && extension != ".exr" && extension != ".hdr")
    base::fail("--out: wanted a name ending in .exr, .hdr, .png or .jpg, found '", o.out, "'");
  if (extension != ".exr" && o.has("layers"))
    base::fail("--layers: only .exr holds layers, found --out ", o.out);
  for (const char* name : {"exposure", "gamma", "filmic"})
    if (!eight_bit && o.has(name)) base::fail("--", name, ": only .png and .jpg use it, found --out ", o.out);
}

void choose_size(Options& o, float camera_aspect) {
  integrator::Settings& r = o.render;
  const bool usable = camera_aspect > .01f && camera_aspect < 100;
  const double aspect = usable ? camera_aspect : default_aspect;
  const std::string from = usable ? ", as wide as the camera wants" : ", 16:9";
  if (r.height == 0 && r.width == 0) {
    r.height = default_height;
    r.width = static_cast<int>(std::lround(default_height * aspect));
    o.choices.push_back("size " + std::to_string(r.width) + " x 540" + from);
  } else if (r.width == 0) {
    r.width = std::clamp(static_cast<int>(std::lround(r.height * aspect)), 1, most_pixels_per_side);
    o.choices.push_back("width " + std::to_string(r.width) + from);
  } else if (r.height == 0) {
    r.height = std::clamp(static_cast<int>(std::lround(r.width / aspect)), 1, most_pixels_per_side);
    o.choices.push_back("height " + std::to_string(r.height) + from);
  }
  if (o.has("crop") && (r.crop_x + r.crop_width > r.width || r.crop_y + r.crop_height > r.height))
    base::fail("--crop: wanted a part of the ", r.width, " x ", r.height, " picture, found ",
               o.given.at("crop"));
}

std::string command(const Options& options, bool with_folders) {
  const auto shown = [&](const Row& row) {
    std::string text = options.given.at(row.name);
    if (!with_folders && row.value == file_value) text = std::filesystem::path(text).filename().string();
    if (text.find_first_of(" \t\n'\"\\$&;()<>|*?#`~!") == std::string::npos) return text;
    std::string quoted = "'";
    for (char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
  };
  std::string text = "assay-render";
  for (const Row& row : table()) {
    if (!row.in_jobs || !options.has(row.name)) continue;
    if (row.name != "scene") text += " --" + row.name;
    if (!row.value.empty()) text += " " + shown(row);
  }
  return text;
}

std::string shader_name(Shader shader) { return shader_names[static_cast<size_t>(shader)]; }

std::string help() {
  std::string text =
      "assay-render SCENE -o FILE [options]      render a glTF scene (.gltf, .glb)\n"
      "assay-render SCENE --info                 what is in it and what would be used\n"
      "assay-render --batch JOBS [options]       many renders in one process; options hold for every job\n";
  for (const char* group : {g_picture, g_camera, g_samples, g_light, g_output, g_running}) {
    text += "\n" + std::string(group) + "\n";
    for (const Row& row : table()) {
      if (row.group != group) continue;
      std::string left = "  " + (row.brief.empty() ? "" : row.brief + ", ") + "--" + row.name;
      if (!row.value.empty()) left += " " + row.value;
      left.resize(std::max<size_t>(left.size() + 2, 30), ' ');
      for (const std::string& line : split(row.help, '\n')) {
        text += left + line + "\n";
        left.assign(30, ' ');
      }
    }
  }
  text +=
      "\nA scene without a camera is framed, one without any light gets a soft sky; both are said.\n"
      "The same scene, options and seed give the same bits for any number of threads.\n"
      "\nExamples\n"
      "  assay-render model.glb -o model.png --spp 64\n"
      "  assay-render model.glb -o model.exr --layers albedo,normal --spp 1024 --save-progress\n"
      "  assay-render model.glb -o part.exr --width 1920 --height 1080 --crop 900,400,128,128\n"
      "  assay-render model.glb -o sky.png --environment sky.hdr --filmic --exposure -0.5\n"
      "  assay-render model.glb -o report.exr --shader path_disney --d-gamma 1 --d-constant 0.005\n"
      "\nCtrl-C stops, writes the picture so far (an .exr is marked assay:partial 1) and exits with 130.\n"
      "\nExit codes\n"
      "  0    done\n"
      "  2    could not run: one line says which file or option, what was wanted, what was found\n"
      "  130  stopped by Ctrl-C (143: by SIGTERM), and the picture so far was written\n";
  return text;
}

}  // namespace app
