// glTF materials, their extensions and the disney_* extras -> Disney's parameters (Burley 2012, section 5.1).
//
// Read from the guarded JSON and not from tinygltf's Material: schema.json has checked, clamped and completed
// it, so every member with a default is there and has its type. What is mapped how, is written there too.
#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>

#include "gltf/parameters.h"
#include "gltf/reader.h"

namespace gltf {
using nlohmann::json;

namespace {

using Color = std::array<double, 3>;

float as_float(double x) { return static_cast<float>(x); }

class Reader {
 public:
  Reader(Source& source, size_t index)
      : source_(source),
        own_(source.document.materials[index]),
        extensions_(own_["extensions"]),
        place_(at("materials", index)) {
    out_.name = name_of(own_);
  }

  scene::Material read() {
    core();
    specular();
    clearcoat();
    sheen();
    anisotropy();
    extras();
    return out_;
  }

 private:
  void core() {
    const json& pbr = own_["pbrMetallicRoughness"];
    const auto base = pbr["baseColorFactor"].get<std::array<double, 4>>();
    out_.base_color = {as_float(base[0]), as_float(base[1]), as_float(base[2])};
    out_.alpha = as_float(base[3]);
    out_.metallic = pbr["metallicFactor"];
    out_.roughness = pbr["roughnessFactor"];
    out_.base_color_texture = read_texture(source_, pbr, "baseColorTexture");
    out_.metallic_roughness_texture = read_texture(source_, pbr, "metallicRoughnessTexture");
    out_.normal_texture = read_texture(source_, own_, "normalTexture");
    if (own_.contains("normalTexture")) out_.normal_scale = own_["normalTexture"]["scale"];
    out_.emissive_texture = read_texture(source_, own_, "emissiveTexture");
    for (size_t c = 0; c < 3; ++c) {
      const double radiance =
          own_["emissiveFactor"][c].get<double>() *
          extensions_["KHR_materials_emissive_strength"]["emissiveStrength"].get<double>();
      source_.document.want(radiance <= FLT_MAX, place_, "a radiance below 3.4e38", radiance);
      out_.emission[static_cast<int>(c)] = as_float(radiance);
    }
    if (own_["alphaMode"] == "MASK") out_.alpha_mode = scene::AlphaMode::mask;
    if (own_["alphaMode"] == "BLEND") out_.alpha_mode = scene::AlphaMode::blend;
    out_.alpha_cutoff = own_["alphaCutoff"];
    out_.double_sided = own_["doubleSided"];
  }

  // Disney's dielectric F0 is .08 specular; glTF's is F0(ior) specularFactor specularColorFactor.
  void specular() {
    const json& e = extensions_["KHR_materials_specular"];
    const double ior = extensions_["KHR_materials_ior"]["ior"], factor = e["specularFactor"];
    source_.document.want(ior == 0 || ior >= 1, place_ + ".extensions.KHR_materials_ior.ior",
                          "0 or at least 1", ior);
    if (factor < 1)
      source_.warnings.add(
          "KHR_materials_specular.specularFactor is approximated: Disney's edge stays white");
    const double f0 = (ior == 0 ? 1 : std::pow((ior - 1) / (ior + 1), 2)) * factor *
                      specular_color(e["specularColorFactor"]);
    if (f0 > .08)
      source_.warnings.add(place_ + ": its reflectance at normal incidence, " + std::to_string(f0) +
                           ", is beyond Disney's .08: clamped");
    out_.specular = as_float(std::min(f0 / .08, 1.0));
  }

  // Luminance of the colour, with the weights Burley's tint uses; sets specular_tint from its hue: Disney's
  // tint t of the base colour b makes it 1 + t (b/lum(b) - 1), of which t is the least-squares solution.
  double specular_color(const Color& color) {
    const auto luminance = [](const auto& c) { return .3 * c[0] + .6 * c[1] + .1 * c[2]; };
    const double own = luminance(color), base = luminance(out_.base_color);
    if (own <= 0 || (color[0] == color[1] && color[1] == color[2])) return own;
    Color direction{}, wanted{};
    double along = 0, square = 0, error = 0;
    for (size_t c = 0; c < 3; ++c) {
      if (base > 0) direction[c] = out_.base_color[static_cast<int>(c)] / base - 1;
      wanted[c] = color[c] / own - 1;
      along += direction[c] * wanted[c];
      square += direction[c] * direction[c];
    }
    const double tint = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
    for (size_t c = 0; c < 3; ++c) error = std::max(error, std::fabs(wanted[c] - tint * direction[c]));
    if (error > 1e-3 || out_.base_color_texture.bitmap >= 0)
      source_.warnings.add(
          "KHR_materials_specular.specularColorFactor is approximated by a tint of the base colour");
    out_.specular_tint = as_float(tint);
    return own;
  }

  void clearcoat() {
    const json& e = list(extensions_, "KHR_materials_clearcoat");
    if (e.empty()) return;  // its roughness then stays Disney's
    out_.clearcoat = e["clearcoatFactor"];
    out_.clearcoat_roughness = e["clearcoatRoughnessFactor"];
  }

  void sheen() {
    const Color color = extensions_["KHR_materials_sheen"]["sheenColorFactor"];
    const auto [low, high] = std::minmax({color[0], color[1], color[2]});
    if (high <= 0) return;
    source_.warnings.add("KHR_materials_sheen is approximated by Disney's sheen");
    out_.sheen = as_float(high);
    out_.sheen_tint = as_float(1 - low / high);
  }

  // glTF: alpha_t = mix(alpha, 1, strength^2), alpha_b = alpha = roughness^2. Disney: alpha_x = r^2 / aspect,
  // alpha_y = r^2 aspect, aspect^2 = 1 - .9 anisotropic. Equal for aspect^2 = alpha_b / alpha_t, r^4 =
  // alpha_t alpha_b.
  void anisotropy() {
    const json& e = extensions_["KHR_materials_anisotropy"];
    const double strength = e["anisotropyStrength"];
    const double turns = e["anisotropyRotation"].get<double>() / (2 * 3.14159265358979323846);
    if (strength <= 0 || list(own_, "extras").contains("disney_anisotropic")) return;
    source_.warnings.add("KHR_materials_anisotropy is approximated by Disney's anisotropic");
    const double b = std::pow(static_cast<double>(out_.roughness), 2), t = b + (1 - b) * strength * strength;
    out_.anisotropic = as_float(std::min((1 - b / t) / .9, 1.0));
    out_.anisotropic_rotation = as_float(turns - std::floor(turns));
    if (out_.metallic_roughness_texture.bitmap < 0) out_.roughness = as_float(std::pow(t * b, .25));
  }

  void extras() {
    const json& extras = list(own_, "extras");
    for (const auto& [name, member] : disney_parameters)
      if (const json& value = list(extras, std::string("disney_") + name); value.is_number())
        out_.*member = value;
    if (extras.contains("disney_clearcoat_gloss"))
      out_.clearcoat_roughness =
          as_float(std::sqrt(.1 + (.001 - .1) * extras["disney_clearcoat_gloss"].get<double>()));
  }

  Source& source_;
  const json &own_, &extensions_;
  const std::string place_;
  scene::Material out_;
};

}  // namespace

scene::Material read_material(Source& source, size_t material) { return Reader(source, material).read(); }

}  // namespace gltf
