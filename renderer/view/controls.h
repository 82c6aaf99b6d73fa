// Sliders, menus and boxes with a label at the right, each known to the trace by its label.
#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "view/viewer.h"

namespace view {

// Explains the control drawn last to a mouse that rests on it.
inline void explain(Viewer& v, const std::string& text) {
  if (text.empty() || !ImGui::IsItemHovered() || ImGui::IsAnyMouseDown()) return;
  if (v.explained != text) {
    v.explained = text;
    v.explained_since = ImGui::GetTime();
  }
  if (ImGui::GetTime() - v.explained_since < .4) return;
  const ImVec2 corner = ImGui::GetItemRectMin();  // to its left, where no other control is covered
  ImGui::SetNextWindowPos({corner.x - ImGui::GetFontSize(), corner.y}, ImGuiCond_Always, {1, 0});
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(22 * ImGui::GetFontSize());
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

// With the value `before` it had in the file, it shows when it was edited, and a right click undoes that.
inline bool slider(Viewer& v, const char* label, float& value, float least, float most,
                   const char* format = "%.3f", ImGuiSliderFlags flags = 0, const std::string& help = "",
                   const float* before = nullptr) {
  const bool edited = before != nullptr && value != *before;
  if (edited) ImGui::PushStyleColor(ImGuiCol_Text, {1, .8f, .4f, 1});
  bool changed = ImGui::SliderFloat(label, &value, least, most, format, flags | ImGuiSliderFlags_AlwaysClamp);
  if (edited) ImGui::PopStyleColor();
  if (edited && ImGui::IsItemClicked(ImGuiMouseButton_Right)) value = *before, changed = true;
  v.trace.item(label);
  explain(v, help);
  return changed;
}

inline bool checkbox(Viewer& v, const char* label, bool& value, const std::string& help = "") {
  const bool changed = ImGui::Checkbox(label, &value);
  v.trace.item(label);
  explain(v, help);
  return changed;
}

inline bool button(Viewer& v, const char* label, const std::string& help = "") {
  const bool pressed = ImGui::Button(label);
  v.trace.item(label);
  explain(v, help);
  return pressed;
}

// True if another one of `names` was chosen, which `index` then says; `helps` explain them.
inline bool menu(Viewer& v, const char* label, const std::vector<std::string>& names, int& index,
                 const std::string& help = "", const std::vector<std::string>& helps = {}) {
  const std::string shown =
      index >= 0 && index < static_cast<int>(names.size()) ? names[static_cast<size_t>(index)] : "";
  bool changed = false;
  const bool open = ImGui::BeginCombo(label, shown.c_str(), ImGuiComboFlags_HeightLargest);
  v.trace.item(label);
  if (!open) {
    explain(v, help);
    return false;
  }
  for (int i = 0; i < static_cast<int>(names.size()); ++i) {
    ImGui::PushID(i);
    if (ImGui::Selectable(names[static_cast<size_t>(i)].c_str(), i == index)) changed = i != index, index = i;
    v.trace.item(std::string(label) + ": " + names[static_cast<size_t>(i)]);
    if (!helps.empty()) explain(v, helps[static_cast<size_t>(i)]);
    ImGui::PopID();
  }
  ImGui::EndCombo();
  return changed;
}

// Colour in [0, 1], or with `hdr` any radiance: a hue and a strength.
inline bool colour(Viewer& v, const char* label, math::Vec3& value, bool hdr = false,
                   const std::string& help = "") {
  const bool changed = ImGui::ColorEdit3(
      label, &value.x,
      ImGuiColorEditFlags_Float | (hdr ? ImGuiColorEditFlags_HDR : ImGuiColorEditFlags_None));
  v.trace.item(label);
  explain(v, help);
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
