#include "blender/soup.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

namespace blender {

namespace {

using bsdf::Lobe;
using math::Vec3;

double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3d sum(const Vec3d& a, double s, const Vec3d& b, double t) {
  return {a[0] * s + b[0] * t, a[1] * s + b[1] * t, a[2] * s + b[2] * t};
}
Vec3d unit(const Vec3d& a) { return sum(a, 1 / std::sqrt(dot(a, a)), a, 0); }
Vec3 rounded(const Vec3d& a) {
  return {static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])};
}
Vec3d widened(const Vec3& a) { return {a.x, a.y, a.z}; }

// Cycles' frame: the tangent made orthogonal to the normal, then turned counter-clockwise about it.
class Frame {
 public:
  Frame(const Vec3d& normal, const Vec3d& tangent, double turns) : z_(unit(normal)) {
    const Vec3d y = unit(cross(z_, tangent)), x = cross(y, z_);
    const double c = std::cos(2 * bsdf::pi * turns), s = std::sin(2 * bsdf::pi * turns);
    x_ = sum(x, c, y, s);
    y_ = sum(y, c, x, -s);
  }
  Vec3 to_local(const Vec3d& w) const {
    const Vec3d u = unit(w);
    return rounded({dot(u, x_), dot(u, y_), dot(u, z_)});
  }

 private:
  Vec3d x_, y_, z_;
};

// alpha^2 of Smith's G1 along w.
double alpha2_along(const Vec3& w, double ax, double ay) {
  const double x = double{w.x} * w.x, y = double{w.y} * w.y;
  return x + y > 0 ? (x * ax * ax + y * ay * ay) / (x + y) : ax * ay;
}

}  // namespace

Soup read_soup(const std::string& path) {
  const auto file = OIIO::ImageInput::open(path);
  if (!file)
    throw std::runtime_error(path + ": wanted the triangle soup; reference/blender/soup/soup.py makes it");
  const OIIO::ImageSpec& spec = file->spec();
  const auto pixel_count = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  const auto channel_count = static_cast<std::size_t>(spec.nchannels);
  std::vector<float> pixels(pixel_count * channel_count);
  if (!file->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()))
    throw std::runtime_error(path + ": " + file->geterror());
  std::map<std::string, std::size_t> channel;
  for (std::size_t c = 0; c < channel_count; ++c) channel[spec.channelnames[c]] = c;

  Soup soup;
  soup.witness = spec.get_string_attribute("assay:witness");
  soup.script_hash = spec.get_string_attribute("assay:script_hash");
  std::istringstream names(spec.get_string_attribute("assay:subsets"));
  for (std::string name; std::getline(names, name, ';');) soup.subsets.push_back(name);
  for (std::size_t i = 0; i < pixel_count; ++i) {
    const auto number = [&](const std::string& name) {
      const auto found = channel.find(name);
      if (found == channel.end()) throw std::runtime_error(path + ": wanted a channel " + name);
      return pixels[i * channel_count + found->second];
    };
    const auto vector = [&](const std::string& name) {
      return Vec3d{number(name + ".X"), number(name + ".Y"), number(name + ".Z")};
    };
    Configuration c;
    c.wo = vector("wo");
    c.wi = vector("wi");
    c.normal = vector("normal");
    c.geometric = vector("geometric");
    if (c.geometric == Vec3d{}) c.geometric = c.normal;
    c.tangent = vector("tangent");
    c.blender = {number("R"), number("G"), number("B")};
    c.subset = static_cast<int>(number("subset"));
    c.turns = number("anisotropic_rotation");
    bsdf::Parameters& p = c.parameters;
    p.base_color = rounded(vector("base"));
    p.metallic = number("metallic");
    p.roughness = number("roughness");
    p.specular = number("specular");
    p.specular_tint = number("specular_tint");
    p.anisotropic = number("anisotropic");
    p.sheen = number("sheen");
    p.sheen_tint = number("sheen_tint");
    p.clearcoat = number("clearcoat");
    p.clearcoat_roughness = number("clearcoat_roughness");
    if (c.subset < 0 || c.subset >= static_cast<int>(soup.subsets.size()))
      throw std::runtime_error(path + ": subset: wanted an index into assay:subsets");
    soup.configurations.push_back(c);
  }
  return soup;
}

double Answer::total(int k) const {
  const auto i = static_cast<std::size_t>(k);
  return diffuse[i] + specular[i] + clearcoat[i];
}

double Answer::off(int k, double epsilon) const {
  const auto i = static_cast<std::size_t>(k);
  double value = diffuse[i];
  if (specular[i] > 0) {
    const double s = specular_s + epsilon * specular_error;
    if (s <= 0) return std::numeric_limits<double>::infinity();
    value += specular[i] * (specular_s / s) * (specular_s / s);
  }
  if (clearcoat[i] > 0) {
    const double s = clearcoat_s + epsilon;
    if (s <= 0) return std::numeric_limits<double>::infinity();
    value += clearcoat[i] * clearcoat_s / s;
  }
  return value;
}

Answer ask(const Configuration& configuration, bsdf::Model model, const Fault& fault) {
  bsdf::Parameters p = configuration.parameters;
  double turns = configuration.turns;
  if (fault.parameters) fault.parameters(p, turns);
  const Frame frame(configuration.normal, configuration.tangent, turns);
  const Vec3 wo = frame.to_local(configuration.wo), wi = frame.to_local(configuration.wi);
  bsdf::Normals normals;
  if (configuration.geometric != configuration.normal)
    normals.smooth = normals.geometric = frame.to_local(configuration.geometric);
  bsdf::Bsdf all = bsdf::prepare(model, {}, p, normals, wo);
  if (fault.lobes) fault.lobes(all, p);

  // One lobe at a time: the others are never chosen, hence silent.
  const auto alone = [&](Lobe lobe) {
    bsdf::Bsdf one = all;
    for (int i = 0; i < bsdf::lobe_count; ++i)
      if (i != static_cast<int>(lobe)) one.probability[i] = 0;
    return widened(bsdf::eval(one, wo, wi).f_cos);
  };
  Answer a;
  a.diffuse = alone(Lobe::diffuse);
  a.specular = alone(Lobe::specular);
  a.clearcoat = alone(Lobe::clearcoat);

  // ax ay q of Specular's D; the isotropic one, alpha^2 q, is sin^2 + alpha^2 cos^2.
  const bsdf::HalfVector h(wo, wi);
  const double ax = all.specular.ax, ay = all.specular.ay, ac = all.clearcoat.alpha;
  const double length = std::sqrt(h.length_squared);
  const double x = h.x / length / ax, y = h.y / length / ay;
  a.specular_s = ax * ay * (x * x + y * y + h.cos2_h());
  a.specular_error = ax == ay ? 1 : std::max(ax / ay, ay / ax);
  a.clearcoat_s = h.sin2_h() + ac * ac * h.cos2_h();
  if (fault.masking) {
    a.specular =
        sum(a.specular, fault.masking(wo.z, wi.z, alpha2_along(wo, ax, ay), alpha2_along(wi, ax, ay)), {}, 0);
    a.clearcoat = sum(a.clearcoat, fault.masking(wo.z, wi.z, .0625, .0625), {}, 0);
  }
  return a;
}

}  // namespace blender
