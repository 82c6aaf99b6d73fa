// What the viewer does, as lines of JSON for a script that drives it: where on the screen each control is,
// and what the picture shows. Off unless asked for (--trace FILE).
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace view {

class Trace {
 public:
  // "" for none. Throws base::Error.
  void open(const std::string& file);
  bool on() const { return file_.is_open(); }
  void begin_frame(int window_x, int window_y);
  // The control drawn last, by name: its rectangle on the screen, if it is visible.
  void item(const std::string& name);
  void rectangle(const std::string& name, float x, float y, float width, float height);
  // Writes a line if anything is new.
  void end_frame(const nlohmann::json& state);

 private:
  std::ofstream file_;
  int x_ = 0, y_ = 0;
  nlohmann::json items_ = nlohmann::json::object();
  std::string last_;
};

}  // namespace view
