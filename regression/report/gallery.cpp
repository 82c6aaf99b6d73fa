#include "report/gallery.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "image/io.h"
#include "metric/flip.h"
#include "report/html.h"

namespace report {

struct Gallery::Comparison {
  std::string ours, theirs, map;  // paths as the results have them
  std::string group, ours_name, theirs_name, map_name;
  bool show_ours = true;
  bool vectors = false;  // positions or normals instead of radiance
  std::string layer;     // of our file, if it is not the picture itself
  double exposure = 0, low = 0, high = 1;
};

// What the page's script is told about a picture: see class Shot in pictures.js.
struct Gallery::Figure {
  std::string name, group, caption;
  const char* role;        // "ours", "theirs", "fresh", "map", "difference", "tiles"
  const char* show;        // "radiance", "vectors", "map", "difference", "tiles"
  std::string attributes;  // what `show` needs
};

namespace {

std::string missing_html(const std::string& name, const std::string& why) {
  return "<figure><div class=\"missing\">" + escape(why) + "</div><figcaption>" + escape(name) +
         "</figcaption></figure>\n";
}

std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

// Full colour where a tile alone fails a case at the suite's level of false alarms.
constexpr double full_scale_t = 6.7;

}  // namespace

// With floats the script draws the picture, without them a PNG shows it. Tiles are drawn from their numbers.
std::string Gallery::figure_html(const Figure& f, const image::Image& pixels, const image::Image& encoded) {
  const std::string size =
      " width=\"" + std::to_string(encoded.width) + "\" height=\"" + std::to_string(encoded.height) + "\"";
  const bool tiles = f.show == std::string("tiles");
  const std::string id = tiles ? "" : floats_.add(pixels, needs_floats_);
  const bool png = id.empty() && !tiles;
  return "<figure><button type=\"button\" class=\"shot\"" +
         attribute("aria-label", f.name + ", " + f.group + ": enlarge") + attribute("data-name", f.name) +
         attribute("data-group", f.group) + attribute("data-role", f.role) + attribute("data-show", f.show) +
         attribute("data-w", std::to_string(encoded.width)) +
         attribute("data-h", std::to_string(encoded.height)) + f.attributes +
         (id.empty() ? "" : attribute("data-floats", id)) + ">" +
         (png ? "<img alt=\"\"" + size + " src=\"" + png_uri(encoded) + "\">"
              : "<canvas" + size + "></canvas>") +
         "</button><figcaption>" + escape(f.name) +
         (f.caption.empty() ? "" : " <small>" + escape(f.caption) + "</small>") + "</figcaption></figure>\n";
}

Gallery::Gallery(std::string build, const CaseResult& result, Floats& floats)
    : build_(std::move(build)),
      result_(result.json),
      floats_(floats),
      needs_floats_(result.verdict() != "IDENTICAL") {
  for (const Json& w : entry(result_, "witnesses"))
    needs_floats_ |= !text(entry(w, "images"), "witness").empty();
  const Json& stored = entry(entry(entry(result_, "provenance"), "golden"), "flip_exposures");
  if (stored.is_array() && stored.size() >= 2 && stored[0].is_number() && stored[1].is_number()) {
    exposure_ = (stored[0].get<double>() + stored[1].get<double>()) / 2;
    return;
  }
  const Json& images = entry(entry(result_, "golden"), "images");
  for (const char* which : {"golden", "render"})
    if (const Picture& picture = load(text(images, which)); !picture.empty()) {
      exposure_ = exposure_for(picture.pixels.mean);
      return;
    }
}

double Gallery::exposure_for(const image::Image& image) const {
  try {
    const std::optional<metric::Exposures> e = metric::automatic_exposures(image);
    return e && std::isfinite(e->start + e->stop) ? (e->start + e->stop) / 2 : 0;
  } catch (const std::exception&) {
    return 0;
  }
}

const Gallery::Picture& Gallery::load(const std::string& path, const std::string& layer) {
  const auto [found, is_new] = pictures_.try_emplace(path + "\n" + layer);
  Picture& picture = found->second;
  if (!is_new) return picture;
  if (path.empty()) {
    picture.fault = "none";
    return picture;
  }
  const std::string file = (std::filesystem::path(build_) / path).lexically_normal().string();
  try {
    if (!std::filesystem::exists(file)) {
      picture.fault = "missing: " + file;
    } else {
      image::Render render = image::read_render(file);
      const auto wanted = render.layers.find(layer);
      if (wanted != render.layers.end()) {
        picture.pixels.mean = std::move(wanted->second);
      } else {
        picture.pixels = {std::move(render.mean), std::move(render.variance).value_or(image::Image()),
                          image::header_int(render.header, "assay:replicates").value_or(0)};
      }
      if (picture.pixels.mean.channels != 3) picture = {{}, file + ": not three channels"};
    }
  } catch (const std::exception& error) {
    picture = {{}, error.what()};
  }
  return picture;
}

std::string Gallery::picture_html(const Comparison& c, const std::string& name, const char* role,
                                  const Picture& picture) {
  if (picture.empty()) return missing_html(name, picture.fault);
  const image::Image& mean = picture.pixels.mean;
  return figure_html({name, c.group, "", role, c.vectors ? "vectors" : "radiance",
                      c.vectors ? attribute("data-low", exact(c.low)) + attribute("data-high", exact(c.high))
                                : attribute("data-exposure", exact(c.exposure))},
                     mean, c.vectors ? shown_vectors(mean, c.low, c.high) : shown_radiance(mean, c.exposure));
}

std::string Gallery::golden_html() {
  const Json& golden = entry(result_, "golden");
  const Json& images = entry(golden, "images");
  Comparison c;
  c.ours = text(images, "render"), c.theirs = text(images, "golden"), c.map = text(images, "flip");
  c.group = "golden", c.ours_name = "ours", c.theirs_name = "golden", c.map_name = "FLIP";
  c.exposure = exposure_;
  const Picture &ours = load(c.ours), &stored = load(c.theirs);
  if (!ours.empty() && ours.pixels.mean.same_shape(stored.pixels.mean) &&
      ours.pixels.mean.data == stored.pixels.mean.data)
    return figure_html({"ours = golden", "golden", "the same bits", "ours", "radiance",
                        attribute("data-exposure", exact(exposure_))},
                       ours.pixels.mean, shown_radiance(ours.pixels.mean, exposure_));
  std::string out = pair_html(c);
  // The fresh seed's test is the stronger one; the paired one is there if it decided.
  if (!ours.empty())
    out += tiles_html(entry(entry(golden, entry(golden, "welch").is_object() ? "welch" : "paired"), "tiles"),
                      c.group, ours.pixels.mean);
  if (const std::string fresh = text(images, "fresh"); !fresh.empty())
    out += picture_html(c, "ours, fresh seed", "fresh", load(fresh));
  return out;
}

Gallery::Witness Gallery::witness(const Json& witness) {
  const Json& images = entry(witness, "images");
  Comparison c;
  c.theirs = text(images, "witness");
  if (c.theirs.empty()) return {};
  const std::string quantity = text(witness, "quantity"), kind = text(witness, "kind");
  c.ours = text(images, "render"), c.map = text(images, "map");
  c.theirs_name = kind == "blender" ? "Blender" : kind == "povray" ? "POV-Ray" : kind;
  if (!quantity.empty()) c.theirs_name += " " + quantity;
  c.group = c.theirs_name;
  c.map_name = text(images, "map_is") == "flip" ? "FLIP" : "error";
  c.vectors = quantity == "position" || quantity == "normal";
  if (c.vectors) c.layer = quantity;
  // A picture that stands under the golden already is not shown again.
  c.show_ours =
      c.vectors || (!c.ours.empty() && c.ours != text(entry(entry(result_, "golden"), "images"), "render"));
  c.ours_name = c.show_ours ? "ours, " + (quantity.empty() ? kind : quantity) : "ours";
  const Picture &theirs = load(c.theirs), &ours = load(c.ours, c.layer);
  c.exposure = c.show_ours && !theirs.empty() ? exposure_for(theirs.pixels.mean) : exposure_;
  if (c.vectors && !theirs.empty()) {
    std::vector<float> finite;
    for (const float v : theirs.pixels.mean.data)
      if (std::isfinite(v)) finite.push_back(v);
    const auto [low, high] = std::minmax_element(finite.begin(), finite.end());
    if (!finite.empty() && *low < *high) c.low = *low, c.high = *high;
  }
  Witness out = {pair_html(c), std::nullopt};
  if (c.vectors || quantity == "brdf") return out;
  out.parts = parts(ours.pixels, theirs.pixels);
  Json tiles = Json::array();
  for (const TileDifference& t : tile_differences(ours.pixels, theirs.pixels))
    tiles.push_back({{"x", t.x},
                     {"y", t.y},
                     {"width", t.width},
                     {"height", t.height},
                     {"t", t.t},
                     {"relative", t.relative},
                     {"low", t.low},
                     {"high", t.high}});
  out.html += tiles_html(tiles, c.group, ours.pixels.mean);
  return out;
}

std::string Gallery::pair_html(const Comparison& c) {
  const Picture &ours = load(c.ours, c.layer), &theirs = load(c.theirs);
  return (c.show_ours ? picture_html(c, c.ours_name, "ours", ours) : "") +
         picture_html(c, c.theirs_name, "theirs", theirs) + map_html(c) + difference_html(c, ours, theirs);
}

std::string Gallery::map_html(const Comparison& c) {
  if (c.map.empty()) return "";
  const Picture& map = load(c.map);
  if (map.empty()) return missing_html(c.map_name, map.fault);
  const double largest = percentile(map.pixels.mean, 1);
  const bool is_flip = c.map_name == "FLIP";
  const double white = is_flip ? 1 : largest > 0 ? largest : 1;
  image::Image one(map.pixels.mean.width, map.pixels.mean.height, 1);
  for (std::size_t p = 0; p < one.pixels(); ++p) one.data[p] = map.pixels.mean.data[3 * p];
  return figure_html({c.map_name, c.group, "black 0, white " + number_text(white), "map", "map",
                      attribute("data-white", exact(white))},
                     one, shown_map(one, white));
}

std::string Gallery::difference_html(const Comparison& c, const Picture& ours, const Picture& theirs) {
  if (ours.empty() || theirs.empty()) return "";
  if (!ours.pixels.mean.same_shape(theirs.pixels.mean)) {
    const auto size = [](const image::Image& i) {
      return std::to_string(i.width) + " × " + std::to_string(i.height);
    };
    return missing_html("difference",
                        "sizes differ: " + size(ours.pixels.mean) + ", " + size(theirs.pixels.mean));
  }
  // The gain is the power of two that brings nearly all pixels just below full scale at the comparison's
  // exposure.
  const double scale = c.vectors ? 1 / (c.high - c.low) : std::exp2(c.exposure);
  const image::Image signed_pixels = difference(ours.pixels.mean, theirs.pixels.mean);
  const image::Image shown = largest_channel(signed_pixels, scale);
  double largest = percentile(shown, .99);
  if (largest == 0) largest = percentile(shown, 1);
  if (largest == 0) return "";
  const double gain = std::exp2(std::clamp(std::floor(-std::log2(largest)), 0., 40.));
  // The difference goes into the page itself: that of two half floats would mostly be their rounding.
  return figure_html(
      {"difference", c.group, "ours − theirs × " + number_text(gain) + ", orange more, blue less",
       "difference", "difference", attribute("data-gain", exact(scale * gain))},
      signed_pixels, shown_signed(largest_channel(shown, gain)));
}

std::string Gallery::tiles_html(const Json& tiles, const std::string& group, const image::Image& ours) {
  if (!tiles.is_array() || tiles.empty()) return "";
  Json kept = Json::array();
  double largest = 0;
  const auto whole = [](const Json& tile, const char* key, int most) {
    return static_cast<int>(std::clamp(number(tile, key).value_or(0), 0., static_cast<double>(most)));
  };
  const auto rounded = [](const std::optional<double>& value) -> Json {  // four digits are enough to read
    if (!value || !std::isfinite(*value)) return nullptr;
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.4g", *value);
    return std::strtod(digits, nullptr);
  };
  for (const Json& tile : tiles) {
    const auto t = number(tile, "t");
    if (std::fabs(t.value_or(0)) > std::fabs(largest)) largest = *t;
    kept.push_back({{"x", whole(tile, "x", ours.width)},
                    {"y", whole(tile, "y", ours.height)},
                    {"width", whole(tile, "width", ours.width)},
                    {"height", whole(tile, "height", ours.height)},
                    {"t", rounded(t)},
                    {"relative", rounded(number(tile, "relative"))},
                    {"low", rounded(number(tile, "low"))},
                    {"high", rounded(number(tile, "high"))},
                    {"significant", flag(tile, "significant")}});
  }
  return figure_html(
      {"significance", group,
       "t of tiles, largest " + number_text(largest) + ", full colour " + number_text(full_scale_t), "tiles",
       "tiles", attribute("data-full", exact(full_scale_t)) + attribute("data-tiles", kept.dump())},
      {}, image::Image(ours.width, ours.height, 1));
}

}  // namespace report
