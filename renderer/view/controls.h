// Sliders, menus and boxes with a label at the right, each known to the trace by its label.
#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "view/viewer.h"

namespace view {

inline bool slider(Viewer& v, const char* label, float& value, float least, float most,
                   const char* format = "%.3f", ImGuiSliderFlags flags = 0) {
  const bool changed =
      ImGui::SliderFloat(label, &value, least, most, format, flags | ImGuiSliderFlags_AlwaysClamp);
  v.trace.item(label);
  return changed;
}

inline bool checkbox(Viewer& v, const char* label, bool& value) {
  const bool changed = ImGui::Checkbox(label, &value);
  v.trace.item(label);
  return changed;
}

inline bool button(Viewer& v, const char* label) {
  const bool pressed = ImGui::Button(label);
  v.trace.item(label);
  return pressed;
}

// True if another one of `names` was chosen, which `index` then says.
inline bool menu(Viewer& v, const char* label, const std::vector<std::string>& names, int& index) {
  const std::string shown =
      index >= 0 && index < static_cast<int>(names.size()) ? names[static_cast<size_t>(index)] : "";
  bool changed = false;
  const bool open = ImGui::BeginCombo(label, shown.c_str(), ImGuiComboFlags_HeightLargest);
  v.trace.item(label);
  if (!open) return false;
  for (int i = 0; i < static_cast<int>(names.size()); ++i) {
    ImGui::PushID(i);
    if (ImGui::Selectable(names[static_cast<size_t>(i)].c_str(), i == index)) changed = i != index, index = i;
    v.trace.item(std::string(label) + ": " + names[static_cast<size_t>(i)]);
    ImGui::PopID();
  }
  ImGui::EndCombo();
  return changed;
}

// Colour in [0, 1], or with `hdr` any radiance: a hue and a strength.
inline bool colour(Viewer& v, const char* label, math::Vec3& value, bool hdr = false) {
  const bool changed = ImGui::ColorEdit3(
      label, &value.x,
      ImGuiColorEditFlags_Float | (hdr ? ImGuiColorEditFlags_HDR : ImGuiColorEditFlags_None));
  v.trace.item(label);
  if (changed)
    for (int c = 0; c < 3; ++c) value[c] = std::max(0.f, hdr ? value[c] : std::min(value[c], 1.f));
  return changed;
}

inline bool section(Viewer& v, const char* label, bool open = true) {
  const bool is_open = ImGui::CollapsingHeader(label, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
  v.trace.item(label);
  return is_open;
}

}  // namespace view
