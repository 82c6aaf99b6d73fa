#include "view/session.h"

#include <algorithm>
#include <filesystem>

#include "app/console.h"
#include "app/defaults.h"
#include "app/job.h"
#include "app/output.h"
#include "base/error.h"
#include "gltf/load.h"

namespace view {

namespace {

constexpr double preview_seconds = .03;  // what the first preview may take
constexpr int coarsest = 32, first_guess = 8;
constexpr double pass_seconds = .3;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

bool emits(const scene::Material& m) { return !math::is_black(m.emission); }

}  // namespace

Session::Session(app::Options options, std::function<void()> notify) : notify_(std::move(notify)) {
  for (const char* name : {"crop", "adaptive", "noise", "time"})
    if (options.has(name))
      base::fail("--", name, ": the viewer renders the whole picture, sample after sample: use assay-render");
  if (!options.has("spp")) options.given["spp"] = 4096;
  app::complete_settings(options);
  scene_ = gltf::load(options.text("scene"), options.load);

  // The state in which assay-render would render it.
  State& state = original_.state;
  original_.file = options.text("scene");
  original_.hash = scene_.hash;
  original_.cameras = scene_.cameras;
  if (options.has("camera"))
    options.given["camera"] = std::to_string(app::find_camera(scene_, options.text("camera")));
  const bool has_camera = !scene_.cameras.empty();
  if (has_camera && !options.has("camera")) options.given["camera"] = "0";
  const auto camera = has_camera ? static_cast<size_t>(std::stoi(options.text("camera"))) : 0;
  app::choose_size(options, has_camera ? scene_.cameras[camera].aspect : 0);
  options.given["width"] = options.render.width;
  options.given["height"] = options.render.height;
  app::check_memory(options);
  state.d_gamma = options["d-gamma"];
  if (options["d-constant"] != "auto") state.d_constant = options["d-constant"].get<float>();
  for (const char* name : {"d-gamma", "d-constant"}) options.given.erase(name);
  if (options.has("environment")) scene_.environment = app::read_environment(options);
  if (options.has("environment-color"))
    scene_.environment = app::constant_environment(options["environment-color"]);
  if (scene_.environment) {
    map_ = std::make_shared<const scene::Bitmap>(scene_.environment->map);
    base_rotation_ = scene_.environment->rotation;
    original_.sky = {map_, scene_.environment->strength, base_rotation_ * 180 / math::pi};
  }
  original_.neutral = std::make_shared<const scene::Bitmap>(app::neutral_environment().map);
  state.options = options;
  state.materials = scene_.materials;
  state.lights = scene_.lights;

  edit(state);
  worker_ = std::thread([this] { work(); });
}

Session::~Session() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = stop_ = true;
  }
  changed_.notify_all();
  worker_.join();
}

int Session::material_of(int instance) const {
  return scene_.meshes[static_cast<size_t>(scene_.instances[static_cast<size_t>(instance)].mesh)].material;
}

scene::Camera Session::file_camera(const State& state) const {
  if (!original_.cameras.empty())
    return original_.cameras[static_cast<size_t>(std::stoi(state.options.text("camera")))];
  return app::framing_camera(scene_, static_cast<float>(state.width()) / static_cast<float>(state.height()));
}

std::uint64_t Session::edit(const State& state) {
  std::uint64_t generation;
  {
    const std::lock_guard lock(mutex_);
    wanted_ = state;
    wanted_since_ = Clock::now();
    generation = ++wanted_generation_;
    stop_ = true;
  }
  changed_.notify_all();
  return generation;
}

std::shared_ptr<const Frame> Session::frame() const {
  const std::lock_guard lock(mutex_);
  return shown_;
}

std::shared_ptr<const Frame> Session::wait(std::uint64_t generation, int divisor, int samples,
                                           double seconds) const {
  std::unique_lock lock(mutex_);
  const bool there = changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] {
    return shown_ && shown_->generation >= generation &&
           (!shown_->problem.empty() || (shown_->divisor <= divisor && shown_->samples >= samples));
  });
  return there ? shown_ : nullptr;
}

std::optional<surface::Point> Session::pick(float u, float v) const {
  const std::shared_lock lock(scene_mutex_, std::try_to_lock);
  if (!lock || !renderer_) return std::nullopt;
  return renderer_->first_surface(u * static_cast<float>(renderer_width_),
                                  v * static_cast<float>(renderer_height_));
}

std::future<std::string> Session::add_task(bool needs_picture, std::function<std::string()> run) {
  std::future<std::string> future;
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back({wanted_generation_, needs_picture, std::move(run), {}});
    future = tasks_.back().promise.get_future();
  }
  changed_.notify_all();
  return future;
}

// ---- the worker ----

void Session::work() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock,
                    [&] { return quit_ || wanted_generation_ != generation_ || !idle_ || task_ready(); });
      if (quit_) return;
    }
    try {
      if (take_edit())
        apply();
      else if (!run_task())
        pass();
    } catch (const std::exception& error) {
      idle_ = true;
      film_.reset();
      Frame frame;
      frame.problem = app::message(error);
      show(std::move(frame));
    }
  }
}

// The newest state becomes the worker's; what was to be saved of the old one no longer can be.
bool Session::take_edit() {
  std::deque<Task> dropped;
  {
    const std::lock_guard lock(mutex_);
    if (wanted_generation_ == generation_) return false;
    state_ = wanted_;
    generation_ = wanted_generation_;
    edited_ = wanted_since_;
    stop_ = false;
    while (!tasks_.empty() && tasks_.front().generation < generation_) {
      dropped.push_back(std::move(tasks_.front()));
      tasks_.pop_front();
    }
  }
  for (Task& task : dropped)
    task.promise.set_exception(
        std::make_exception_ptr(base::Error("not saved: the scene was edited before that was done")));
  return true;
}

void Session::apply() {
  film_.reset();
  samples_ = 0;
  seconds_ = 0;
  rays_ = 0;
  idle_ = false;
  const app::Options options = complete_options(state_);
  app::check_memory(options);
  {
    const std::unique_lock lock(scene_mutex_);
    settings_ = options.render;
    for (size_t i = 0; i < state_.materials.size(); ++i)
      if (scene_.materials[i] != state_.materials[i]) {
        lights_changed_ |= emits(scene_.materials[i]) || emits(state_.materials[i]);
        scene_.materials[i] = state_.materials[i];
      }
    lights_changed_ |= scene_.lights != state_.lights;
    scene_.lights = state_.lights;
    scene_.cameras = original_.cameras;
    if (state_.camera) settings_.camera = static_cast<int>(scene_.cameras.size());
    if (state_.camera)
      scene_.cameras.push_back(state_.camera->camera());
    else if (scene_.cameras.empty())
      scene_.cameras.push_back(file_camera(state_));
    choose_environment();
  }
  divisor_ = pixel_seconds_ == 0 ? first_guess : 2;
  const double pixels = static_cast<double>(settings_.width) * settings_.height;
  while (divisor_ < coarsest && pixels * pixel_seconds_ > preview_seconds * divisor_ * divisor_)
    divisor_ *= 2;
  refresh();
}

// The edited sky, else the scene's or the options', else, where nothing else sends light, the neutral one.
void Session::choose_environment() {
  std::optional<scene::Environment> before = std::exchange(scene_.environment, std::nullopt);
  std::optional<Sky> sky = state_.sky ? state_.sky : original_.sky;
  if (!sky && app::shows_light(settings_.shader) && !app::has_light(scene_)) sky = {original_.neutral, 1, 0};
  if (!sky) {
    lights_changed_ |= before.has_value();
    return;
  }
  const float rotation =
      state_.sky || !original_.sky ? sky->rotation_degrees * math::pi / 180 : base_rotation_;
  lights_changed_ |=
      !before || map_ != sky->map || before->strength != sky->strength || before->rotation != rotation;
  if (!before || map_ != sky->map) before = {*(map_ = sky->map), 1, 0};
  before->strength = sky->strength;
  before->rotation = rotation;
  scene_.environment = std::move(before);
}

// The renderer for the size at hand, of the scene as it is now.
void Session::refresh() {
  integrator::Settings s = settings_;
  if (divisor_ > 1) {
    s.width = std::max(1, s.width / divisor_);
    s.height = std::max(1, s.height / divisor_);
    s.spp = s.replicates = 1;
  }
  const std::unique_lock lock(scene_mutex_);
  try {
    if (renderer_)
      renderer_->refresh(s, lights_changed_);
    else
      renderer_ = std::make_unique<integrator::Renderer>(scene_, s);
    lights_changed_ = false;
  } catch (...) {
    renderer_.reset();
    throw;
  }
  renderer_width_ = s.width;
  renderer_height_ = s.height;
}

// Up to the next sample that all replicates have, and by rounds of them where that is quick.
int Session::next_count() const {
  if (divisor_ > 1 || samples_ == 0) return 1;
  const int round = settings_.replicates, left = settings_.spp - samples_;
  const int affordable = static_cast<int>(std::min(pass_seconds * samples_ / std::max(seconds_, 1e-6), 1e6));
  const int to_round = round - samples_ % round;
  if (affordable < to_round) return std::max(affordable, 1);
  return std::min(to_round + (affordable - to_round) / round * round, left);
}

void Session::pass() {
  if (!film_) film_ = renderer_->film();
  const int count = next_count();
  const std::uint64_t rays = renderer_->rays();
  const Clock::time_point start = Clock::now();
  const bool whole = renderer_->render(*film_, samples_, count, {}, {}, &stop_);
  const double elapsed = since(start);
  if (!whole) return;  // there is an edit, or the end
  if (divisor_ == 1) {
    seconds_ += elapsed;
    rays_ += renderer_->rays() - rays;
  }
  samples_ += count;
  pixel_seconds_ = elapsed / (static_cast<double>(film_->width()) * film_->height() * count);
  idle_ = divisor_ == 1 && samples_ >= settings_.spp;
  publish();
  if (divisor_ == 1) return;
  divisor_ /= 2;
  samples_ = 0;
  film_.reset();
  refresh();
}

void Session::publish() {
  // Averaging the film may take no more than a tenth of the time.
  const bool may_wait = divisor_ == 1 && samples_ > 1 && !idle_;
  if (may_wait && since(published_) < 10 * publish_seconds_) return;
  const Clock::time_point start = Clock::now();
  Frame frame;
  frame.divisor = divisor_;
  frame.samples = samples_;
  frame.complete = idle_;
  frame.mean = film_->mean_image();
  if (divisor_ == 1 && std::min(samples_, settings_.replicates) > 1) frame.variance = film_->variance_image();
  frame.seconds = seconds_;
  frame.rays = rays_;
  frame.rejected = film_->rejected();
  show(std::move(frame));
  published_ = Clock::now();
  publish_seconds_ = since(start);
}

void Session::show(Frame frame) {
  frame.generation = generation_;
  frame.edited = edited_;
  {
    const std::lock_guard lock(mutex_);
    if (wanted_generation_ != generation_) return;  // of a state that is gone
    shown_ = std::make_shared<const Frame>(std::move(frame));
  }
  changed_.notify_all();
  if (notify_) notify_();
}

bool Session::picture_ready() const {
  return divisor_ == 1 && film_ && samples_ > 0 && samples_ % settings_.replicates == 0;
}

bool Session::task_ready() const {
  return !tasks_.empty() && (!tasks_.front().needs_picture || picture_ready() || idle_);
}

bool Session::run_task() {
  Task task;
  {
    const std::lock_guard lock(mutex_);
    if (!task_ready()) return false;
    task = std::move(tasks_.front());
    tasks_.pop_front();
  }
  try {
    if (task.needs_picture && !picture_ready()) base::fail("not saved: there is no picture");
    task.promise.set_value(task.run());
  } catch (...) {
    task.promise.set_exception(std::current_exception());
  }
  return true;
}

// ---- saving, by the worker ----

std::future<std::string> Session::save_image(const std::string& file, const image::Display& display) {
  return add_task(true, [=, this] { return write_image(file, display); });
}

std::future<std::string> Session::save_scene(const std::string& file) {
  return add_task(false, [=, this] {
    saved_ = view::save_scene(original_, state_, file);
    return file + ": the scene with its edits";
  });
}

std::future<std::string> Session::command(const std::string& file, int samples,
                                          const image::Display& display) {
  return add_task(false, [=, this] {
    return app::command(options_for(original_, state_, saved_scene(file), samples, file, display), true);
  });
}

const SavedScene* Session::saved_scene(const std::string& image_file) {
  if (!is_edited(original_, state_)) return nullptr;
  std::error_code none;
  const bool there = saved_ && is_scene_of(*saved_, state_) && std::filesystem::exists(saved_->file, none);
  if (!there) {
    const std::filesystem::path path(image_file);
    saved_ = view::save_scene(original_, state_,
                              (path.parent_path() / (path.stem().string() + ".scene.glb")).string());
  }
  return &*saved_;
}

std::string Session::write_image(const std::string& file, const image::Display& display) {
  const SavedScene* saved = saved_scene(file);
  const app::Options options = options_for(original_, state_, saved, samples_, file, display);
  app::check_writable(options);
  scene_.hash = saved != nullptr ? saved->hash : original_.hash;
  app::write_picture(options, scene_, *renderer_, *film_, {}, samples_, false);
  return file + ": " + std::to_string(samples_) + " samples" +
         (saved != nullptr ? ", of the scene in " + saved->file : "");
}

}  // namespace view
