// The viewer as a person sees it: what is shown and how, apart from the session that renders it.
#pragma once

#include "image/image.h"
#include "view/session.h"
#include "view/trace.h"
#include "view/window.h"

namespace view {

enum class Show { picture, error, difference };
enum class Hand { turntable, fly };

struct Viewer {
  Session& session;
  Trace& trace;

  State state;  // as edited; the session has it since
  State submitted;
  std::uint64_t generation = 1;
  std::shared_ptr<const Frame> frame;  // shown
  float median_error = -1;             // of the pixels that are not black, relative; below 0: not known
  double preview_ms = 0;               // from the last interaction to its first picture on the screen
  std::uint64_t timed_generation = 0;

  // How the picture is shown.
  image::Display display;
  Show show = Show::picture;
  Hand hand = Hand::turntable;
  double speed = 1;  // of flying, metres a second
  Texture texture, reference_texture;
  image::Image reference;
  std::string reference_file, reference_name;
  bool wipe = true;
  float wipe_at = .5f;  // of the picture's width: the reference is to the right

  // What is selected.
  int material = 0, bitmap = 0;
  bool show_textures = false, inspect = true;
  Texture bitmap_texture;
  int bitmap_shown = -1;
  int hover_x = -1, hover_y = -1;  // pixel under the mouse; -1: none
  std::string environment_file;

  std::string explained;  // by a tooltip, to a mouse that rests
  double explained_since = 0;

  // Saving.
  std::string image_file, scene_file, message;
  bool message_is_error = false;
  std::future<std::string> saving;
  bool copy_when_done = false;

  Viewer(Session& s, Trace& t);

  // From now on a free camera, which starts from the file's.
  FreeCamera& free_camera();
  scene::Camera camera() const;                  // in use
  void load_reference(const std::string& file);  // sets `message` if it cannot
  void load_environment(const std::string& file);
  void say(const std::string& text, bool is_error = false) { message = text, message_is_error = is_error; }

  // Once per frame of the user interface: before it is drawn, and after.
  void update();
  void submit();
  // Back to the state before the last edit; a drag or a typed number is one edit.
  bool can_undo() const { return !history_.empty(); }
  void undo();
  nlohmann::json to_json() const;  // for the trace

 private:
  void paint();
  std::vector<State> history_;
  bool in_edit_ = false, undoing_ = false;  // in_edit_: of a control that is still held
  double edited_ = -1;                      // ImGui's time
  std::shared_ptr<const Frame> painted_;
  image::Display painted_display_{1e9f, 0, false};
  Show painted_show_ = Show::picture;
  bool reference_painted_ = false;
};

// The picture with its mouse, and the column of controls; each draws into the current frame.
void draw_canvas(Viewer& viewer, float x, float y, float width, float height);
void draw_panels(Viewer& viewer, float x, float y, float width, float height);
void draw_material(Viewer& viewer);
void draw_lights(Viewer& viewer);
void draw_environment(Viewer& viewer);
void draw_textures(Viewer& viewer);  // a window of its own

}  // namespace view
