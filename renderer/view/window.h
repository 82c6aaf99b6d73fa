// The window: GLFW, OpenGL and Dear ImGui put together, and pictures as textures.
#pragma once

#include <string>
#include <vector>

#include "view/colours.h"

struct GLFWwindow;

namespace view {

class Window {
 public:
  // Throws base::Error if there is no display or no OpenGL 3.
  Window(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool closed() const;
  // Waits for input, wake() or the time to pass; then begins a frame of the user interface.
  void begin_frame(double seconds);
  void end_frame();
  static void wake();  // from any thread
  void set_title(const std::string& title);
  float scale() const { return scale_; }  // of everything drawn: above 1 on a screen of many small pixels
  void position(int& x, int& y) const;    // of its contents, on the screen

 private:
  GLFWwindow* window_ = nullptr;
  float scale_ = 1;
};

// A picture on the graphics card.
class Texture {
 public:
  Texture() = default;
  ~Texture();
  Texture(const Texture&) = delete;
  Texture& operator=(const Texture&) = delete;

  // `smooth`: interpolated where it is magnified.
  void set(const std::vector<Rgba>& pixels, int width, int height, bool smooth);
  bool there() const { return id_ != 0; }
  void* id() const { return reinterpret_cast<void*>(static_cast<std::size_t>(id_)); }  // as ImGui wants it
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  unsigned id_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace view
