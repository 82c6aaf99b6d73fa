#include "view/trace.h"

#include <imgui.h>

#include "base/error.h"

namespace view {

void Trace::open(const std::string& file) {
  if (file.empty()) return;
  file_.open(file, std::ios::trunc);
  if (!file_) base::fail("--trace: ", file, ": cannot write");
}

void Trace::begin_frame(int window_x, int window_y) {
  x_ = window_x;
  y_ = window_y;
  items_.clear();
}

void Trace::item(const std::string& name) {
  if (!on() || !ImGui::IsItemVisible()) return;
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  rectangle(name, low.x, low.y, high.x - low.x, high.y - low.y);
}

void Trace::rectangle(const std::string& name, float x, float y, float width, float height) {
  if (on())
    items_[name] = {static_cast<int>(x) + x_, static_cast<int>(y) + y_, static_cast<int>(width),
                    static_cast<int>(height)};
}

void Trace::end_frame(const nlohmann::json& state) {
  if (!on()) return;
  const std::string line = nlohmann::json{{"items", items_}, {"state", state}}.dump(
      -1, ' ', false, nlohmann::json::error_handler_t::replace);
  if (line == last_) return;
  file_ << line << std::endl;
  last_ = line;
}

}  // namespace view
