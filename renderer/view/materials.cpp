// Controls of what the scene is made of: materials, lights, environment, textures.
#include <imgui.h>
#include <imgui_stdlib.h>

#include "view/controls.h"

namespace view {

namespace {

struct Parameter {
  const char* name;
  float scene::Material::*member;
  const char* help;
};
using scene::Material;
const Parameter parameters[] = {
    {"metallic", &Material::metallic,
     "0: a dielectric, diffuse with a white gloss. 1: a metal, no diffuse light, reflection in the base "
     "colour."},
    {"roughness", &Material::roughness,
     "Width of the reflection: 0 a mirror, 1 dull. The microfacets' alpha is its square."},
    {"specular", &Material::specular,
     "Strength of a dielectric's reflection: 8 % at normal incidence for 1; .5 is an index of refraction of "
     "1.5. "
     "Nothing on a metal."},
    {"specular tint", &Material::specular_tint,
     "Hue of that reflection: 0 white, 1 that of the base colour."},
    {"anisotropic", &Material::anisotropic,
     "Stretches the highlight along the surface's tangent: 0 round, 1 longest."},
    {"anisotropic rotation", &Material::anisotropic_rotation,
     "Turns that tangent about the normal: 1 is a whole turn, .25 exchanges along and across."},
    {"sheen", &Material::sheen, "Extra light at grazing angles, as of cloth. Nothing on a metal."},
    {"sheen tint", &Material::sheen_tint, "Hue of the sheen: 0 white, 1 that of the base colour."},
    {"clearcoat", &Material::clearcoat,
     "A second, colourless layer of varnish on top; 1 is a quarter of a full layer of index 1.5."},
    {"clearcoat roughness", &Material::clearcoat_roughness, "Width of the coat's highlight: 0 sharp."}};

}  // namespace

void draw_material(Viewer& v) {
  if (!section(v, "Material")) return;
  std::vector<std::string> names;
  for (const scene::Material& m : v.state.materials) names.push_back(m.name.empty() ? "(no name)" : m.name);
  if (names.empty()) return;
  menu(v, "material", names, v.material);
  scene::Material& m = v.state.materials[static_cast<size_t>(v.material)];
  colour(v, "base colour", m.base_color, false,
         "Colour of the diffuse light, or of a metal's reflection; multiplies the texture.");
  const scene::Material& before = v.session.original().state.materials[static_cast<size_t>(v.material)];
  for (const Parameter& p : parameters)
    slider(v, p.name, m.*p.member, 0, 1, "%.3f", 0, p.help, &(before.*p.member));
  // Disney's gloss g: roughness^2 = mix(.1, .001, g).
  float gloss = math::saturate((.1f - m.clearcoat_roughness * m.clearcoat_roughness) / .099f);
  if (slider(v, "clearcoat gloss", gloss, 0, 1, "%.3f", 0,
             "The coat's roughness as Burley's gloss: 1 is sharp. Another way to say clearcoat roughness."))
    m.clearcoat_roughness = std::sqrt(math::mix(.1f, .001f, gloss));
  colour(v, "emission", m.emission, true,
         "Radiance the surface sends out, W/(sr m²); multiplies the texture.");
  int alpha_mode = static_cast<int>(m.alpha_mode);
  if (menu(v, "alpha", {"opaque", "mask", "blend"}, alpha_mode,
           "opaque: no holes. mask: a hole where the opacity is below the cutoff. blend: as much light goes "
           "straight through as the opacity leaves."))
    m.alpha_mode = static_cast<scene::AlphaMode>(alpha_mode);
  if (m.alpha_mode != scene::AlphaMode::opaque) slider(v, "opacity", m.alpha, 0, 1);
  if (m.alpha_mode == scene::AlphaMode::mask) slider(v, "cutoff", m.alpha_cutoff, 0, 1);
  if (m.normal_texture.bitmap >= 0) slider(v, "normal scale", m.normal_scale, 0, 4);
  checkbox(v, "double-sided", m.double_sided, "Off: the back lets every ray through, as glTF asks for.");
  ImGui::SameLine();
  if (button(v, "as in the file", "All of this material's values as they were loaded.")) m = before;
  for (const scene::Texture* t :
       {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emissive_texture}) {
    if (t->bitmap < 0) continue;
    ImGui::PushID(t);
    static const char* const roles[] = {"base colour", "metallic, roughness", "normal", "emission"};
    const scene::Texture* const all[] = {&m.base_color_texture, &m.metallic_roughness_texture,
                                         &m.normal_texture, &m.emissive_texture};
    const auto role = roles[std::find(std::begin(all), std::end(all), t) - std::begin(all)];
    ImGui::Text("%s x %s", role, v.session.bitmaps()[static_cast<size_t>(t->bitmap)].name.c_str());
    ImGui::SameLine();
    if (ImGui::SmallButton("show")) v.bitmap = t->bitmap, v.show_textures = true;
    v.trace.item(std::string("show ") + role);
    ImGui::PopID();
  }
}

void draw_lights(Viewer& v) {
  if (v.state.lights.empty() || !section(v, "Lights")) return;
  static const char* const kinds[] = {"directional (W/m²)", "point (W/sr)", "spot (W/sr)"};
  for (size_t i = 0; i < v.state.lights.size(); ++i) {
    scene::Light& light = v.state.lights[i];
    ImGui::PushID(static_cast<int>(i));
    const std::string number = std::to_string(i);
    ImGui::Text("%s%s%s", kinds[static_cast<int>(light.kind)], light.name.empty() ? "" : ": ",
                light.name.c_str());
    // Strength and hue; black keeps the hue it had in the file.
    float strength = math::max_component(light.intensity);
    math::Vec3 hue = strength > 0 ? light.intensity / strength : math::Vec3(1);
    const float most = 4 * std::max(math::max_component(v.session.original().state.lights[i].intensity), 1.f);
    bool changed = ImGui::SliderFloat("intensity", &strength, 0, most, "%.3f", ImGuiSliderFlags_Logarithmic);
    v.trace.item("intensity " + number);
    changed |= ImGui::ColorEdit3("colour", &hue.x, ImGuiColorEditFlags_Float);
    if (changed) light.intensity = hue * std::max(strength, 0.f);
    if (light.kind != scene::LightKind::directional) ImGui::DragFloat3("position", &light.position.x, .02f);
    if (light.kind == scene::LightKind::spot) {
      // In degrees, the edge always outside: no light has cones the other way round.
      const float degree = math::pi / 180;
      float inner = std::acos(light.cos_inner) / degree, outer = std::acos(light.cos_outer) / degree;
      if (slider(v, "inner angle", inner, 0, 89.5f, "%.1f°", 0, "From the axis: full light inside.")) {
        light.cos_inner = std::cos(inner * degree);
        light.cos_outer = std::min(light.cos_outer, std::cos((inner + .5f) * degree));
      }
      if (slider(v, "outer angle", outer, .5f, 90, "%.1f°", 0, "From the axis: no light outside.")) {
        light.cos_outer = std::cos(std::min(outer * degree, math::pi / 2));
        light.cos_inner = std::max(light.cos_inner, std::cos((outer - .5f) * degree));
      }
    }
    ImGui::PopID();
  }
}

void draw_environment(Viewer& v) {
  if (!section(v, "Environment", false)) return;
  const std::optional<Sky>& base = v.session.original().sky;
  std::optional<Sky> sky = v.state.sky ? v.state.sky : base;
  if (!sky) {
    ImGui::TextUnformatted("none (a scene without light gets a neutral sky)");
    if (button(v, "add a constant one")) {
      const scene::Bitmap white{"constant", 1, 1, {{1, 1, 1, 1}}};
      v.state.sky = {std::make_shared<const scene::Bitmap>(white), 1, 0};
    }
  } else {
    bool changed = slider(v, "strength", sky->strength, 0, 20, "%.3f", ImGuiSliderFlags_Logarithmic);
    if (sky->map->texels.size() <= 2) {
      math::Vec3 c(sky->map->texels[0]);
      if (colour(v, "radiance", c, true)) {
        const scene::Bitmap constant{"constant", 1, 1, {{c.x, c.y, c.z, 1}}};
        sky->map = std::make_shared<const scene::Bitmap>(constant);
        changed = true;
      }
    } else {
      ImGui::Text("%s, %d x %d", sky->map->name.c_str(), sky->map->width, sky->map->height);
      changed |= slider(v, "rotation", sky->rotation_degrees, -180, 180, "%.1f°");
    }
    if (changed) v.state.sky = sky;
    if (v.state.sky && button(v, "the scene's own")) v.state.sky.reset();
  }
  ImGui::InputText("##environment", &v.environment_file);
  v.trace.item("environment file");
  ImGui::SameLine();
  if (button(v, "load map")) v.load_environment(v.environment_file);
}

void draw_textures(Viewer& v) {
  const std::vector<scene::EncodedBitmap>& bitmaps = v.session.bitmaps();
  if (!v.show_textures || bitmaps.empty()) return;
  ImGui::SetNextWindowSize({420, 460}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowPos({40, 40}, ImGuiCond_FirstUseEver);
  if (ImGui::Begin("Textures", &v.show_textures)) {
    std::vector<std::string> names;
    for (const scene::EncodedBitmap& b : bitmaps)
      names.push_back(b.name + ", " + std::to_string(b.width) + " x " + std::to_string(b.height));
    menu(v, "texture", names, v.bitmap);
    const scene::EncodedBitmap& b = bitmaps[static_cast<size_t>(v.bitmap)];
    if (v.bitmap_shown != v.bitmap) {  // as the file has it
      std::vector<Rgba> pixels;
      pixels.reserve(b.texels.size());
      const auto code = [](std::uint16_t x) { return static_cast<std::uint8_t>(x / 257); };
      for (const math::U16Vec4& t : b.texels) pixels.push_back({code(t.x), code(t.y), code(t.z), 255});
      v.bitmap_texture.set(pixels, b.width, b.height, false);
      v.bitmap_shown = v.bitmap;
    }
    std::string users;
    for (const scene::Material& m : v.state.materials)
      for (const scene::Texture* t :
           {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emissive_texture})
        if (t->bitmap == v.bitmap) users += (users.empty() ? "" : ", ") + m.name;
    ImGui::TextWrapped("of %s", users.c_str());
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const float w = static_cast<float>(b.width), h = static_cast<float>(b.height);
    const float scale = std::min(room.x / w, std::max(room.y - 20, 20.f) / h);
    ImGui::Image(v.bitmap_texture.id(), {w * scale, h * scale});
    if (ImGui::IsItemHovered()) {
      const ImVec2 mouse = ImGui::GetIO().MousePos, corner = ImGui::GetItemRectMin();
      const int x = std::min(static_cast<int>((mouse.x - corner.x) / scale), b.width - 1);
      const int y = std::min(static_cast<int>((mouse.y - corner.y) / scale), b.height - 1);
      const math::Vec4 t = scene::fraction(
          b.texels[static_cast<size_t>(y) * static_cast<size_t>(b.width) + static_cast<size_t>(x)]);
      ImGui::SetTooltip("texel %d, %d: %.4f %.4f %.4f, alpha %.4f", x, y, t.x, t.y, t.z, t.w);
    }
  }
  ImGui::End();
}

}  // namespace view
