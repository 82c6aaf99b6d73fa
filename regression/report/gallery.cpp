#include "report/gallery.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "image/io.h"
#include "metric/flip.h"
#include "report/html.h"

namespace report {

struct Gallery::Comparison {
  std::string ours, theirs, map;  // paths as the results have them
  std::string ours_name, theirs_name, map_name;
  bool show_ours = true;
  bool vectors = false;  // positions or normals instead of radiance
  std::string layer;     // of our file, if it is not the picture itself
  double exposure = 0, low = 0, high = 1;
};

namespace {

std::string figure_html(const std::string& name, const image::Image& encoded, const std::string& caption,
                        const std::string& attributes) {
  return "<figure><button type=\"button\" class=\"shot\"><img alt=\"\" width=\"" +
         std::to_string(encoded.width) + "\" height=\"" + std::to_string(encoded.height) + "\"" +
         attribute("data-name", name) + attributes + " src=\"" + png_uri(encoded) +
         "\"></button><figcaption>" + escape(name) +
         (caption.empty() ? "" : " <small>" + escape(caption) + "</small>") + "</figcaption></figure>\n";
}

std::string missing_html(const std::string& name, const std::string& why) {
  return "<figure><div class=\"missing\">" + escape(why) + "</div><figcaption>" + escape(name) +
         "</figcaption></figure>\n";
}

std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

}  // namespace

Gallery::Gallery(std::string build, const Json& result, Floats& floats)
    : build_(std::move(build)), result_(result), floats_(floats) {
  const Json& stored = entry(entry(entry(result, "provenance"), "golden"), "flip_exposures");
  if (stored.is_array() && stored.size() >= 2 && stored[0].is_number() && stored[1].is_number()) {
    exposure_ = (stored[0].get<double>() + stored[1].get<double>()) / 2;
    return;
  }
  const Json& images = entry(entry(result, "golden"), "images");
  for (const char* which : {"golden", "render"})
    if (const Picture& picture = load(text(images, which)); !picture.pixels.empty()) {
      exposure_ = exposure_for(picture.pixels);
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
      picture.pixels = wanted == render.layers.end() ? std::move(render.mean) : std::move(wanted->second);
      if (picture.pixels.channels != 3) picture = {{}, file + ": not three channels"};
    }
  } catch (const std::exception& error) {
    picture = {{}, error.what()};
  }
  return picture;
}

std::string Gallery::golden_html() {
  const Json& images = entry(entry(result_, "golden"), "images");
  Comparison c;
  c.ours = text(images, "render"), c.theirs = text(images, "golden"), c.map = text(images, "flip");
  c.ours_name = "ours", c.theirs_name = "golden", c.map_name = "FLIP, golden";
  c.exposure = exposure_;
  const Picture &ours = load(c.ours), &golden = load(c.theirs);
  if (!ours.pixels.empty() && ours.pixels.same_shape(golden.pixels) && ours.pixels.data == golden.pixels.data)
    return figure_html("ours = golden", shown_radiance(ours.pixels, exposure_), "the same bits",
                       attribute("data-show", "radiance") + attribute("data-exposure", exact(exposure_)) +
                           attribute("data-floats", floats_.add(ours.pixels)));
  return pair_html(c) + (ours.pixels.empty() ? "" : significance_html(ours.pixels));
}

std::string Gallery::witness_html(const Json& witness) {
  const Json& images = entry(witness, "images");
  Comparison c;
  c.theirs = text(images, "witness");
  if (c.theirs.empty()) return "";
  const std::string quantity = text(witness, "quantity"), kind = text(witness, "kind");
  c.ours = text(images, "render"), c.map = text(images, "map");
  c.theirs_name = kind == "blender" ? "Blender" : kind == "povray" ? "POV-Ray" : kind;
  if (!quantity.empty()) c.theirs_name += " " + quantity;
  c.map_name = (text(images, "map_is") == "flip" ? "FLIP, " : "error, ") + c.theirs_name;
  c.vectors = quantity == "position" || quantity == "normal";
  if (c.vectors) c.layer = quantity;
  // A picture that stands under the golden already is not shown again.
  c.show_ours = !c.ours.empty() && c.ours != text(entry(entry(result_, "golden"), "images"), "render");
  c.ours_name = c.show_ours ? "ours, " + (quantity.empty() ? kind : quantity) : "ours";
  const Picture& theirs = load(c.theirs);
  c.exposure = c.show_ours && !theirs.pixels.empty() ? exposure_for(theirs.pixels) : exposure_;
  if (c.vectors && !theirs.pixels.empty()) {
    std::vector<float> finite;
    for (const float v : theirs.pixels.data)
      if (std::isfinite(v)) finite.push_back(v);
    const auto [low, high] = std::minmax_element(finite.begin(), finite.end());
    if (!finite.empty() && *low < *high) c.low = *low, c.high = *high;
  }
  return pair_html(c);
}

std::string Gallery::pair_html(const Comparison& c) {
  const Picture &ours = load(c.ours, c.layer), &theirs = load(c.theirs);
  const auto one = [&](const std::string& name, const Picture& picture) {
    if (picture.pixels.empty()) return missing_html(name, picture.fault);
    return figure_html(
        name,
        c.vectors ? shown_vectors(picture.pixels, c.low, c.high) : shown_radiance(picture.pixels, c.exposure),
        "",
        attribute("data-show", c.vectors ? "vectors" : "radiance") +
            attribute("data-exposure", exact(c.exposure)) +
            attribute("data-floats", floats_.add(picture.pixels)));
  };
  return (c.show_ours ? one(c.ours_name, ours) : "") + one(c.theirs_name, theirs) + map_html(c) +
         difference_html(c, ours, theirs);
}

std::string Gallery::map_html(const Comparison& c) {
  if (c.map.empty()) return "";
  const Picture& map = load(c.map);
  if (map.pixels.empty()) return missing_html(c.map_name, map.fault);
  const double largest = percentile(map.pixels, 1);
  const bool is_flip = c.map_name.rfind("FLIP", 0) == 0;
  const double white = is_flip ? 1 : largest > 0 ? largest : 1;
  image::Image one(map.pixels.width, map.pixels.height, 1);
  for (std::size_t p = 0; p < one.pixels(); ++p) one.data[p] = map.pixels.data[3 * p];
  return figure_html(c.map_name, shown_map(one, white),
                     is_flip ? "0 black, 1 white" : "0 black, " + number_text(white) + " white",
                     attribute("data-show", "map") + attribute("data-floats", floats_.add(one)));
}

std::string Gallery::difference_html(const Comparison& c, const Picture& ours, const Picture& theirs) {
  if (ours.pixels.empty() || theirs.pixels.empty()) return "";
  const std::string name = c.ours_name + " − " + c.theirs_name;
  if (!ours.pixels.same_shape(theirs.pixels)) {
    const auto size = [](const image::Image& i) {
      return std::to_string(i.width) + " × " + std::to_string(i.height);
    };
    return missing_html(name, "sizes differ: " + size(ours.pixels) + ", " + size(theirs.pixels));
  }
  // The gain is the power of two that brings nearly all pixels just below full scale at the comparison's
  // exposure.
  const double scale = c.vectors ? 1 / (c.high - c.low) : std::exp2(c.exposure);
  const image::Image signed_pixels = difference(ours.pixels, theirs.pixels);
  const image::Image shown = largest_channel(signed_pixels, scale);
  double largest = percentile(shown, .99);
  if (largest == 0) largest = percentile(shown, 1);
  if (largest == 0) return "";
  const double gain = std::exp2(std::clamp(std::floor(-std::log2(largest)), 0., 40.));
  // The difference goes into the page itself: that of two half floats would mostly be their rounding.
  return figure_html(
      name, shown_signed(largest_channel(shown, gain)), "× " + number_text(gain) + ", orange more, blue less",
      attribute("data-show", c.vectors ? "vectors" : "difference") +
          attribute("data-gain", exact(scale * gain)) + attribute("data-floats", floats_.add(signed_pixels)));
}

std::string Gallery::significance_html(const image::Image& ours) const {
  // The fresh seed's test is the stronger one; the paired one is there if it decided.
  const Json& golden = entry(result_, "golden");
  const Json& tiles = entry(entry(golden, entry(golden, "welch").is_object() ? "welch" : "paired"), "tiles");
  if (!tiles.is_array() || tiles.empty()) return "";
  // Full colour where a tile alone fails a case at the suite's level of false alarms.
  constexpr double full_scale = 6.7;
  image::Image map(ours.width, ours.height, 1);
  double largest = 0;
  for (const Json& tile : tiles) {
    const double t = number(tile, "t").value_or(0);
    if (std::fabs(t) > std::fabs(largest)) largest = t;
    const auto whole = [&](const char* key, int most) {
      return static_cast<int>(std::clamp(number(tile, key).value_or(0), 0., static_cast<double>(most)));
    };
    const int x0 = whole("x", map.width), y0 = whole("y", map.height);
    const int x1 = std::min(map.width, x0 + whole("width", map.width));
    const int y1 = std::min(map.height, y0 + whole("height", map.height));
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) map.at(x, y) = static_cast<float>(t / full_scale);
  }
  return figure_html("significance", shown_signed(map), "t of tiles, largest " + number_text(largest),
                     attribute("data-show", "tiles"));
}

}  // namespace report
