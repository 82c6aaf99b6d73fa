// One scene under edit and the thread that renders it: the viewer without its window.
//
// edit() gives the session a new state and a new generation. The worker drops what it does at the end of the
// tiles under way, puts the edits into its scene, shows a picture of a fraction of the size, then finer ones,
// then adds whole passes to a film of full size. Every frame belongs to one generation: samples of two states
// never meet. After N samples the film is, bit by bit, what assay-render makes with --spp N.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <shared_mutex>
#include <thread>

#include "image/display.h"
#include "image/film.h"
#include "integrator/render.h"
#include "surface/surface.h"
#include "view/save.h"
#include "view/state.h"

namespace view {

using Clock = std::chrono::steady_clock;

struct Frame {  // what can be shown
  std::uint64_t generation = 0;
  int divisor = 1;        // of the picture's sides: above 1 it is a preview
  int samples = 0;        // per pixel; a preview has 1
  bool complete = false;  // all samples that were asked for
  image::Image mean;
  image::Image variance;   // of the mean; empty until two replicates have samples
  double seconds = 0;      // of rendering this state
  std::uint64_t rays = 0;  // in that time
  std::int64_t rejected = 0;
  std::string problem;       // why there is no picture; empty: there is one
  Clock::time_point edited;  // when the generation began
};

class Session {
 public:
  // Reads the scene of `options`, which are assay-render's, and starts to render. `notify` is called, from
  // the worker, for every new frame. Throws base::Error.
  explicit Session(app::Options options, std::function<void()> notify = {});
  ~Session();

  const Original& original() const { return original_; }
  const std::vector<scene::EncodedBitmap>& bitmaps() const { return scene_.bitmaps; }
  int material_of(int instance) const;  // its index
  // The camera of a state that has no free one: the options', or in a file without cameras the framing one.
  scene::Camera file_camera(const State& state) const;
  const std::vector<std::string>& warnings() const { return scene_.warnings; }

  // From now on the picture is that of `state`. Returns its generation.
  std::uint64_t edit(const State& state);
  // The newest frame; null before the first.
  std::shared_ptr<const Frame> frame() const;
  // Waits for a frame of a generation, this fine and with this many samples; null if it takes too long.
  std::shared_ptr<const Frame> wait(std::uint64_t generation, int divisor, int samples,
                                    double seconds = 60) const;

  // What is seen at (u, v), from (0, 0) at the upper left corner to (1, 1); nullopt: nothing, or the scene is
  // being edited just now.
  std::optional<surface::Point> pick(float u, float v) const;

  // Saves from the worker, between passes. The future holds a line that says what was written, or
  // base::Error. The image waits until all replicates have the same number of samples; if a scene that was
  // edited has no file yet, it gets one beside the image, so that there is a command which makes the image
  // again.
  std::future<std::string> save_image(const std::string& file, const image::Display& display);
  std::future<std::string> save_scene(const std::string& file);
  // The command line of assay-render that makes this image; saves an edited scene as save_image() does.
  std::future<std::string> command(const std::string& file, int samples, const image::Display& display);

 private:
  struct Task {
    std::uint64_t generation;
    bool needs_picture;
    std::function<std::string()> run;
    std::promise<std::string> promise;
  };
  std::future<std::string> add_task(bool needs_picture, std::function<std::string()> run);

  // Of the worker.
  void work();
  bool take_edit();
  void apply();
  void choose_environment();
  void refresh();
  void pass();
  int next_count() const;
  void publish();
  void show(Frame frame);
  bool picture_ready() const;
  bool task_ready() const;
  bool run_task();
  std::string write_image(const std::string& file, const image::Display& display);
  const SavedScene* saved_scene(const std::string& image_file);

  Original original_;
  std::function<void()> notify_;

  mutable std::mutex mutex_;  // of what follows
  mutable std::condition_variable changed_;
  State wanted_;
  std::uint64_t wanted_generation_ = 0;
  Clock::time_point wanted_since_;
  bool quit_ = false;
  std::deque<Task> tasks_;
  std::shared_ptr<const Frame> shown_;

  std::atomic<bool> stop_{false};  // there is an edit, or the end

  mutable std::shared_mutex scene_mutex_;  // of what follows: pick() reads it beside the worker
  scene::Scene scene_;
  std::unique_ptr<integrator::Renderer> renderer_;
  int renderer_width_ = 0, renderer_height_ = 0;

  // The worker's alone.
  State state_;
  std::uint64_t generation_ = 0;
  Clock::time_point edited_, published_;
  integrator::Settings settings_;
  std::optional<image::Film> film_;
  std::shared_ptr<const scene::Bitmap> map_;  // of which scene_.environment holds a copy
  float base_rotation_ = 0;                   // of the environment before any edit, radians
  bool lights_changed_ = false;
  bool idle_ = false;  // nothing to do for this state: complete, or impossible
  int divisor_ = 1, samples_ = 0;
  double seconds_ = 0, pixel_seconds_ = 0, publish_seconds_ = 0;
  std::uint64_t rays_ = 0;
  std::optional<SavedScene> saved_;
  std::thread worker_;
};

}  // namespace view
