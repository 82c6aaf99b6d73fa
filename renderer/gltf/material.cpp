// glTF materials, their extensions and the disney_* extras -> Disney's parameters (Burley 2012, section 5.1).
//
// Read from the guarded JSON and not from tinygltf's Material, whose values narrow integers to int, drop
// nulls and forget wrong types. Rules: a wrong type is an error; a finite factor out of range is clamped with
// a warning; a disney_* extra out of range or unknown is an error, because only this project's users write
// those.
#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>

#include "base/error.h"
#include "gltf/reader.h"

namespace gltf {
using base::fail_in;
using nlohmann::json;

namespace {

// Every parameter of the sources that are read. A `becomes` that starts with "not" is warned about when met.
struct Row {
  const char *source, *key, *becomes;
  float scene::Material::*parameter = nullptr;  // what a disney_* key sets
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
    {"extras", "disney_specular", "specular", &scene::Material::specular},
    {"extras", "disney_specular_tint", "specular_tint", &scene::Material::specular_tint},
    {"extras", "disney_anisotropic", "anisotropic", &scene::Material::anisotropic},
    {"extras", "disney_anisotropic_rotation", "anisotropic_rotation, turns",
     &scene::Material::anisotropic_rotation},
    {"extras", "disney_sheen", "sheen", &scene::Material::sheen},
    {"extras", "disney_sheen_tint", "sheen_tint", &scene::Material::sheen_tint},
    {"extras", "disney_clearcoat", "clearcoat", &scene::Material::clearcoat},
    {"extras", "disney_clearcoat_gloss", "clearcoat_roughness = sqrt(mix(.1, .001, gloss))",
     &scene::Material::clearcoat_roughness},
    {"extras", "disney_clearcoat_roughness", "clearcoat_roughness; not together with the gloss",
     &scene::Material::clearcoat_roughness},
};

// A JSON object and where it stands in the file.
struct Object {
  const json* value = nullptr;
  std::string place;
  explicit operator bool() const { return value != nullptr; }
};

float as_float(double x) { return static_cast<float>(x); }

class Reader {
 public:
  Reader(Source& source, size_t index)
      : source_(source),
        own_{&source.document.json["materials"][index], "materials[" + std::to_string(index) + ']'} {}

  scene::Material read() {
    if (own_.value->contains("name") && (*own_.value)["name"].is_string()) out_.name = (*own_.value)["name"];
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
    const Object pbr = member(own_, "pbrMetallicRoughness");
    const auto base = numbers<4>(pbr, "baseColorFactor", {1, 1, 1, 1}, 0, 1);
    out_.base_color = {as_float(base[0]), as_float(base[1]), as_float(base[2])};
    out_.alpha = as_float(base[3]);
    out_.metallic = as_float(number(pbr, "metallicFactor", 1, 0, 1));
    out_.roughness = as_float(number(pbr, "roughnessFactor", 1, 0, 1));
    out_.base_color_texture = texture(pbr, "baseColorTexture");
    out_.metallic_roughness_texture = texture(pbr, "metallicRoughnessTexture");
    out_.normal_texture = texture(own_, "normalTexture");
    out_.normal_scale = as_float(number(member(own_, "normalTexture"), "scale", 1, -1e6, 1e6));
    out_.emissive_texture = texture(own_, "emissiveTexture");

    const double strength =
        number(extension("KHR_materials_emissive_strength"), "emissiveStrength", 1, 0, FLT_MAX);
    const auto emissive = numbers<3>(own_, "emissiveFactor", {0, 0, 0}, 0, FLT_MAX);
    for (int c = 0; c < 3; ++c) {
      const double radiance = emissive[static_cast<size_t>(c)] * strength;
      if (radiance > FLT_MAX)
        fail_in(source_.document.file, own_.place, "a radiance below 3.4e38", std::to_string(radiance));
      out_.emission[c] = as_float(radiance);
    }

    const std::string mode = own_.value->value("alphaMode", "OPAQUE");
    if (mode == "MASK") out_.alpha_mode = scene::AlphaMode::mask;
    if (mode == "BLEND") out_.alpha_mode = scene::AlphaMode::blend;
    out_.alpha_cutoff = as_float(number(own_, "alphaCutoff", .5, 0, FLT_MAX));
    out_.double_sided = own_.value->value("doubleSided", false);
  }

  // Disney's dielectric F0 is .08 specular; glTF's is F0(ior) specularFactor specularColorFactor.
  void specular() {
    const Object ior_extension = extension("KHR_materials_ior"), e = extension("KHR_materials_specular");
    if (!e && !ior_extension) return;
    const double ior = number(ior_extension, "ior", 1.5, 0, FLT_MAX);
    if (ior != 0 && ior < 1)
      fail_in(source_.document.file, ior_extension.place + ".ior", "0 or at least 1", std::to_string(ior));
    const double factor = number(e, "specularFactor", 1, 0, 1);
    if (factor < 1)
      source_.warnings.add(
          "KHR_materials_specular.specularFactor is approximated: Disney's edge stays white");
    const double f0 = (ior == 0 ? 1 : std::pow((ior - 1) / (ior + 1), 2)) * factor *
                      specular_color(numbers<3>(e, "specularColorFactor", {1, 1, 1}, 0, FLT_MAX));
    if (f0 > .08)
      source_.warnings.add(own_.place + ": its reflectance at normal incidence, " + std::to_string(f0) +
                           ", is beyond Disney's .08: clamped");
    out_.specular = as_float(std::min(f0 / .08, 1.0));
  }

  // Luminance of the colour, with the weights Burley's tint uses; sets specular_tint from its hue: Disney's
  // tint t of the base colour b makes it 1 + t (b/lum(b) - 1), of which t is the least-squares solution.
  double specular_color(const std::array<double, 3>& color) {
    const auto luminance = [](const auto& c) { return .3 * c[0] + .6 * c[1] + .1 * c[2]; };
    const double own = luminance(color), base = luminance(out_.base_color);
    if (own <= 0 || (color[0] == color[1] && color[1] == color[2])) return own;
    double direction[3] = {}, wanted[3], along = 0, square = 0, error = 0;
    for (int c = 0; c < 3; ++c) {
      if (base > 0) direction[c] = out_.base_color[c] / base - 1;
      wanted[c] = color[static_cast<size_t>(c)] / own - 1;
      along += direction[c] * wanted[c];
      square += direction[c] * direction[c];
    }
    const double tint = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
    for (int c = 0; c < 3; ++c) error = std::max(error, std::fabs(wanted[c] - tint * direction[c]));
    if (error > 1e-3 || out_.base_color_texture.bitmap >= 0)
      source_.warnings.add(
          "KHR_materials_specular.specularColorFactor is approximated by a tint of the base colour");
    out_.specular_tint = as_float(tint);
    return own;
  }

  void clearcoat() {
    const Object e = extension("KHR_materials_clearcoat");
    if (!e) return;
    out_.clearcoat = as_float(number(e, "clearcoatFactor", 0, 0, 1));
    out_.clearcoat_roughness = as_float(number(e, "clearcoatRoughnessFactor", 0, 0, 1));
  }

  void sheen() {
    const auto color = numbers<3>(extension("KHR_materials_sheen"), "sheenColorFactor", {0, 0, 0}, 0, 1);
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
    const Object e = extension("KHR_materials_anisotropy");
    const double strength = number(e, "anisotropyStrength", 0, 0, 1);
    const double turns = number(e, "anisotropyRotation", 0, -1e6, 1e6) / (2 * 3.14159265358979323846);
    if (strength <= 0 || list(*own_.value, "extras").contains("disney_anisotropic")) return;
    source_.warnings.add("KHR_materials_anisotropy is approximated by Disney's anisotropic");
    const double b = std::pow(static_cast<double>(out_.roughness), 2), t = b + (1 - b) * strength * strength;
    out_.anisotropic = as_float(std::min((1 - b / t) / .9, 1.0));
    out_.anisotropic_rotation = as_float(turns - std::floor(turns));
    if (out_.metallic_roughness_texture.bitmap < 0) out_.roughness = as_float(std::pow(t * b, .25));
  }

  void extras() {
    const json& extras = list(*own_.value, "extras");
    const std::string place = own_.place + ".extras";
    if (!extras.is_object()) return;
    if (extras.contains("disney_clearcoat_gloss") && extras.contains("disney_clearcoat_roughness"))
      fail_in(source_.document.file, place, "disney_clearcoat_gloss or disney_clearcoat_roughness", "both");
    for (const auto& [key, value] : extras.items()) {
      if (key.rfind("disney_", 0) != 0) continue;
      std::vector<std::string> known;
      float scene::Material::*parameter = nullptr;
      for (const Row& row : rows) {
        if (row.parameter) known.push_back(row.key);
        if (key == row.key) parameter = row.parameter;
      }
      if (!parameter) fail_unknown(source_.document.file, place, key, known);
      const double x = value.is_number() ? value.get<double>() : -1;
      if (!(x >= 0 && x <= 1))
        fail_in(source_.document.file, place + '.' + key, "a number in [0, 1]", shown(value));
      out_.*parameter = as_float(key == "disney_clearcoat_gloss" ? std::sqrt(.1 + (.001 - .1) * x) : x);
    }
  }

  // Name what this material says and nobody renders.
  void warn_unread() {
    const auto& supported = supported_extensions();
    if (own_.value->contains("occlusionTexture")) warn_unread("core", "occlusionTexture");
    for (const auto& [name, value] : list(*own_.value, "extensions").items())
      if (std::find(supported.begin(), supported.end(), name) == supported.end())
        source_.warnings.add("extension " + name + " is not rendered");
      else
        for (const auto& [key, unused] : value.items()) warn_unread(name, key);
  }
  void warn_unread(const std::string& source, const std::string& key) {
    std::string_view becomes = "not known: ignored";
    for (const Row& row : rows)
      if (source == row.source && key == row.key) becomes = row.becomes;
    if (becomes.substr(0, 3) == "not")
      source_.warnings.add(source + '.' + key + " is " + std::string(becomes));
  }

  // Member `key`, an object if it is there.
  Object member(const Object& object, const std::string& key) const {
    Object out{nullptr, object.place + '.' + key};
    if (!object || !object.value->contains(key)) return out;
    out.value = &(*object.value)[key];
    if (!out.value->is_object()) fail_in(source_.document.file, out.place, "an object", shown(*out.value));
    return out;
  }
  Object extension(const char* name) const { return member(member(own_, "extensions"), name); }

  double number(const Object& object, const char* key, double otherwise, double low, double high) {
    return object && object.value->contains(key)
               ? clamped((*object.value)[key], object.place + '.' + key, low, high)
               : otherwise;
  }

  template <size_t n>
  std::array<double, n> numbers(const Object& object, const char* key, std::array<double, n> out, double low,
                                double high) {
    if (!object || !object.value->contains(key)) return out;
    const json& value = (*object.value)[key];
    const std::string place = object.place + '.' + key;
    if (!value.is_array() || value.size() != n)
      fail_in(source_.document.file, place, std::to_string(n) + " numbers", shown(value));
    for (size_t i = 0; i < n; ++i)
      out[i] = clamped(value[i], place + '[' + std::to_string(i) + ']', low, high);
    return out;
  }

  double clamped(const json& value, const std::string& place, double low, double high) {
    if (!value.is_number()) fail_in(source_.document.file, place, "a number", shown(value));
    const double x = value, y = std::clamp(x, low, high);
    if (x != y)
      source_.warnings.add(place + " is " + shown(value) + ": clamped to its " +
                           (y == low ? "least" : "greatest") + " value");
    return y;
  }

  scene::Texture texture(const Object& object, const char* key) {
    scene::Texture out;
    const Object info = member(object, key);
    if (!info) return out;
    const tinygltf::Texture& texture = source_.model.textures[(*info.value)["index"].get<size_t>()];
    if (texture.source < 0) {
      source_.warnings.add(info.place + " has no image in a format that is read: ignored");
      return out;
    }
    out.bitmap = texture.source;
    out.texcoord_set = info.value->value("texCoord", 0);
    if (texture.sampler >= 0) {
      const tinygltf::Sampler& sampler = source_.model.samplers[static_cast<size_t>(texture.sampler)];
      const auto wrap = [](int code) {
        return code == 33071 ? scene::Wrap::clamp : code == 33648 ? scene::Wrap::mirror : scene::Wrap::repeat;
      };
      out.wrap_u = wrap(sampler.wrapS);
      out.wrap_v = wrap(sampler.wrapT);
      out.filter = sampler.magFilter == 9728 ? scene::Filter::nearest : scene::Filter::linear;
    }
    // KHR_texture_transform: uv' = T R S uv, the rotation counter-clockwise as seen with v pointing down.
    const Object e = member(member(info, "extensions"), "KHR_texture_transform");
    if (!e) return out;
    const auto offset = numbers<2>(e, "offset", {0, 0}, -1e6, 1e6),
               scale = numbers<2>(e, "scale", {1, 1}, -1e6, 1e6);
    const double rotation = number(e, "rotation", 0, -1e6, 1e6), c = std::cos(rotation),
                 s = std::sin(rotation);
    out.a = as_float(c * scale[0]), out.b = as_float(s * scale[1]), out.c = as_float(offset[0]);
    out.d = as_float(-s * scale[0]), out.e = as_float(c * scale[1]), out.f = as_float(offset[1]);
    const json set = e.value->value("texCoord", json(out.texcoord_set));
    if (set != 0 && set != 1) fail_in(source_.document.file, e.place + ".texCoord", "0 or 1", shown(set));
    out.texcoord_set = set;
    return out;
  }

  Source& source_;
  const Object own_;
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
