#include "app/options.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <regex>

#include "app/text.h"
#include "app/version.h"
#include "base/error.h"

namespace app {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

const char* const what_it_is =
    "Renders a glTF scene with the Disney BRDF, or with --batch many of them in one process.";
const char* const epilogue =
    "A scene without a camera is framed, one without any light gets a soft sky; both are said.\n"
    "The same scene, options and seed give the same bits for any number of threads.\n"
    "\nExamples\n"
    "  assay-render model.glb -o model.png --spp 64\n"
    "  assay-render model.glb --info\n"
    "  assay-render model.glb -o model.exr --layers albedo,normal --spp 1024 --save-progress\n"
    "  assay-render model.glb -o part.exr --width 1920 --height 1080 --crop 900,400,128,128\n"
    "  assay-render model.glb -o sky.png --environment sky.hdr --filmic --exposure -0.5\n"
    "  assay-render model.glb -o report.exr --shader path_disney --d-gamma 1 --d-constant 0.005\n"
    "\nCtrl-C stops, writes the picture so far (an .exr is marked assay:partial 1) and exits with 130.\n"
    "\nExit codes\n"
    "  0    done\n"
    "  2    could not run: one line says which file or option, what was wanted, what was found\n"
    "  130  stopped by Ctrl-C (143: by SIGTERM), and the picture so far was written";

// What a value, or each part of a list, has to be: one of `names` or a number in the range; any text if there
// is neither.
struct Range {
  double least = 0, most = -1;
  bool integer = true, open = false;  // open: `least` itself is out
  bool empty() const { return most < least; }
  bool holds(double value) const {
    return value <= most && (open ? value > least : value >= least) &&
           (!integer || value == std::floor(value));
  }
};
Range integer(double least, double most) { return {least, most}; }
Range number(double least, double most) { return {least, most, false}; }
Range above(double least, double most) { return {least, most, false, true}; }

// The first four groups decide the picture; the last belongs on the command line, not in a job.
enum Group { picture, camera, samples, light, output, program };
const char* const titles[] = {"Picture", "Camera and size", "Samples", "Light", "Output", "This program"};

struct Row {
  Group group;
  std::string name;
  std::string value;  // what the help calls it, FILE if it names one, LIST or "R,G,B" a list; empty: a flag
  json standard;      // null: nothing, or what the help says
  Range range;
  Words names;
  std::string help;

  std::string wanted() const;
};

const Range side = integer(1, Options::most_side), any = {};

// One row, one option. clang-format would give each field a line.
// clang-format off
const std::vector<Row> table = {
    {picture, "scene", "FILE", {}, any, {}, "the scene, .gltf or .glb"},
    {picture, "shader", "NAME", "disney", any, {"path", "path_disney", "principled", "disney", "eyelight", "direct",
     "path-nomis", "normal", "albedo", "texcoord", "position"}, "model of the surfaces (principled: Blender's), or what to show"},
    {picture, "d-gamma", "N", 2, above(0, 10), {}, "path_disney: exponent of its distribution D"},
    {picture, "d-constant", "N", "auto", number(0, 1e6), {"auto"}, "path_disney: factor of D, normalised if auto"},
    {picture, "depth", "N", 8, integer(0, 1024), {}, "scattering events: 0 emission only, 1 direct light, 2 one bounce more"},
    {picture, "clamp", "N", 0, number(0, 1e9), {}, "limit each sample's radiance to this vector length; biased, 0 is off"},
    {picture, "fastest-isa", "", false, any, {}, "all of the CPU's vector instructions; last bits then depend on the CPU"},

    {camera, "camera", "CAMERA", {}, any, {}, "index or name of one of the file's cameras (the first)"},
    {camera, "width", "N", {}, side, {}, "pixels (from the height and the camera's aspect, 16:9 if it has none)"},
    {camera, "height", "N", {}, side, {}, "pixels (from the width, or 540)"},
    {camera, "crop", "X,Y,W,H", {}, integer(0, Options::most_side), {}, "render only these pixels of the full picture"},

    {samples, "spp", "N", 256, integer(1, 1 << 24), {}, "samples per pixel"},
    {samples, "replicates", "N", {}, integer(1, 64), {}, "independent parts of the samples, whose spread is the variance; "
     "divides the samples (the largest divisor up to 8)"},
    {samples, "adaptive", "", false, any, {}, "spend the samples where a first part of them found noise; without bias"},
    {samples, "noise", "N", {}, above(0, 10), {}, "--adaptive: as many samples as this noise of the picture, relative to its mean, takes; "
     "the first part of --spp looks"},
    {samples, "time", "N", {}, above(0, 1e9), {}, "stop after this many seconds at a whole pass; not reproducible"},
    {samples, "seed", "N", 1, integer(0, 0x7fffffff), {}, "of the random numbers"},
    {samples, "sampler", "NAME", "sobol", any, {"sobol", "random"}, "sobol is Owen-scrambled"},
    {samples, "filter", "NAME", "box", any, {"box", "triangle", "blackman-harris"}, "of a pixel"},

    {light, "environment", "FILE", {}, any, {}, "latitude-longitude .exr or .hdr in place of the scene's environment"},
    {light, "environment-color", "R,G,B", {}, number(0, 1e9), {}, "constant radiance in place of the scene's environment"},
    {light, "hide-environment", "", false, any, {}, "the camera sees black where it would see the environment"},
    {light, "punctual-units", "NAME", "auto", any, {"auto", "watt", "candela"}, "what the file's lamps are given in"},

    {output, "out", "FILE", {}, any, {}, "the picture: .exr (layers, variance, provenance), .hdr, .png, .jpg"},
    {output, "layers", "LIST", json::array(), any, {"albedo", "normal", "depth", "position", "replicates", "lobes", "samples"}, ".exr: also these; samples: how many each pixel has; lobes: direct and indirect light by lobe of the first surface"},
    {output, "exposure", "N", 0, number(-64, 64), {}, ".png, .jpg: brighter by this many stops"},
    {output, "gamma", "N", {}, number(.1, 10), {}, ".png, .jpg: display exponent (the sRGB curve)"},
    {output, "filmic", "", false, any, {}, ".png, .jpg: roll highlights off instead of cutting them"},
    {output, "save-progress", "", false, any, {}, "write the picture so far every few seconds"},
    {output, "log", "FILE", {}, any, {}, "append what happened, with times"},
    {output, "threads", "N", 0, integer(0, 1024), {}, "0 is all; the picture does not depend on it"},

    {program, "max-memory", "GB", 1, above(0, 1e6), {}, "refuse a scene that asks for more, with what is built over it"},
    {program, "batch", "FILE", {}, any, {}, R"(run the jobs of a file {"jobs": [{"scene": ..., "out": ..., "spp": 64}, ...]})"},
    {program, "info", "", false, any, {}, "say what is in the scene and what would be used; do not render"},
    {program, "json", "", false, any, {}, "results as JSON on standard output, one object a line"},
    {program, "quiet", "", false, any, {}, "say nothing but errors"},
};
// clang-format on

const Row* find(const std::string& name) {
  const auto row = std::find_if(table.begin(), table.end(), [&](const Row& r) { return r.name == name; });
  return row == table.end() ? nullptr : &*row;
}

std::string Row::wanted() const {
  if (names.empty() && range.empty()) return value.empty() ? "true or false" : value;
  std::ostringstream text;
  text.precision(10);
  if (value.find(',') != std::string::npos) text << value << ", each ";
  if (range.empty()) text << (value == "LIST" ? "a list of " : "one of ");
  text << CLI::detail::join(names, ", ") << (names.empty() || range.empty() ? "" : " or ");
  if (!range.empty())
    text << (range.integer ? "an integer in " : "a number in ") << "[("[range.open] << range.least << ", "
         << range.most << "]";
  return text.str();
}

// The value that `text` stands for; null if it is none.
json read(const Row& row, const std::string& text) {
  if (row.value.empty()) return text != "false";
  if (row.names.empty() && row.range.empty()) return text.empty() ? json() : json(text);
  json list = json::array();
  for (const std::string& part : CLI::detail::split(text, ',')) {
    double value = 0;
    const auto [stop, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (std::count(row.names.begin(), row.names.end(), part) > 0)
      list.push_back(part);
    else if (error != std::errc() || stop != part.data() + part.size() || !row.range.holds(value))
      return {};
    else if (value == std::floor(value))
      list.push_back(static_cast<std::int64_t>(value));
    else
      list.push_back(value);
  }
  if (row.value == "LIST") return list;
  if (list.size() != CLI::detail::split(row.value, ',').size()) return {};
  return list.size() == 1 ? list[0] : list;
}

void store(Options& o, const Row& row, const std::string& label, const std::string& text) {
  const json value = read(row, text);
  if (value.is_null())
    base::fail(label, ": wanted ", row.wanted(), ", found ", quoted(text), nearest(text, row.names));
  o.given[row.name] = value;
}

[[noreturn]] void no_such_option(const std::string& found, const std::string& dashes) {
  const std::string word = std::regex_replace(found, std::regex("^-+|=.*"), "");
  const std::string near = nearest(word, option_names(), "; nearest: " + dashes, "");
  base::fail("there is no option '", found, "'", near.empty() ? " (see assay-render --help)" : near);
}

// Tells CLI11 about the table.
void declare(CLI::App& parser, Options& o) {
  for (const Row& row : table) {
    const std::string label = (row.name == "scene" ? "" : "--") + row.name;
    const std::string names = (row.name == "out" ? "-o," : "") + label;
    const auto take = [&o, &row, label](const std::string& text) { store(o, row, label, text); };
    CLI::Option* option = row.value.empty()
                              ? parser.add_flag_callback(names, [take] { take(""); })->disable_flag_override()
                              : parser.add_option_function<std::string>(names, take)->type_name(row.value);
    option->group(titles[row.group]);
    if (!row.value.empty()) option->default_str(flat(row.standard));
    const bool limited = !row.names.empty() || !row.range.empty();
    option->description(wrapped(row.help + (limited ? "; " + row.wanted() : ""), 78));
  }
  parser.set_help_flag("-h,--help", "this text")->group(titles[program]);
  parser
      .set_version_flag("--version", std::string("assay-render ") + version + " (commit " + commit + ")",
                        "version and commit")
      ->group(titles[program]);
  parser.get_formatter()->column_width(30);
  parser.footer(epilogue);
  parser.allow_extras();
}

}  // namespace

const json& Options::operator[](const std::string& name) const {
  return given.contains(name) ? given.at(name) : find(name)->standard;
}

std::string Options::text(const std::string& name) const { return flat((*this)[name]); }

size_t Options::index(const std::string& name) const {
  const Words& names = find(name)->names;
  return static_cast<size_t>(std::find(names.begin(), names.end(), text(name)) - names.begin());
}

const std::string& help_of(const std::string& option) { return find(option)->help; }
const Words& choices_of(const std::string& option) { return find(option)->names; }

Words option_names() {
  Words names = {"help", "version"};
  for (const Row& row : table) names.push_back(row.name);
  return names;
}

Options parse_command_line(Words arguments) {
  Options options;
  CLI::App parser(what_it_is, "assay-render");
  declare(parser, options);
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  std::string mistake;
  try {
    parser.parse(arguments);
  } catch (const CLI::CallForHelp&) {
    options.answer = parser.help();
    return options;
  } catch (const CLI::CallForVersion& version) {
    options.answer = version.what() + std::string("\n");
    return options;
  } catch (const CLI::ArgumentMismatch& error) {  // "--name: why" or "name was given a value"
    const std::string why = error.what(), name = std::regex_replace(why, std::regex("^-+|[: ].*"), "");
    const Row& row = *find(name);
    mistake = "--" + name +
              (why.find("At Most") != std::string::npos ? ": wanted once, found twice"
               : row.value.empty()                      ? ": wanted no value, found one"
                                                        : ": wanted " + row.wanted() + ", found nothing");
  } catch (const base::Error& error) {
    mistake = error.what();
  }
  // CLI11 calls back before it reports leftovers, but the misspelt option is the better thing to hear about.
  for (const std::string& extra : parser.remaining()) {
    if (extra.starts_with("-") && extra.size() > 1) no_such_option(extra, "--");
    base::fail("one scene at a time, please: found a second one, '", extra, "'");
  }
  if (!mistake.empty()) base::fail(mistake);
  return options;
}

void apply_job(Options& options, const json& job) {
  if (!job.is_object()) base::fail("wanted an object of options, found ", job.dump());
  for (const auto& [key, value] : job.items()) {
    const Row* row = find(key);
    if (row == nullptr) no_such_option(key, "");
    if (row->group == program) base::fail(key, ": belongs on the command line, not in a job");
    const bool fits =
        row->value.empty() ? value.is_boolean() : value.is_string() || value.is_number() || value.is_array();
    if (!fits) base::fail(key, ": wanted ", row->wanted(), ", found ", value.dump());
    store(options, *row, key, flat(value));
  }
}

json decisive(const Options& o) {
  json out = {{"width", o.render.width},
              {"height", o.render.height},
              {"camera", o.render.camera},
              {"spp", o.render.spp},
              {"replicates", o.render.replicates}};
  for (const Row& row : table)
    if (row.group < output && !o[row.name].is_null()) out.emplace(row.name, o[row.name]);
  out.erase("scene");
  if (o.render.shader != integrator::Shader::path_disney) out.erase("d-gamma"), out.erase("d-constant");
  if (!o.has("environment")) return out;
  out["environment"] = std::filesystem::path(o.text("environment")).filename().string();
  out["environment_hash"] = o.environment_hash;
  return out;
}

std::string command(const Options& o, bool with_folders) {
  std::string line = "assay-render";
  for (const Row& row : table) {
    if (row.group == program || !o.has(row.name) || o[row.name] == false) continue;
    if (row.name != "scene") line += " --" + row.name;
    if (row.value.empty()) continue;
    std::string word = o.text(row.name);
    if (!with_folders && row.value == "FILE") word = std::filesystem::path(word).filename().string();
    if (word.find_first_of(" \t\n'\"\\$&;()<>|*?#`~!") != std::string::npos)
      word = "'" + std::regex_replace(word, std::regex("'"), "'\\''") + "'";
    line += " " + word;
  }
  return line;
}

}  // namespace app
