// The picture, and what the mouse and the keys do on it.
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "view/viewer.h"

namespace view {

namespace {

struct Rectangle {
  float x, y, width, height;
};

// The largest place for the picture that keeps its aspect.
Rectangle fit(const State& state, float x, float y, float width, float height) {
  const float aspect = static_cast<float>(state.width()) / static_cast<float>(state.height());
  const float w = std::min(width, height * aspect), h = w / aspect;
  return {x + (width - w) / 2, y + (height - h) / 2, w, h};
}

void move_camera(Viewer& v, const Rectangle& place) {
  const ImGuiIO& io = ImGui::GetIO();
  const double x = io.MouseDelta.x / place.height, y = io.MouseDelta.y / place.height;
  if (ImGui::IsItemActive() && (x != 0 || y != 0)) {
    if (ImGui::IsMouseDragging(ImGuiMouseButton_Left)) {
      if (v.hand == Hand::fly)
        v.free_camera().look(2 * x * v.camera().yfov, -2 * y * v.camera().yfov);
      else
        v.free_camera().turn(-x * math::pi, y * math::pi);
    } else if (ImGui::IsMouseDragging(ImGuiMouseButton_Right)) {
      v.free_camera().dolly(std::exp(2 * y));
    } else if (ImGui::IsMouseDragging(ImGuiMouseButton_Middle)) {
      v.free_camera().shift(-x, y);
    }
  }
  if (!ImGui::IsItemHovered()) return;
  if (io.MouseWheel != 0) v.free_camera().dolly(std::exp(-.1 * io.MouseWheel));
  if (v.hand != Hand::fly || io.WantTextInput) return;
  const auto axis = [](char plus, char minus) {
    return (ImGui::IsKeyDown(plus) ? 1. : 0.) -
           (ImGui::IsKeyDown(minus) ? 1. : 0.);  // GLFW's codes are ASCII
  };
  const double right = axis('D', 'A'), up = axis('E', 'Q'), forward = axis('W', 'S');
  const double step = v.speed * std::min(io.DeltaTime, .1f) * (io.KeyShift ? 5 : 1);
  if (right != 0 || up != 0 || forward != 0) v.free_camera().fly(right * step, up * step, forward * step);
}

// A name and numbers, one under the other.
template <typename... Values>
void row(const char* name, const char* format, Values... values) {
  ImGui::TextDisabled("%s", name);
  ImGui::SameLine(6 * ImGui::GetFontSize());
  ImGui::Text(format, values...);
}

// The pixel under the mouse, large, with its neighbours and numbers.
void inspect(Viewer& v, const Rectangle& canvas) {
  const Frame& frame = *v.frame;
  const int px = v.hover_x / frame.divisor, py = v.hover_y / frame.divisor;
  if (px < 0 || py < 0 || px >= frame.mean.width || py >= frame.mean.height) return;
  // In the corner away from the mouse.
  const float edge = v.hover_x < v.state.width() / 2 ? canvas.x + canvas.width - 8 : canvas.x + 8;
  ImGui::SetNextWindowPos({edge, canvas.y + 8}, ImGuiCond_Always,
                          {v.hover_x < v.state.width() / 2 ? 1.f : 0.f, 0});
  ImGui::BeginTooltip();
  const auto magnify = [&](const Texture& texture, int x, int y) {
    const float w = static_cast<float>(texture.width()), h = static_cast<float>(texture.height());
    const float fx = static_cast<float>(x) - 5, fy = static_cast<float>(y) - 5;
    ImGui::Image(texture.id(), {110, 110}, {fx / w, fy / h}, {(fx + 11) / w, (fy + 11) / h});
    const ImVec2 corner = ImGui::GetItemRectMin();
    ImGui::GetWindowDrawList()->AddRect({corner.x + 50, corner.y + 50}, {corner.x + 60, corner.y + 60},
                                        0xffffffff);
  };
  magnify(v.texture, px, py);
  const math::Vec3 mean = frame.mean.at(px, py);
  row("pixel", "%d, %d", v.hover_x, v.hover_y);
  row("radiance", "%.5g  %.5g  %.5g", mean.x, mean.y, mean.z);
  if (frame.variance.width > 0) {
    const math::Vec3 variance = frame.variance.at(px, py);
    row("error", "%.2g  %.2g  %.2g", std::sqrt(variance.x), std::sqrt(variance.y), std::sqrt(variance.z));
    row("", "%.2f %% of the mean", 100 * relative_error(mean, variance));
  }
  if (v.reference.width > 0) {
    const int rx = (2 * v.hover_x + 1) * v.reference.width / (2 * v.state.width());
    const int ry = (2 * v.hover_y + 1) * v.reference.height / (2 * v.state.height());
    const math::Vec3 r = v.reference.at(rx, ry);
    row("reference", "%.5g  %.5g  %.5g", r.x, r.y, r.z);
    row("", "differs by %.2f %%", 100 * relative_difference(mean, r));
  }
  const float u = (static_cast<float>(v.hover_x) + .5f) / static_cast<float>(v.state.width());
  const float w = (static_cast<float>(v.hover_y) + .5f) / static_cast<float>(v.state.height());
  if (const auto p = v.session.pick(u, w)) {
    const scene::Material& m = v.state.materials[static_cast<size_t>(v.session.material_of(p->instance))];
    const bsdf::Parameters& q = p->material;
    ImGui::Separator();
    ImGui::Text("%s (instance %d, triangle %d)", m.name.c_str(), p->instance, p->triangle);
    row("position", "%.4g  %.4g  %.4g", p->position.x, p->position.y, p->position.z);
    row("distance", "%.4g m", p->distance);
    row("normal", "%.3f  %.3f  %.3f", p->normal.x, p->normal.y, p->normal.z);
    row("texcoord", "%.4f  %.4f", p->texcoord.x, p->texcoord.y);
    row("textured", "%.3f  %.3f  %.3f", q.base_color.x, q.base_color.y, q.base_color.z);
    row("", "metallic %.3f, roughness %.3f", q.metallic, q.roughness);
  }
  ImGui::EndTooltip();
}

void draw_wipe(Viewer& v, const Rectangle& place) {
  const float x = place.x + v.wipe_at * place.width;
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddImage(v.reference_texture.id(), {x, place.y}, {place.x + place.width, place.y + place.height},
                 {v.wipe_at, 0}, {1, 1});
  list->AddLine({x, place.y}, {x, place.y + place.height}, 0xff40c0ff, 2);
  list->AddText({x + 6, place.y + 4}, 0xff40c0ff, v.reference_name.c_str());
  v.trace.rectangle("line of the wipe", x - 4, place.y, 8, place.height);
}

// Drags the line of the wipe; true while it has the mouse.
bool drag_wipe(Viewer& v, const Rectangle& place) {
  static bool dragging = false;
  const float mouse = ImGui::GetIO().MousePos.x, line = place.x + v.wipe_at * place.width;
  const bool near = ImGui::IsItemHovered() && std::fabs(mouse - line) < 6;
  if (near || dragging) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) dragging = near;
  if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) dragging = false;
  if (dragging) v.wipe_at = math::saturate((mouse - place.x) / place.width);
  return dragging;
}

}  // namespace

void draw_canvas(Viewer& v, float x, float y, float width, float height) {
  ImGui::SetNextWindowPos({x, y});
  ImGui::SetNextWindowSize({width, height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::Begin("canvas", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoBackground);
  ImGui::PopStyleVar(2);
  const Rectangle place = fit(v.state, x, y, width, height);
  ImGui::SetCursorScreenPos({place.x, place.y});
  ImGui::InvisibleButton("picture", {place.width, place.height},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  v.trace.rectangle("picture", place.x, place.y, place.width, place.height);
  if (v.texture.there())
    ImGui::GetWindowDrawList()->AddImage(v.texture.id(), {place.x, place.y},
                                         {place.x + place.width, place.y + place.height});
  const bool wiping = v.wipe && v.show == Show::picture && v.reference_texture.there();
  if (wiping) draw_wipe(v, place);
  if (v.frame && !v.frame->problem.empty())
    ImGui::GetWindowDrawList()->AddText({place.x + 8, place.y + 8}, 0xff6060ff, v.frame->problem.c_str());

  v.hover_x = v.hover_y = -1;
  if (ImGui::IsItemHovered()) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    v.hover_x =
        std::clamp(static_cast<int>((mouse.x - place.x) / place.width * static_cast<float>(v.state.width())),
                   0, v.state.width() - 1);
    v.hover_y = std::clamp(
        static_cast<int>((mouse.y - place.y) / place.height * static_cast<float>(v.state.height())), 0,
        v.state.height() - 1);
  }
  if (!wiping || !drag_wipe(v, place)) {
    // A click that was no drag picks the material.
    if (ImGui::IsItemHovered() && ImGui::IsMouseReleased(ImGuiMouseButton_Left) &&
        ImGui::GetIO().MouseDragMaxDistanceSqr[0] < 9 && v.hover_x >= 0) {
      const auto p =
          v.session.pick((static_cast<float>(v.hover_x) + .5f) / static_cast<float>(v.state.width()),
                         (static_cast<float>(v.hover_y) + .5f) / static_cast<float>(v.state.height()));
      if (p) v.material = v.session.material_of(p->instance);
    }
    move_camera(v, place);
  }
  if (v.inspect && v.hover_x >= 0 && v.frame && v.frame->problem.empty() && !ImGui::IsItemActive())
    inspect(v, {x, y, width, height});
  ImGui::End();
}

}  // namespace view
