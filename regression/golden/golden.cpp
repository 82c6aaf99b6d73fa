#include "golden/golden.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/error.h"
#include "image/hash.h"
#include "image/io.h"

namespace golden {
namespace {

namespace fs = std::filesystem;

constexpr const char* tiles_layer = "replicate_tiles";

std::string text(const image::Header& header, const std::string& file, const char* key) {
  const auto value = image::header_string(header, key);
  if (!value || value->empty()) base::fail_in(file, key, "a text in the header", "none");
  return *value;
}

// The tile means of all replicates, one after the other, as the first pixels of an image of the golden's own
// size: EXR has one size for all channels, and what is left over compresses to nothing. Absent if they do not
// fit.
std::optional<image::Image> pack(const std::vector<image::Image>& tiles, int width, int height) {
  image::Image packed(width, height, 3);
  std::size_t used = 0;
  for (const image::Image& t : tiles) {
    if (used + t.data.size() > packed.data.size()) return std::nullopt;
    std::copy(t.data.begin(), t.data.end(), packed.data.begin() + static_cast<std::ptrdiff_t>(used));
    used += t.data.size();
  }
  return packed;
}

std::vector<image::Image> unpack(const image::Image& packed, int replicates) {
  const image::Image shape = metric::tile_means(packed);
  const std::size_t each = shape.data.size();
  std::vector<image::Image> tiles;
  if (packed.channels != 3 || each * static_cast<std::size_t>(replicates) > packed.data.size()) return tiles;
  for (std::size_t r = 0; r < static_cast<std::size_t>(replicates); ++r) {
    image::Image t = shape;
    std::copy_n(packed.data.begin() + static_cast<std::ptrdiff_t>(r * each), each, t.data.begin());
    tiles.push_back(std::move(t));
  }
  return tiles;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char date[16];
  std::strftime(date, sizeof date, "%Y-%m-%d", &parts);
  return date;
}

bool blank(const std::string& s) { return s.find_first_not_of(" \t\r\n") == std::string::npos; }

// Names of *.exr in a folder, without the suffix; none if there is no folder.
std::vector<std::string> pictures(const std::string& folder) {
  std::vector<std::string> names;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".exr") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

// One paragraph of goldens/LOG.md, newest last.
std::string log_entry(const std::vector<suite::Case>& cases, const std::vector<image::Header>& headers,
                      const std::string& because) {
  std::ostringstream entry;
  entry << "\n## " << today() << "\n\n" << because << "\n\n";
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto value = [&](const char* key) {
      return image::header_string(headers[i], key).value_or("unknown");
    };
    entry << "- `" << cases[i].name << "`: pixels " << value("assay:pixel_hash").substr(0, 12) << ", case "
          << value("assay:case_hash").substr(0, 12) << ", renderer " << value("assay:version") << " at "
          << value("assay:commit") << "\n";
  }
  return entry.str();
}

constexpr const char* undo_list = "undo.json";
fs::path undo_folder(const suite::Layout& layout) { return fs::path(layout.build) / "undo"; }
std::string log_of(const suite::Layout& layout) { return layout.root + "/goldens/LOG.md"; }

std::string read_text(const std::string& file) {
  std::ostringstream text;
  if (std::ifstream stream(file, std::ios::binary); stream) text << stream.rdbuf();
  return text.str();
}

void refuse_on_ci(const char* command) {
  if (const char* ci = std::getenv("CI"); ci && *ci)
    base::fail(command, ": wanted a person, found CI=", ci,
               " in the environment: goldens are not written there");
}

}  // namespace

suite::Golden read(const std::string& file) {
  suite::Golden golden;
  golden.render = image::read_render(file);
  const image::Header& header = golden.render.header;
  golden.case_hash = text(header, file, "assay:case_hash");
  golden.pixel_hash = text(header, file, "assay:pixel_hash");
  golden.quick_hash = image::header_string(header, "assay:quick_hash").value_or("");
  const auto lobes = image::header_string(header, "assay:lobes");
  golden.knows_lobes = lobes.has_value();
  if (lobes) golden.lobes = suite::lobes_from_text(*lobes, file);
  if (!golden.render.variance) base::fail_in(file, "channels", "variance.R variance.G variance.B", "none");
  const auto exposures = image::header_floats(header, "assay:flip_exposures");
  if (!exposures || exposures->size() != 3 || !((*exposures)[2] >= 1))
    base::fail_in(file, "assay:flip_exposures", "start, stop, count", exposures ? "others" : "none");
  golden.exposures = {(*exposures)[0], (*exposures)[1], static_cast<int>((*exposures)[2])};
  const int replicates = image::header_int(header, "assay:replicates").value_or(0);
  if (replicates < 2) base::fail_in(file, "assay:replicates", "2 or more", std::to_string(replicates));
  if (const auto layer = golden.render.layers.find(tiles_layer); layer != golden.render.layers.end())
    golden.replicate_tiles = unpack(layer->second, replicates);
  return golden;
}

void write_pending(const suite::Layout& layout, const suite::Case& c, const suite::Hashes& hashes,
                   const image::Render& render, const std::optional<suite::Golden>& previous) {
  image::Render pending;
  pending.mean = render.mean;
  pending.variance = render.variance;
  pending.header = render.header;
  const std::vector<image::Image> tiles = suite::replicate_tiles(render);
  if (tiles.size() >= 2)
    if (const auto packed = pack(tiles, c.width, c.height)) pending.layers[tiles_layer] = *packed;
  // A picture without light has no exposures of its own; any will do, as long as they stay.
  const bool same_picture =
      previous && image::header_string(previous->render.header, "assay:picture_hash") == hashes.picture;
  const metric::Exposures exposures =
      same_picture ? previous->exposures
                   : metric::automatic_exposures(render.mean).value_or(metric::Exposures{0, 0, 1});
  pending.header["assay:flip_exposures"] =
      std::vector<float>{static_cast<float>(exposures.start), static_cast<float>(exposures.stop),
                         static_cast<float>(exposures.count)};
  pending.header["assay:replicates"] =
      image::header_int(render.header, "assay:replicates").value_or(c.replicates);
  pending.header["assay:case_hash"] = hashes.a_case;
  pending.header["assay:picture_hash"] = hashes.picture;
  pending.header["assay:scene_hash"] = hashes.scene;
  pending.header["assay:pixel_hash"] = image::pixel_hash(render.mean);
  image::write_exr(layout.pending_file(c.name), pending);
}

void sign(const suite::Layout& layout, const suite::Case& c, const std::string& quick_hash,
          const std::vector<suite::LobeMean>& lobes) {
  image::Render pending = image::read_render(layout.pending_file(c.name));
  pending.header["assay:quick_hash"] = quick_hash;
  pending.header["assay:lobes"] = suite::to_text(lobes);
  image::write_exr(layout.pending_file(c.name), pending);
}

std::string refusal(const suite::Layout& layout, const suite::Case& c) {
  const std::string file = layout.pending_file(c.name);
  if (!fs::exists(file)) return "no pending picture " + file + " (assay run -k " + c.name + " makes one)";
  const suite::Golden pending = read(file);
  std::string fault = suite::golden_fault(c, suite::hashes_of(layout, c), pending);
  if (fault.rfind("golden ", 0) == 0) fault = "the pending picture is " + fault.substr(7);
  return fault;
}

void accept(const suite::Layout& layout, const std::vector<suite::Case>& cases, const std::string& because) {
  refuse_on_ci("accept");
  if (blank(because)) base::fail("accept: --because: wanted the reason for the new picture, found nothing");

  // First look at all of them: one that may not be accepted leaves everything as it was.
  std::vector<image::Render> renders;
  for (const suite::Case& c : cases) {
    if (const std::string why = refusal(layout, c); !why.empty()) base::fail("accept: ", c.name, ": ", why);
    renders.push_back(image::read_render(layout.pending_file(c.name)));
  }
  // Keep what is replaced, for undo().
  const std::string log_file = log_of(layout);
  const fs::path kept = undo_folder(layout);
  fs::remove_all(kept);
  fs::create_directories(kept);
  nlohmann::json undo = {
      {"cases", nlohmann::json::array()}, {"log", read_text(log_file)}, {"had_log", fs::exists(log_file)}};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string file = layout.golden_file(cases[i].name);
    if (fs::exists(file)) fs::copy_file(file, kept / (cases[i].name + ".exr"));
    undo["cases"].push_back(
        {{"name", cases[i].name},
         {"pixel_hash", image::header_string(renders[i].header, "assay:pixel_hash").value_or("")}});
  }

  std::vector<image::Header> headers;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    renders[i].header["assay:because"] = because;
    renders[i].header["assay:accepted"] = today();
    image::write_exr(layout.golden_file(cases[i].name), renders[i]);
    headers.push_back(renders[i].header);
  }

  std::string log = undo["log"];
  if (log.empty()) log = "# Goldens: when, why and which\n\nWritten by `assay accept`, newest last.\n";
  log += log_entry(cases, headers, because);
  image::write_file(log_file, log.data(), log.size());
  undo["log_after"] = log;
  const std::string text = undo.dump();
  image::write_file((kept / undo_list).string(), text.data(), text.size());
  for (const suite::Case& c : cases) fs::remove(layout.pending_file(c.name));
}

std::vector<std::string> undo(const suite::Layout& layout) {
  refuse_on_ci("undo");
  const fs::path kept = undo_folder(layout);
  const std::string list_file = (kept / undo_list).string();
  if (!fs::exists(list_file))
    base::fail("undo: wanted an accept by this build folder, found none in ", kept.string());
  const nlohmann::json list = nlohmann::json::parse(read_text(list_file), nullptr, false);
  if (!list.is_object() || !list.contains("log_after"))
    base::fail_in(list_file, "", "what accept wrote", "something else");

  // Only what accept left may be replaced.
  std::vector<std::string> names;
  std::vector<image::Render> accepted;
  for (const nlohmann::json& entry : list.at("cases")) {
    names.push_back(entry.at("name"));
    const std::string file = layout.golden_file(names.back());
    accepted.push_back(image::read_render(file));
    if (image::header_string(accepted.back().header, "assay:pixel_hash") !=
        entry.at("pixel_hash").get<std::string>())
      base::fail_in(file, "assay:pixel_hash", "the golden that was accepted last", "another");
  }
  if (read_text(log_of(layout)) != list.at("log_after").get<std::string>())
    base::fail_in(log_of(layout), "", "the log as accept left it", "another");

  for (std::size_t i = 0; i < names.size(); ++i) {
    accepted[i].header.erase("assay:because");
    accepted[i].header.erase("assay:accepted");
    image::write_exr(layout.pending_file(names[i]), accepted[i]);
    const fs::path old = kept / (names[i] + ".exr");
    if (fs::exists(old))
      fs::rename(old, layout.golden_file(names[i]));
    else
      fs::remove(layout.golden_file(names[i]));
  }
  const std::string log = list.at("log");
  if (list.at("had_log"))
    image::write_file(log_of(layout), log.data(), log.size());
  else
    fs::remove(log_of(layout));
  fs::remove_all(kept);
  return names;
}

void reject(const suite::Layout& layout, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (!fs::exists(layout.pending_file(name)))
      base::fail_in("reject", name, "a pending picture " + layout.pending_file(name), "none");
  for (const std::string& name : names) fs::remove(layout.pending_file(name));
}

std::vector<std::string> pending_names(const suite::Layout& layout) {
  return pictures(layout.build + "/pending");
}

std::vector<std::string> orphans(const suite::Layout& layout) {
  const std::vector<std::string> names = suite::case_names(layout);
  const std::set<std::string> known(names.begin(), names.end());
  std::vector<std::string> lines;
  for (const std::string& name : pictures(layout.root + "/goldens"))
    if (!known.count(name))
      lines.push_back(layout.golden_file(name) + ": wanted a case " + name + ", found none");

  std::set<std::string> wanted;
  for (const std::string& name : names) {
    try {
      const suite::Case c = suite::read_case(layout, name);
      for (const suite::Witness& w : c.witnesses) wanted.insert(layout.witness_file(c, w));
    } catch (const base::Error&) {
      // A case that cannot be read is reported where it is judged; its pictures are no orphans of it.
      for (const char* kind : {"/blender", "/povray"})
        for (const std::string& picture : pictures(layout.reference + kind + "/renders"))
          if (picture.substr(0, picture.find('.')) == name)
            wanted.insert(layout.reference + kind + "/renders/" + picture + ".exr");
    }
  }
  for (const char* kind : {"/blender", "/povray"})
    for (const std::string& picture : pictures(layout.reference + kind + "/renders")) {
      if (picture.rfind("brdf_", 0) == 0)
        continue;  // lobes over a sphere, judged by reference/povray/brdf_test.cpp
      const std::string file = layout.reference + kind + "/renders/" + picture + ".exr";
      if (!wanted.count(file)) lines.push_back(file + ": wanted a case with this witness, found none");
    }
  return lines;
}

}  // namespace golden
