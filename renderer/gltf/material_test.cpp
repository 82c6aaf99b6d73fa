// Materials: the documented mapping, number by number, and the documentation itself.
#include <cmath>

#include "gltf/reader.h"
#include "gltf/sample_test.h"
#include "gltf/schema_text.h"

using namespace gltf;
using namespace gltf::sample;
using math::Vec3;

namespace {

File file_with(const std::string& material) {
  File f = triangle();
  f.root["materials"] = json::array({json::parse(material)});
  f.root["meshes"][0]["primitives"][0]["material"] = 0;
  return f;
}
scene::Scene scene_with(const std::string& material) { return load_file(file_with(material)); }
scene::Material material(const std::string& text) { return scene_with(text).materials.at(0); }
std::string extension(const std::string& name, const std::string& values) {
  return R"({"extensions": {")" + name + "\": " + values + "}}";
}
// The table of docs/gltf.md, as schema.json has it: every parameter that says what it becomes.
void add_rows(const nlohmann::ordered_json& rule, const std::string& source, std::string& table) {
  if (!rule.contains("properties")) return;
  for (const auto& [key, property] : rule["properties"].items()) {
    if (property.contains("becomes"))
      table += "| " + source + " | `" + key + "` | " + property["becomes"].get<std::string>() + " |\n";
    add_rows(property, key.starts_with("KHR_") || key == "extras" ? key : source, table);
  }
}
std::string material_table() {
  const auto schema = nlohmann::ordered_json::parse(schema_text);
  std::string table = "| source | parameter | becomes |\n|---|---|---|\n";
  add_rows(schema["properties"]["materials"]["items"], "core", table);
  add_rows(schema["$defs"]["texture"], "core", table);
  return table;
}
std::string extras(const std::string& values) { return R"({"extras": )" + values + "}"; }

}  // namespace

TEST(Material, reads_the_core_parameters) {
  const scene::Material m =
      material(R"({"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4],
    "metallicFactor": 0.5, "roughnessFactor": 0.6}, "emissiveFactor": [1, 2, 3], "alphaMode": "MASK", "alphaCutoff": 0.7,
    "doubleSided": true})");
  EXPECT_EQ(m.name, "m");
  EXPECT_EQ(m.base_color, Vec3(.1f, .2f, .3f));
  EXPECT_EQ(m.alpha, .4f);
  EXPECT_EQ(m.metallic, .5f);
  EXPECT_EQ(m.roughness, .6f);
  EXPECT_EQ(m.emission, Vec3(1, 2, 3));
  EXPECT_EQ(m.alpha_mode, scene::AlphaMode::mask);
  EXPECT_EQ(m.alpha_cutoff, .7f);
  EXPECT_TRUE(m.double_sided);
  EXPECT_EQ(material(R"({"alphaMode": "BLEND"})").alpha_mode, scene::AlphaMode::blend);
  const scene::Material plain = material("{}"), standard;
  EXPECT_EQ(plain.specular, .5f);
  EXPECT_EQ(plain.clearcoat_roughness, standard.clearcoat_roughness);
  EXPECT_EQ(plain.alpha_mode, scene::AlphaMode::opaque);
}

TEST(Material, multiplies_emission_by_its_strength) {
  EXPECT_EQ(material(R"({"emissiveFactor": [1, 0.5, 0],
    "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 10}}})")
                .emission,
            Vec3(10, 5, 0));
  expect_refused(complaint(file_with(R"({"emissiveFactor": [1e30, 0, 0],
    "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 1e30}}})")),
                 "materials[0]: wanted a radiance");
}

TEST(Material, clamps_factors_out_of_range_and_says_so) {
  const scene::Scene scene =
      scene_with(R"({"pbrMetallicRoughness": {"baseColorFactor": [2, -1, 0.5, 1], "metallicFactor": -1,
    "roughnessFactor": 1e30}, "emissiveFactor": [-1, 0, 0]})");
  const scene::Material& m = scene.materials[0];
  EXPECT_EQ(m.base_color, Vec3(1, 0, .5f));
  EXPECT_EQ(m.metallic, 0);
  EXPECT_EQ(m.roughness, 1);
  EXPECT_EQ(m.emission, Vec3(0, 0, 0));
  for (const char* place :
       {"baseColorFactor[0]", "baseColorFactor[1]", "metallicFactor", "roughnessFactor", "emissiveFactor[0]"})
    EXPECT_TRUE(warned(scene, std::string(place) + " is ")) << place;
  expect_refused(complaint(file_with(R"({"pbrMetallicRoughness": {"roughnessFactor": 1e308}})")),
                 "roughnessFactor");
  expect_refused(complaint(file_with(R"({"pbrMetallicRoughness": {"roughnessFactor": "1"}})")),
                 "roughnessFactor");
  expect_refused(complaint(file_with(R"({"alphaMode": "mask"})")), "materials[0].alphaMode");
  expect_refused(complaint(file_with(R"({"alphaCutoff": null})")), "materials[0].alphaCutoff");
}

TEST(Material, maps_the_index_of_refraction_to_the_same_reflectance) {
  for (const double ior : {1.0, 1.2, 1.45, 1.5, 1.75}) {
    const double f0 = std::pow((ior - 1) / (ior + 1), 2);
    EXPECT_FLOAT_EQ(material(extension("KHR_materials_ior", json{{"ior", ior}}.dump())).specular * .08f,
                    static_cast<float>(f0))
        << ior;
  }
  const scene::Scene glassy = scene_with(extension("KHR_materials_ior", R"({"ior": 2.4})"));
  EXPECT_EQ(glassy.materials[0].specular, 1);
  EXPECT_TRUE(warned(glassy, "beyond Disney's .08"));
  EXPECT_EQ(material(extension("KHR_materials_ior", R"({"ior": 0})")).specular, 1);
  expect_refused(complaint(file_with(extension("KHR_materials_ior", R"({"ior": 0.5})"))),
                 "KHR_materials_ior.ior");
  expect_refused(complaint(file_with(extension("KHR_materials_ior", R"({"ior": "1.5"})"))),
                 "KHR_materials_ior.ior");
  expect_refused(complaint(file_with(extension("KHR_materials_ior", "[]"))), "KHR_materials_ior");
}

TEST(Material, maps_a_specular_factor_and_a_grey_colour_to_specular) {
  const scene::Scene half = scene_with(extension("KHR_materials_specular", R"({"specularFactor": 0.5})"));
  EXPECT_FLOAT_EQ(half.materials[0].specular, .25f);
  EXPECT_TRUE(warned(half, "specularFactor is approximated"));
  const scene::Scene grey =
      scene_with(extension("KHR_materials_specular", R"({"specularColorFactor": [1.6, 1.6, 1.6]})"));
  EXPECT_FLOAT_EQ(grey.materials[0].specular, .8f);
  EXPECT_EQ(grey.materials[0].specular_tint, 0);
  EXPECT_TRUE(grey.warnings.empty());
}

// What Blender's exporter writes for specular s and tint t: .08 s / F0(ior) (1 - t + t base /
// luminance(base)).
TEST(Material, recovers_the_specular_and_tint_that_blender_exported) {
  for (const double s : {.1, .5, .9})
    for (const double t : {0.0, .3, 1.0}) {
      const double base[] = {.8, .4, .1}, ior = 1.45, f0 = std::pow((ior - 1) / (ior + 1), 2),
                   lum = .3 * .8 + .6 * .4 + .1 * .1;
      json m;
      m["extensions"]["KHR_materials_ior"]["ior"] = ior;
      for (const double b : base) {
        m["pbrMetallicRoughness"]["baseColorFactor"].push_back(b);
        m["extensions"]["KHR_materials_specular"]["specularColorFactor"].push_back(.08 * s / f0 *
                                                                                   (1 - t + t * b / lum));
      }
      m["pbrMetallicRoughness"]["baseColorFactor"].push_back(1);
      const scene::Scene scene = scene_with(m.dump());
      EXPECT_NEAR(scene.materials[0].specular, s, 1e-6);
      EXPECT_NEAR(scene.materials[0].specular_tint, t, 1e-6);
      EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    }
  EXPECT_TRUE(warned(scene_with(extension("KHR_materials_specular", R"({"specularColorFactor": [1, 0, 0]})")),
                     "approximated by a tint"));
}

TEST(Material, maps_clearcoat_and_approximates_sheen_with_one_warning) {
  const scene::Material coat = material(
      extension("KHR_materials_clearcoat", R"({"clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.2})"));
  EXPECT_EQ(coat.clearcoat, .7f);
  EXPECT_EQ(coat.clearcoat_roughness, .2f);
  EXPECT_EQ(material(extension("KHR_materials_clearcoat", "{}")).clearcoat_roughness, 0);
  const std::string sheen = extension("KHR_materials_sheen", R"({"sheenColorFactor": [0.8, 0.4, 0.2]})");
  File f = file_with(sheen);
  f.root["materials"].push_back(json::parse(sheen));
  const scene::Scene scene = load_file(f);
  EXPECT_EQ(scene.materials[0].sheen, .8f);
  EXPECT_FLOAT_EQ(scene.materials[0].sheen_tint, .75f);
  EXPECT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(warned(scene, "KHR_materials_sheen is approximated"));
}

TEST(Material, gives_anisotropy_the_two_alphas_of_the_extension) {
  for (const double roughness : {.3, .5, .8})
    for (const double strength : {.2, .5}) {
      json j;
      j["pbrMetallicRoughness"]["roughnessFactor"] = roughness;
      j["extensions"]["KHR_materials_anisotropy"]["anisotropyStrength"] = strength;
      j["extensions"]["KHR_materials_anisotropy"]["anisotropyRotation"] = -1.5707963267948966;
      const scene::Material m = material(j.dump());
      const double alpha = roughness * roughness, along = alpha + (1 - alpha) * strength * strength;
      ASSERT_LT(along / alpha, 10);
      const double aspect = std::sqrt(1 - .9 * m.anisotropic), r2 = std::pow(double{m.roughness}, 2);
      EXPECT_NEAR(r2 / aspect, along, 1e-6);
      EXPECT_NEAR(r2 * aspect, alpha, 1e-6);
      EXPECT_FLOAT_EQ(m.anisotropic_rotation, .75f);
    }
  EXPECT_EQ(material(extension("KHR_materials_anisotropy", R"({"anisotropyStrength": 0})")).roughness, 1);
}

TEST(Material, reads_extras_as_ints_or_floats_and_prefers_them) {
  const scene::Material m =
      material(R"({"extras": {"disney_specular": 1, "disney_specular_tint": 0.1, "disney_anisotropic": 0.2,
    "disney_anisotropic_rotation": 0.3, "disney_sheen": 0.4, "disney_sheen_tint": 0.6, "disney_clearcoat": 0.7,
    "disney_clearcoat_roughness": 0, "note": "mine"},
    "extensions": {"KHR_materials_ior": {"ior": 1.2}, "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1]},
      "KHR_materials_clearcoat": {"clearcoatFactor": 0.1, "clearcoatRoughnessFactor": 0.9},
      "KHR_materials_anisotropy": {"anisotropyStrength": 0.9}}, "pbrMetallicRoughness": {"roughnessFactor": 0.5}})");
  EXPECT_EQ(m.specular, 1);
  EXPECT_EQ(m.specular_tint, .1f);
  EXPECT_EQ(m.anisotropic, .2f);
  EXPECT_EQ(m.anisotropic_rotation, .3f);
  EXPECT_EQ(m.sheen, .4f);
  EXPECT_EQ(m.sheen_tint, .6f);
  EXPECT_EQ(m.clearcoat, .7f);
  EXPECT_EQ(m.clearcoat_roughness, 0);
  EXPECT_EQ(m.roughness, .5f);
}

TEST(Material, turns_gloss_into_roughness) {
  EXPECT_FLOAT_EQ(material(extras(R"({"disney_clearcoat_gloss": 0})")).clearcoat_roughness, std::sqrt(.1f));
  EXPECT_FLOAT_EQ(material(extras(R"({"disney_clearcoat_gloss": 1})")).clearcoat_roughness, std::sqrt(.001f));
  EXPECT_NEAR(material(extras(R"({"disney_clearcoat_gloss": 0.69068})")).clearcoat_roughness,
              scene::Material().clearcoat_roughness, 1e-4);
  expect_refused(
      complaint(file_with(extras(R"({"disney_clearcoat_gloss": 1, "disney_clearcoat_roughness": 0})"))),
      "disney_clearcoat_gloss");
}

TEST(Material, refuses_wrong_extras_and_names_the_near_miss) {
  const auto refused = [](const std::string& values, const std::string& place) {
    expect_refused(complaint(file_with(extras(values))), place);
  };
  refused(R"({"disney_sheeen": 1})",
          "materials[0].extras: wanted disney_sheen, the nearest known key, found disney_sheeen");
  refused(R"({"disney_clearcoatgloss": 1})", "wanted disney_clearcoat_gloss");
  refused(R"({"disney_roughness": 1})", "found disney_roughness");
  for (const char* bad : {"-0.01", "1.01", "1e300", "\"1\"", "null", "true", "[]", "[1]", "4294967296"})
    refused(std::string(R"({"disney_sheen": )") + bad + "}",
            "materials[0].extras.disney_sheen: wanted a number in [0, 1]");
}

TEST(Material, names_texture_slots_and_extensions_that_are_not_rendered) {
  File f = file_with(
      R"({"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatNormalTexture": {"index": 0}},
    "KHR_materials_specular": {"specularFactr": 1}, "KHR_materials_volume": {}}})");
  const scene::Scene named = load_file(f);
  for (const char* text : {"KHR_materials_clearcoat.clearcoatNormalTexture is not rendered",
                           "specularFactr is not known", "extension KHR_materials_volume is not rendered"})
    EXPECT_TRUE(warned(named, text)) << text;
  EXPECT_FALSE(warned(named, "clearcoatFactor"));
}

TEST(Material, turns_a_texture_transform_into_the_specified_matrix) {
  const auto file = [](const std::string& transform) {
    File f = file_with(R"({"occlusionTexture": {"index": 0}, "normalTexture": {"index": 0, "scale": -0.5,
      "extensions": {"KHR_texture_transform": )" +
                       transform + "}}}");
    f.root["images"] = json::parse(
        R"([{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAF0lEQVR42mP4z8DwHwgbGIzTZjL8BwIAQdUIrMbWMH4AAAAASUVORK5CYII="}])");
    f.root["textures"] = json::parse(R"([{"source": 0}])");
    return f;
  };
  EXPECT_TRUE(warned(load_file(file("{}")), "occlusionTexture is not rendered"));
  EXPECT_EQ(load_file(file("{}")).materials[0].normal_scale, -.5f);
  // The example of the extension: offset [0, 1], a quarter turn, scale .5 maps the top left to the bottom
  // left.
  const scene::Texture t =
      load_file(file(R"({"offset": [0, 1], "rotation": 1.57079632679, "scale": [0.5, 0.25], "texCoord": 1})"))
          .materials[0]
          .normal_texture;
  EXPECT_EQ(t.texcoord_set, 1);
  const auto at = [&](float u, float v) { return Vec3(t.a * u + t.b * v + t.c, t.d * u + t.e * v + t.f, 0); };
  const auto near = [](const Vec3& a, const Vec3& b) { return math::length(a - b) < 1e-6f; };
  EXPECT_TRUE(near(at(0, 0), {0, 1, 0}));
  EXPECT_TRUE(near(at(1, 0), {0, .5f, 0}));  // to the right in the mesh is up in the image
  EXPECT_TRUE(near(at(0, 1), {.25f, 1, 0}));
  expect_refused(complaint(file(R"({"texCoord": 7})")), "KHR_texture_transform.texCoord");
  expect_refused(complaint(file(R"({"rotation": null})")), "KHR_texture_transform.rotation");
  EXPECT_TRUE(warned(load_file(file(R"({"scale": [1e30, 0]})")), "clamped"));
  // Without an image there is nothing to look up.
  File none = file("{}");
  none.root["textures"] = json::parse("[{}]");
  EXPECT_TRUE(warned(load_file(none), "has no image"));
  EXPECT_EQ(load_file(none).materials[0].normal_texture.bitmap, -1);
  File far = file("{}");
  far.root["materials"][0]["normalTexture"]["texCoord"] = 7;
  expect_refused(complaint(far), "materials[0].normalTexture.texCoord");
}

TEST(Material, documents_exactly_what_the_code_reads) {
  std::ifstream stream(ASSAY_SOURCE_DIR "/docs/gltf.md");
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  EXPECT_NE(text.find(material_table()), std::string::npos) << "docs/gltf.md should hold this table:\n"
                                                            << material_table();
  for (const std::string& name : supported_extensions())
    EXPECT_NE(text.find(name), std::string::npos) << name;
}
