#include "integrator/render.h"

#include <immintrin.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <sstream>
#include <utility>

#include "base/error.h"
#include "integrator/camera.h"
#include "integrator/path.h"
#include "integrator/reuse.h"
#include "math/warp.h"

namespace integrator {

namespace {

using math::Vec3;

constexpr int tile_size = 8;
static_assert(tile_size % block_side == 0);

// Within a tile of many samples: some hundredths of a second.
constexpr std::uint64_t rays_between_reports = 100000;

// Flushes denormals to zero in this thread while it lives: one denormal operation costs ten normal ones, and
// Embree asks for it. Set around every tile, so that pictures do not depend on which thread renders them.
class FlushDenormals {
 public:
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040); }  // FTZ and DAZ
  ~FlushDenormals() { _mm_setcsr(saved_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned saved_;
};

bsdf::Model model_of(Shader shader) {
  switch (shader) {
    case Shader::path_disney:
      return bsdf::Model::path_disney;
    case Shader::principled:
      return bsdf::Model::principled;
    case Shader::path:
    case Shader::direct:
    case Shader::path_nomis:
    case Shader::eyelight:
      return bsdf::Model::path;
    default:
      return bsdf::Model::disney;
  }
}
bool traces_paths(Shader shader) {
  switch (shader) {
    case Shader::path:
    case Shader::path_disney:
    case Shader::principled:
    case Shader::disney:
    case Shader::direct:
    case Shader::path_nomis:
      return true;
    default:
      return false;
  }
}

void check(const Settings& s, const scene::Scene& scene) {
  const auto wants = [](bool ok, const char* option, const std::string& wanted, double found) {
    if (!ok) base::fail(option, ": wanted ", wanted, ", found ", found);
  };
  wants(s.width >= 1 && s.width <= 65536, "--width", "1 to 65536 pixels", s.width);
  wants(s.height >= 1 && s.height <= 65536, "--height", "1 to 65536 pixels", s.height);
  wants(s.spp >= 1 && s.spp <= 1 << 24, "--spp", "1 to 16777216 samples", s.spp);
  wants(s.replicates >= 1 && s.replicates <= 64 && s.spp % s.replicates == 0, "--replicates",
        "1 to 64, a divisor of --spp " + std::to_string(s.spp), s.replicates);
  wants(s.depth >= 0 && s.depth <= 10000, "--depth", "0 to 10000", s.depth);
  wants(s.d_gamma > 0 && s.d_gamma <= 10, "--d-gamma", "a number above 0 and at most 10", s.d_gamma);
  wants(!s.d_constant || (*s.d_constant >= 0 && *s.d_constant <= 1e6f), "--d-constant",
        "auto or a number from 0 to 1e6", s.d_constant.value_or(0));
  wants(s.clamp >= 0, "--clamp", "0 (off) or a positive radiance", s.clamp);
  wants(s.threads >= 0 && s.threads <= 1024, "--threads", "0 (all) to 1024", s.threads);
  wants(s.camera >= 0 && s.camera < static_cast<int>(scene.cameras.size()), "--camera",
        "a camera from 0 to " + std::to_string(static_cast<int>(scene.cameras.size()) - 1), s.camera);
  if (s.crop_width > 0 || s.crop_height > 0)
    if (s.crop_x < 0 || s.crop_y < 0 || s.crop_width < 1 || s.crop_height < 1 ||
        s.crop_x + s.crop_width > s.width || s.crop_y + s.crop_height > s.height)
      base::fail("--crop: wanted a rectangle inside ", s.width, " x ", s.height, ", found ", s.crop_x, ",",
                 s.crop_y, ",", s.crop_width, ",", s.crop_height);
}

}  // namespace

struct Renderer::Impl {
  const scene::Scene& scene;
  Settings settings;
  std::optional<surface::Surfaces> surfaces;
  std::unique_ptr<accel::Accel> accel;
  std::unique_ptr<light::Lights> lights;
  std::unique_ptr<World> world;
  CameraRays camera;
  std::optional<tbb::global_control> more_threads;
  double build_seconds = 0;
  mutable std::atomic<std::uint64_t> rays{0};
  std::vector<bool> has_filter;  // of the instances, as `accel` was built
  int x0, y0, width, height;

  Impl(const scene::Scene& s, const Settings& t)
      : scene(s),
        settings((check(t, s), t)),
        camera(s.cameras[static_cast<size_t>(t.camera)], t.width, t.height) {
    build(t, true);
  }

  // Makes what is not there yet, or no longer what the scene and `t` ask for.
  void build(const Settings& t, bool lights_changed) {
    check(t, scene);
    const auto start = std::chrono::steady_clock::now();
    const bool first = !accel, other_threads = first || t.threads != settings.threads;
    const bool other_isa = !first && t.fastest_isa != settings.fastest_isa;
    const bool other_model = first || model_of(t.shader) != model_of(settings.shader);
    const bool light_sampling_only = t.shader == Shader::path_nomis;
    if ((settings.shader == Shader::path_nomis) != light_sampling_only) lights_changed = true;
    settings = t;
    camera = CameraRays(scene.cameras[static_cast<size_t>(t.camera)], t.width, t.height);
    x0 = t.crop_x, y0 = t.crop_y;
    width = t.crop_width > 0 ? t.crop_width : t.width;
    height = t.crop_width > 0 ? t.crop_height : t.height;
    if (other_threads) more_threads.reset();
    if (other_threads &&
        t.threads > 0)  // oneTBB starts no more workers than the machine has cores unless told
      more_threads.emplace(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(t.threads));
    world.reset();
    if (other_model) {  // textures are filtered otherwise, and the lights refer to them
      lights.reset();
      surfaces.emplace(scene, model_of(t.shader));
    }
    arena().execute([&] {
      if (const auto now_filtered = surfaces->filtered(); first || other_isa || now_filtered != has_filter) {
        has_filter = now_filtered;
        accel =
            std::make_unique<accel::Accel>(scene, t.fastest_isa, has_filter,
                                           [this](const accel::Ray& r, const accel::Hit& h, std::uint32_t k) {
                                             return surfaces->accepts(r, h, k);
                                           });
      }
      if (lights_changed || !lights)
        lights = std::make_unique<light::Lights>(scene, *surfaces, light_sampling_only);
    });
    world = std::make_unique<World>(
        World{*accel,
              *surfaces,
              *lights,
              model_of(t.shader),
              {t.d_gamma, t.d_constant},
              std::any_of(scene.materials.begin(), scene.materials.end(),
                          [](const scene::Material& m) { return m.alpha_mode == scene::AlphaMode::blend; }),
              {},
              t.shader == Shader::direct ? std::min(t.depth, 1) : t.depth,
              t.hide_environment,
              light_sampling_only});
    for (const scene::Material& m : scene.materials)
      world->plain.push_back(bsdf::make(world->model, world->gtr, surface::plain(m)));
    build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  tbb::task_arena arena() const {
    return settings.threads > 0 ? tbb::task_arena(settings.threads) : tbb::task_arena();
  }

  // Offset from the pixel's upper left corner. Each sample stays in its pixel: the filter is a density, not a
  // weight.
  float filtered(float u) const {
    switch (settings.filter) {
      case Filter::box:
        return u;
      case Filter::triangle:
        return .5f + math::sample_triangle_filter(u);
      case Filter::blackman_harris: {
        static const math::BlackmanHarris table;  // takes milliseconds, as long as some pictures
        return .5f + table.sample(u);
      }
    }
    return u;
  }

  math::Sampler sampler(int x, int y, int replicate, int index) const {
    const auto kind =
        settings.sampler == SamplerKind::sobol ? math::Sampler::Kind::sobol : math::Sampler::Kind::random;
    return {kind, settings.seed, x, y, replicate, static_cast<std::uint32_t>(index)};
  }
  accel::Ray camera_ray(int x, int y, const math::Vec4& u) const {
    return camera.ray(static_cast<float>(x) + filtered(u.x), static_cast<float>(y) + filtered(u.y));
  }
  // To the length of --clamp, with its parts.
  void clamp(Vec3& radiance, Parts* parts) const {
    if (!(settings.clamp > 0)) return;
    const float length = math::length(radiance);
    if (!(length > settings.clamp)) return;
    radiance *= settings.clamp / length;
    if (parts)
      for (Vec3& part : *parts) part *= settings.clamp / length;
  }

  // What add_samples works with, made once for a tile: made anew for each pixel and pass it took 2 to 3 % of
  // the instructions of a picture of few samples.
  struct Room {
    std::vector<math::Sampler> samplers;
    std::array<First, block_size> first;
    std::array<Reused, block_size> now, before;
    std::array<Vec3, block_size> sums;
    std::array<Parts, block_size> values;
  };

  // Adds samples from `begin` until `end` of a replicate of pixels: of one, or of a block that reuses paths.
  void add_samples(image::Film& film, std::span<const math::IVec2> pixels, int replicate, int begin, int end,
                   const Sharing& sharing, const Technique& technique, Spread* spread,
                   std::span<image::Film> parts, std::uint64_t& traced, Room& room) const {
    const size_t n = pixels.size();
    auto& [samplers, first, now, before, sums, values] = room;
    samplers.clear();
    for (const math::IVec2& at : pixels) samplers.push_back(sampler(x0 + at.x, y0 + at.y, replicate, 0));
    std::uint64_t reconnections = 0;
    for (int i = begin; i < end;) {
      // Paths i and those that share its camera ray, which may have begun in an earlier call.
      const int number = (i - sharing.from) / technique.together;
      const int last = std::min(end, sharing.from + (number + 1) * technique.together);
      for (size_t k = 0; k < n; ++k) {
        samplers[k].set_index(static_cast<std::uint32_t>(sharing.rays + number));
        const math::Vec4 u = samplers[k].get(0);
        find_first(*world, camera_ray(x0 + pixels[k].x, y0 + pixels[k].y, u), samplers[k], traced, first[k]);
        if (technique.together == 1) first[k].direction = {u.z, u.w};
      }
      for (; i < last; ++i) {
        for (math::Sampler& s : samplers) s.set_index(static_cast<std::uint32_t>(i));
        const std::span<Parts> some = parts.empty() ? std::span<Parts>() : std::span(values).first(n);
        if (n == 1)
          now[0] = {radiance(*world, first[0], samplers[0], traced, parts.empty() ? nullptr : values.data()),
                    Vec3(0), Vec3(0)};
        else
          reconnections +=
              radiance(*world, std::span(first).first(n), samplers, traced, std::span(now).first(n), some);
        for (size_t k = 0; k < n; ++k) {
          const int x = pixels[k].x, y = pixels[k].y;
          Vec3 sum = now[k].own + now[k].shared;
          clamp(sum, some.empty() ? nullptr : &values[k]);
          film.add(x, y, replicate, sum);
          for (size_t part = 0; part < parts.size(); ++part)
            parts[part].add(x, y, replicate, values[k][part]);
          if (spread && (i - begin) % 2 == 1) {
            const auto half_square = [](const Vec3& a, const Vec3& b) { return math::dot(a - b, a - b) / 2; };
            const Vec3 mean = (sum + sums[k]) * .5f;
            spread->pairs.add(x, y, replicate,
                              {half_square(sum, sums[k]), math::dot(mean, mean),
                               static_cast<float>(reconnections) / static_cast<float>(n)});
            spread->reuse.add(
                x, y, replicate,
                {half_square(now[k].own, before[k].own), half_square(now[k].shared, before[k].shared),
                 half_square(now[k].alone, before[k].alone)});
          }
          sums[k] = sum;
        }
        if ((i - begin) % 2 == 1) reconnections = 0;
        if (spread) before = now;
      }
    }
  }

  // Runs body(x, y, rays, room) for every pixel of the crop, or for those of every `step`-th row and column,
  // in tiles. False if stopped.
  template <typename Body>
  bool for_each_pixel(const Body& body, const Progress& progress = {},
                      const std::atomic<bool>* stop = nullptr, int step = 1) const {
    const int columns = (width + tile_size - 1) / tile_size, rows = (height + tile_size - 1) / tile_size;
    std::atomic<int> done{0};
    std::atomic<bool> stopped{false};
    std::mutex mutex;
    auto last = std::chrono::steady_clock::now();
    arena().execute([&] {
      tbb::parallel_for(
          tbb::blocked_range<int>(0, columns * rows, 1),
          [&](const tbb::blocked_range<int>& range) {
            const FlushDenormals flush;
            Room room;
            const auto report = [&] {
              if (stop && *stop) stopped = true;
              const std::unique_lock lock(mutex, std::try_to_lock);
              const auto now = std::chrono::steady_clock::now();
              const int finished = done;
              if (!progress || !lock ||
                  (now - last < std::chrono::milliseconds(100) && finished < columns * rows))
                return;
              last = now;
              const double fraction = static_cast<double>(finished) / (columns * rows);
              if (!progress({fraction, rays})) stopped = true;
            };
            for (int tile = range.begin(); tile != range.end(); ++tile) {
              if (stop && *stop) stopped = true;
              std::uint64_t traced = 0;  // not yet added to `rays`
              const int left = tile % columns * tile_size, top = tile / columns * tile_size;
              for (int y = top; y < std::min(top + tile_size, height); y += step)
                for (int x = left; x < std::min(left + tile_size, width); x += step) {
                  if (stopped) {
                    rays += traced;
                    return;
                  }
                  body(x, y, traced, room);
                  if (traced < rays_between_reports) continue;
                  rays += std::exchange(traced, 0);
                  report();
                }
              rays += traced;
              ++done;
              report();
            }
          },
          tbb::simple_partitioner());
    });
    return !stopped || done == columns * rows;
  }
};

Renderer::Renderer(const scene::Scene& scene, const Settings& settings)
    : impl_(std::make_unique<Impl>(scene, settings)) {}
Renderer::~Renderer() = default;

void Renderer::refresh(const Settings& settings, bool lights_changed) {
  impl_->build(settings, lights_changed);
}

image::Film Renderer::film() const {
  const Shader shader = impl_->settings.shader;
  const bool data = shader == Shader::normal || shader == Shader::position || shader == Shader::texcoord;
  return {impl_->width, impl_->height, impl_->settings.replicates,
          data ? image::Film::Holds::data : image::Film::Holds::radiance};
}

bool Renderer::render(image::Film& film, int first, int count, const Progress& progress,
                      std::span<image::Film> parts, const std::atomic<bool>* stop) const {
  // Samples below n of replicate r are those with numbers s = r, r + replicates, ... below n.
  const int replicates = impl_->settings.replicates;
  const auto below = [replicates](int n) {
    return [n, replicates](int, int, int r) { return (n - r + replicates - 1) / replicates; };
  };
  return render(film, below(first), below(first + count), {}, nullptr, progress, parts, stop);
}

bool Renderer::render(image::Film& film, const Counts& done, const Counts& wanted, const Sharing& sharing,
                      Spread* spread, const Progress& progress, std::span<image::Film> parts,
                      const std::atomic<bool>* stop) const {
  const Impl& m = *impl_;
  const Shader shader = m.settings.shader;
  if (!traces_paths(shader)) {
    if (!parts.empty()) base::fail("--layers lobes: wanted a --shader that traces paths, found another");
    return m.for_each_pixel(
        [&](int x, int y, std::uint64_t& traced, Impl::Room&) {
          for (int r = 0; r < m.settings.replicates; ++r)
            for (int i = done(x, y, r), end = wanted(x, y, r); i < end; ++i) {
              math::Sampler sampler = m.sampler(m.x0 + x, m.y0 + y, r, i);
              const accel::Ray ray = m.camera_ray(m.x0 + x, m.y0 + y, sampler.get(0));
              film.add(x, y, r, shade(*m.world, shader, ray, sampler, traced));
            }
        },
        progress, stop);
  }
  const bool can_reuse = !m.world->blended;
  return m.for_each_pixel(
      [&](int left, int top, std::uint64_t& traced, Impl::Room& room) {
        const Technique technique = sharing.technique ? sharing.technique(left, top) : Technique();
        std::array<math::IVec2, block_size> block;
        size_t n = 0;
        for (int y = top; y < std::min(top + block_side, m.height); ++y)
          for (int x = left; x < std::min(left + block_side, m.width); ++x) block[n++] = {x, y};
        const size_t together = technique.reuse && can_reuse ? n : 1;
        for (size_t k = 0; k < n; k += together)
          for (int r = 0; r < m.settings.replicates; ++r)
            m.add_samples(film, std::span(block).subspan(k, together), r, done(block[k].x, block[k].y, r),
                          wanted(block[k].x, block[k].y, r), sharing, technique, spread, parts, traced, room);
      },
      progress, stop, block_side);
}

std::optional<surface::Point> Renderer::first_surface(float x, float y) const {
  const accel::Ray ray = impl_->camera.ray(x, y);
  accel::Hit hit;
  if (!impl_->accel->closest(ray, 0, hit)) return std::nullopt;
  return impl_->surfaces->at(ray, hit);
}

std::span<const std::string> part_names() {
  static const std::string names[part_count] = {
      "emission",        "diffuse.direct",    "diffuse.indirect", "sheen.direct",      "sheen.indirect",
      "specular.direct", "specular.indirect", "clearcoat.direct", "clearcoat.indirect"};
  return names;
}

image::Image Renderer::first_hit(Shader shader, bool depth) const {
  const Impl& m = *impl_;
  image::Image result(m.width, m.height);
  m.for_each_pixel([&](int x, int y, std::uint64_t& traced, Impl::Room&) {
    const accel::Ray ray =
        m.camera.ray(static_cast<float>(m.x0 + x) + .5f, static_cast<float>(m.y0 + y) + .5f);
    math::Sampler sampler(math::Sampler::Kind::random, m.settings.seed, x, y, 0, 0);
    if (depth) {
      accel::Hit hit;
      ++traced;
      if (m.accel->closest(ray, 0, hit)) result.at(x, y) = Vec3(m.surfaces->at(ray, hit).distance);
    } else {
      result.at(x, y) = shade(*m.world, shader, ray, sampler, traced);
    }
  });
  return result;
}

std::uint64_t Renderer::rays() const { return impl_->rays; }
double Renderer::build_seconds() const { return impl_->build_seconds; }
std::string Renderer::isa() const { return impl_->accel->isa(); }

std::string Renderer::summary() const {
  const Impl& m = *impl_;
  size_t triangles = 0;
  for (const scene::Instance& i : m.scene.instances)
    triangles += m.scene.meshes[static_cast<size_t>(i.mesh)].triangles.size();
  size_t filtered = 0;
  for (const bool f : m.has_filter) filtered += f;
  std::ostringstream out;
  out << "geometry: " << triangles << " triangles in " << m.scene.instances.size() << " instances of "
      << m.scene.meshes.size() << " meshes, " << filtered << " instances culled, masked or blended\n"
      << "lights: " << m.scene.lights.size() << " punctual, " << m.lights->emitters()
      << " emissive triangles and rectangles, "
      << (m.lights->has_environment() ? "an environment" : "no environment") << "\n"
      << "Embree instruction set: " << m.accel->isa() << "\n";
  return out.str();
}

}  // namespace integrator
