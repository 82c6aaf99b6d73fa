// glTF materials, their extensions and the disney_* extras -> Disney's parameters (Burley 2012, section 5.1).
//
// Read from the guarded JSON and not from tinygltf's Material, whose values narrow integers to int, drop
// nulls and forget wrong types. Rules: a wrong type is an error; a finite factor out of range is clamped with
// a warning; a disney_* extra out of range or unknown is an error, because only this project's users write
// those.
#include <algorithm>
#include <cfloat>
#include <cmath>

#include "base/error.h"
#include "gltf/reader.h"

namespace gltf {
using base::fail_in;
using nlohmann::json;

namespace {

constexpr double pi = 3.14159265358979323846;

// Every parameter of the sources that are read. A `becomes` that starts with "not" is warned about when met.
struct Row {
  const char *source, *key, *becomes;
};
constexpr Row rows[] = {
    {"core", "baseColorFactor", "base_color, alpha"},
    {"core", "baseColorTexture", "base_color (sRGB), alpha"},
    {"core", "metallicFactor", "metallic"},
    {"core", "roughnessFactor", "roughness"},
    {"core", "metallicRoughnessTexture", "roughness (G), metallic (B)"},
    {"core", "normalTexture", "normal map, normal_scale"},
    {"core", "occlusionTexture", "not rendered: a path tracer finds occlusion itself"},
    {"core", "emissiveFactor", "emission, W/(sr m^2)"},
    {"core", "emissiveTexture", "emission (sRGB)"},
    {"core", "alphaMode", "alpha_mode"},
    {"core", "alphaCutoff", "alpha_cutoff"},
    {"core", "doubleSided", "double_sided; false: back faces let rays through"},
    {"KHR_materials_emissive_strength", "emissiveStrength", "factor of emission"},
    {"KHR_materials_ior", "ior",
     "specular = F0 / .08, F0 = ((ior-1)/(ior+1))^2; exact up to ior 1.789, beyond clamped to 1"},
    {"KHR_materials_specular", "specularFactor",
     "factor of specular; exact at normal incidence, glTF also scales the edge"},
    {"KHR_materials_specular", "specularColorFactor",
     "its luminance (.3, .6, .1) is a factor of specular, its hue specular_tint; exact for tints of the base "
     "colour"},
    {"KHR_materials_specular", "specularTexture", "not rendered"},
    {"KHR_materials_specular", "specularColorTexture", "not rendered"},
    {"KHR_materials_clearcoat", "clearcoatFactor",
     "clearcoat; Disney's lobe is a quarter as strong and takes nothing from the base"},
    {"KHR_materials_clearcoat", "clearcoatRoughnessFactor", "clearcoat_roughness; alpha is its square"},
    {"KHR_materials_clearcoat", "clearcoatTexture", "not rendered"},
    {"KHR_materials_clearcoat", "clearcoatRoughnessTexture", "not rendered"},
    {"KHR_materials_clearcoat", "clearcoatNormalTexture", "not rendered"},
    {"KHR_materials_sheen", "sheenColorFactor",
     "sheen = largest channel, sheen_tint = saturation; approximation"},
    {"KHR_materials_sheen", "sheenRoughnessFactor", "not rendered: Disney's sheen has none"},
    {"KHR_materials_sheen", "sheenColorTexture", "not rendered"},
    {"KHR_materials_sheen", "sheenRoughnessTexture", "not rendered"},
    {"KHR_materials_anisotropy", "anisotropyStrength",
     "anisotropic and roughness that give the same two alphas; exact up to a ratio of 10 and without a "
     "roughness texture"},
    {"KHR_materials_anisotropy", "anisotropyRotation", "anisotropic_rotation, turns"},
    {"KHR_materials_anisotropy", "anisotropyTexture", "not rendered"},
    {"KHR_texture_transform", "offset, rotation, scale, texCoord",
     "the texture's 2x3 matrix, its texcoord_set"},
    {"extras", "disney_specular", "specular"},
    {"extras", "disney_specular_tint", "specular_tint"},
    {"extras", "disney_anisotropic", "anisotropic"},
    {"extras", "disney_anisotropic_rotation", "anisotropic_rotation, turns"},
    {"extras", "disney_sheen", "sheen"},
    {"extras", "disney_sheen_tint", "sheen_tint"},
    {"extras", "disney_clearcoat", "clearcoat"},
    {"extras", "disney_clearcoat_gloss", "clearcoat_roughness = sqrt(mix(.1, .001, gloss))"},
    {"extras", "disney_clearcoat_roughness", "clearcoat_roughness; not together with the gloss"},
};

struct Extra {
  const char* key;
  float scene::Material::*parameter;
};
constexpr Extra extras_table[] = {
    {"disney_specular", &scene::Material::specular},
    {"disney_specular_tint", &scene::Material::specular_tint},
    {"disney_anisotropic", &scene::Material::anisotropic},
    {"disney_anisotropic_rotation", &scene::Material::anisotropic_rotation},
    {"disney_sheen", &scene::Material::sheen},
    {"disney_sheen_tint", &scene::Material::sheen_tint},
    {"disney_clearcoat", &scene::Material::clearcoat},
    {"disney_clearcoat_gloss", &scene::Material::clearcoat_roughness},
    {"disney_clearcoat_roughness", &scene::Material::clearcoat_roughness},
};

class Reader {
 public:
  Reader(Source& source, size_t index)
      : source_(source),
        json_(source.document.json["materials"][index]),
        place_("materials[" + std::to_string(index) + ']') {
    if (json_.contains("name") && json_["name"].is_string()) out_.name = json_["name"];
  }

  scene::Material read() {
    core();
    specular();
    clearcoat();
    sheen();
    anisotropy();
    extras();
    warn_unread();
    return out_;
  }

 private:
  void core() {
    static const json none = json::object();
    const json& pbr = json_.contains("pbrMetallicRoughness") ? json_["pbrMetallicRoughness"] : none;
    const std::string place = place_ + ".pbrMetallicRoughness";
    const std::vector<double> base = numbers(pbr, place, "baseColorFactor", {1, 1, 1, 1}, 0, 1);
    out_.base_color = {as_float(base[0]), as_float(base[1]), as_float(base[2])};
    out_.alpha = as_float(base[3]);
    out_.metallic = as_float(number(pbr, place, "metallicFactor", 1, 0, 1));
    out_.roughness = as_float(number(pbr, place, "roughnessFactor", 1, 0, 1));
    out_.base_color_texture = texture(pbr, place, "baseColorTexture");
    out_.metallic_roughness_texture = texture(pbr, place, "metallicRoughnessTexture");
    out_.normal_texture = texture(json_, place_, "normalTexture");
    out_.emissive_texture = texture(json_, place_, "emissiveTexture");
    if (json_.contains("normalTexture"))
      out_.normal_scale =
          as_float(number(json_["normalTexture"], place_ + ".normalTexture", "scale", 1, -1e6, 1e6));

    double strength = 1;
    if (const json* e = extension("KHR_materials_emissive_strength"))
      strength = number(*e, extension_place_, "emissiveStrength", 1, 0, FLT_MAX);
    const std::vector<double> emissive = numbers(json_, place_, "emissiveFactor", {0, 0, 0}, 0, FLT_MAX);
    for (int c = 0; c < 3; ++c) {
      const double radiance = emissive[static_cast<size_t>(c)] * strength;
      if (radiance > FLT_MAX)
        fail_in(source_.document.file, place_, "a radiance below 3.4e38", std::to_string(radiance));
      out_.emission[c] = as_float(radiance);
    }

    const std::string mode = json_.value("alphaMode", "OPAQUE");
    out_.alpha_mode = mode == "MASK"    ? scene::AlphaMode::mask
                      : mode == "BLEND" ? scene::AlphaMode::blend
                                        : scene::AlphaMode::opaque;
    out_.alpha_cutoff = as_float(number(json_, place_, "alphaCutoff", .5, 0, FLT_MAX));
    out_.double_sided = json_.value("doubleSided", false);
  }

  // Disney's dielectric F0 is .08 specular; glTF's is F0(ior) specularFactor specularColorFactor.
  void specular() {
    const json* ior_extension = extension("KHR_materials_ior");
    double ior = 1.5;
    if (ior_extension) {
      ior = number(*ior_extension, extension_place_, "ior", 1.5, 0, FLT_MAX);
      if (ior != 0 && ior < 1)
        fail_in(source_.document.file, extension_place_ + ".ior", "0 or at least 1", std::to_string(ior));
    }
    const double f0 = ior == 0 ? 1 : std::pow((ior - 1) / (ior + 1), 2);
    double strength = 1;
    const json* e = extension("KHR_materials_specular");
    if (!e && !ior_extension) return;
    if (e) {
      const double factor = number(*e, extension_place_, "specularFactor", 1, 0, 1);
      if (factor < 1)
        source_.warnings.add(
            "KHR_materials_specular.specularFactor is approximated: Disney's edge stays white");
      strength = factor *
                 specular_color(numbers(*e, extension_place_, "specularColorFactor", {1, 1, 1}, 0, FLT_MAX));
    }
    double specular = f0 * strength / .08;
    if (specular > 1) {
      source_.warnings.add(place_ + ": its reflectance at normal incidence, " +
                           std::to_string(f0 * strength) + ", is beyond Disney's .08: clamped");
      specular = 1;
    }
    out_.specular = as_float(specular);
  }

  // Luminance of the colour, with the weights Burley's tint uses; sets specular_tint from its hue: Disney's
  // tint t of the base colour b makes it 1 + t (b/lum(b) - 1), of which t is the least-squares solution.
  double specular_color(const std::vector<double>& color) {
    const auto luminance = [](const auto& c) { return .3 * c[0] + .6 * c[1] + .1 * c[2]; };
    const double own = luminance(color), base = luminance(out_.base_color);
    if (own <= 0 || (color[0] == color[1] && color[1] == color[2])) return own;
    double along = 0, square = 0, error = 0;
    for (int c = 0; c < 3 && base > 0; ++c) {
      const double direction = out_.base_color[c] / base - 1;
      along += direction * (color[static_cast<size_t>(c)] / own - 1);
      square += direction * direction;
    }
    const double tint = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
    for (int c = 0; c < 3; ++c) {
      const double tinted = base > 0 ? 1 + tint * (out_.base_color[c] / base - 1) : 1;
      error = std::max(error, std::fabs(color[static_cast<size_t>(c)] / own - tinted));
    }
    if (error > 1e-3 || out_.base_color_texture.bitmap >= 0)
      source_.warnings.add(
          "KHR_materials_specular.specularColorFactor is approximated by a tint of the base colour");
    out_.specular_tint = as_float(tint);
    return own;
  }

  void clearcoat() {
    const json* e = extension("KHR_materials_clearcoat");
    if (!e) return;
    out_.clearcoat = as_float(number(*e, extension_place_, "clearcoatFactor", 0, 0, 1));
    out_.clearcoat_roughness = as_float(number(*e, extension_place_, "clearcoatRoughnessFactor", 0, 0, 1));
  }

  void sheen() {
    const json* e = extension("KHR_materials_sheen");
    if (!e) return;
    const std::vector<double> color = numbers(*e, extension_place_, "sheenColorFactor", {0, 0, 0}, 0, 1);
    const auto [low, high] = std::minmax({color[0], color[1], color[2]});
    out_.sheen = as_float(high);
    out_.sheen_tint = high > 0 ? as_float(1 - low / high) : 0;
    if (high > 0) source_.warnings.add("KHR_materials_sheen is approximated by Disney's sheen");
  }

  // glTF: alpha_t = mix(alpha, 1, strength^2), alpha_b = alpha = roughness^2. Disney: alpha_x = r^2 / aspect,
  // alpha_y = r^2 aspect, aspect^2 = 1 - .9 anisotropic. Equal for aspect^2 = alpha_b / alpha_t, r^4 =
  // alpha_t alpha_b.
  void anisotropy() {
    const json* e = extension("KHR_materials_anisotropy");
    if (!e || has_extra("disney_anisotropic")) return;
    const double strength = number(*e, extension_place_, "anisotropyStrength", 0, 0, 1);
    const double rotation = number(*e, extension_place_, "anisotropyRotation", 0, -1e6, 1e6) / (2 * pi);
    if (strength <= 0) return;
    source_.warnings.add("KHR_materials_anisotropy is approximated by Disney's anisotropic");
    const double b = std::pow(static_cast<double>(out_.roughness), 2), t = b + (1 - b) * strength * strength;
    out_.anisotropic = as_float(std::min((1 - b / t) / .9, 1.0));
    out_.anisotropic_rotation = as_float(rotation - std::floor(rotation));
    if (out_.metallic_roughness_texture.bitmap < 0) out_.roughness = as_float(std::pow(t * b, .25));
  }

  void extras() {
    const json* extras = json_.contains("extras") ? &json_["extras"] : nullptr;
    if (!extras || !extras->is_object()) return;
    for (const auto& [key, value] : extras->items()) {
      if (key.rfind("disney_", 0) != 0) continue;
      const std::string place = place_ + ".extras." + key;
      const auto row = std::find_if(std::begin(extras_table), std::end(extras_table),
                                    [&](const Extra& r) { return key == r.key; });
      if (row == std::end(extras_table)) {
        std::vector<std::string> known;
        for (const Extra& r : extras_table) known.push_back(r.key);
        fail_unknown(source_.document.file, place_ + ".extras", key, known);
      }
      if (!value.is_number() || !(value.get<double>() >= 0 && value.get<double>() <= 1))
        fail_in(source_.document.file, place, "a number in [0, 1]",
                value.is_structured() ? value.type_name() : value.dump().substr(0, 60));
      const double x = value;
      const bool gloss = key == "disney_clearcoat_gloss";
      if (gloss && extras->contains("disney_clearcoat_roughness"))
        fail_in(source_.document.file, place, "either it or disney_clearcoat_roughness", "both");
      out_.*row->parameter = as_float(gloss ? std::sqrt(.1 + (.001 - .1) * x) : x);
    }
  }

  bool has_extra(const char* key) const {
    return json_.contains("extras") && json_["extras"].is_object() && json_["extras"].contains(key);
  }

  // Name what this material says and nobody renders.
  void warn_unread() {
    const auto warn = [&](const std::string& source, const std::string& key) {
      const auto row = std::find_if(std::begin(rows), std::end(rows),
                                    [&](const Row& r) { return source == r.source && key == r.key; });
      if (row != std::end(rows) && std::string_view(row->becomes).substr(0, 3) != "not") return;
      source_.warnings.add((source == "core" ? "" : source + '.') + key + " is " +
                           (row != std::end(rows) ? row->becomes : "not known: ignored"));
    };
    if (json_.contains("occlusionTexture")) warn("core", "occlusionTexture");
    for (const auto& [name, value] : list(json_, "extensions").items()) {
      const auto& supported = supported_extensions();
      if (std::find(supported.begin(), supported.end(), name) == supported.end())
        source_.warnings.add("extension " + name + " is not rendered");
      else if (value.is_object())
        for (const auto& [key, unused] : value.items())
          if (key != "extras" && key != "extensions") warn(name, key);
    }
  }

  const json* extension(const char* name) {
    const auto found = json_.find("extensions");
    if (found == json_.end() || !found->contains(name)) return nullptr;
    extension_place_ = place_ + ".extensions." + name;
    const json& value = (*found)[name];
    if (!value.is_object()) fail_in(source_.document.file, extension_place_, "an object", value.type_name());
    return &value;
  }

  double number(const json& object, const std::string& place, const char* key, double otherwise, double low,
                double high) {
    const auto found = object.find(key);
    return found == object.end() ? otherwise : clamped(*found, place + '.' + key, low, high);
  }

  std::vector<double> numbers(const json& object, const std::string& place, const char* key,
                              std::vector<double> otherwise, double low, double high) {
    const auto found = object.find(key);
    if (found == object.end()) return otherwise;
    if (!found->is_array() || found->size() != otherwise.size())
      fail_in(source_.document.file, place + '.' + key, std::to_string(otherwise.size()) + " numbers",
              found->type_name());
    for (size_t i = 0; i < otherwise.size(); ++i)
      otherwise[i] = clamped((*found)[i], place + '.' + key + '[' + std::to_string(i) + ']', low, high);
    return otherwise;
  }

  double clamped(const json& value, const std::string& place, double low, double high) {
    if (!value.is_number()) fail_in(source_.document.file, place, "a number", value.type_name());
    const double x = value, y = std::clamp(x, low, high);
    if (x != y)
      source_.warnings.add(place + " is " + value.dump() + ": clamped to " +
                           (y == low ? "its least" : "its greatest") + " value");
    return y;
  }

  static float as_float(double x) { return static_cast<float>(x); }

  scene::Texture texture(const json& object, const std::string& place, const char* key) {
    scene::Texture out;
    const auto info = object.find(key);
    if (info == object.end()) return out;
    const tinygltf::Texture& texture = source_.model.textures[(*info)["index"].get<size_t>()];
    out.texcoord_set = info->value("texCoord", 0);
    if (texture.source < 0) {
      source_.warnings.add(place + '.' + key + " has no image in a format that is read: ignored");
      return out;
    }
    out.bitmap = texture.source;
    if (texture.sampler >= 0) {
      const tinygltf::Sampler& sampler = source_.model.samplers[static_cast<size_t>(texture.sampler)];
      const auto wrap = [](int code) {
        return code == 33071 ? scene::Wrap::clamp : code == 33648 ? scene::Wrap::mirror : scene::Wrap::repeat;
      };
      out.wrap_u = wrap(sampler.wrapS);
      out.wrap_v = wrap(sampler.wrapT);
      out.filter = sampler.magFilter == 9728 ? scene::Filter::nearest : scene::Filter::linear;
    }
    transform(*info, place + '.' + key, out);
    return out;
  }

  // KHR_texture_transform: uv' = T R S uv, the rotation counter-clockwise as seen with v pointing down.
  void transform(const json& info, const std::string& place, scene::Texture& out) {
    const auto extensions = info.find("extensions");
    if (extensions == info.end() || !extensions->is_object() ||
        !extensions->contains("KHR_texture_transform"))
      return;
    const json& e = (*extensions)["KHR_texture_transform"];
    const std::string where = place + ".extensions.KHR_texture_transform";
    if (!e.is_object()) fail_in(source_.document.file, where, "an object", e.type_name());
    const std::vector<double> offset = numbers(e, where, "offset", {0, 0}, -1e6, 1e6);
    const std::vector<double> scale = numbers(e, where, "scale", {1, 1}, -1e6, 1e6);
    const double rotation = number(e, where, "rotation", 0, -1e6, 1e6);
    const double c = std::cos(rotation), s = std::sin(rotation);
    out.a = as_float(c * scale[0]), out.b = as_float(s * scale[1]), out.c = as_float(offset[0]);
    out.d = as_float(-s * scale[0]), out.e = as_float(c * scale[1]), out.f = as_float(offset[1]);
    if (!e.contains("texCoord")) return;
    const json& set = e["texCoord"];
    if (!set.is_number_integer() || set < 0 || set > 1)
      fail_in(source_.document.file, where + ".texCoord", "0 or 1",
              set.is_structured() ? set.type_name() : set.dump().substr(0, 60));
    out.texcoord_set = set;
  }

  Source& source_;
  const json& json_;
  const std::string place_;
  std::string extension_place_;  // of the extension asked for last
  scene::Material out_;
};

size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 0; i < a.size(); ++i) {
    size_t corner = row[0]++;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = corner + (a[i] != b[j]);
      corner = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

scene::Material read_material(Source& source, size_t material) { return Reader(source, material).read(); }

std::string material_table() {
  std::string out = "| source | parameter | becomes |\n|---|---|---|\n";
  for (const Row& row : rows)
    ((((((out += "| ") += row.source) += " | `") += row.key) += "` | ") += row.becomes) += " |\n";
  return out;
}

void fail_unknown(const std::string& file, const std::string& place, const std::string& key,
                  const std::vector<std::string>& known) {
  const std::string shown = key.substr(0, 60);
  const auto nearer = [&](const std::string& a, const std::string& b) {
    return edit_distance(shown, a) < edit_distance(shown, b);
  };
  fail_in(file, place, *std::min_element(known.begin(), known.end(), nearer) + ", the nearest known key",
          shown);
}

}  // namespace gltf
