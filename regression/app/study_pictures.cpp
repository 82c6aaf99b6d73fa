#include "app/study_pictures.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "app/run.h"
#include "base/error.h"
#include "image/hash.h"
#include "image/io.h"

namespace app {
namespace {

namespace fs = std::filesystem;

std::string read_all(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) base::fail_in(file, "", "a readable file", "none");
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::uint32_t word(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  if (at + 4 <= bytes.size()) std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

std::string bytes_of(std::uint32_t value) { return std::string(reinterpret_cast<const char*>(&value), 4); }

// A render whose replicates have changed: mean and variance anew.
image::Render from_replicates(image::Render picture, std::vector<image::Image> replicates) {
  const double count = static_cast<double>(replicates.size());
  if (count < 2) base::fail("study: wanted pictures with replicates, found none");
  for (std::size_t i = 0; i < picture.mean.data.size(); ++i) {
    double sum = 0, squares = 0;
    for (const image::Image& r : replicates) sum += r.data[i];
    for (const image::Image& r : replicates) squares += std::pow(r.data[i] - sum / count, 2);
    picture.mean.data[i] = static_cast<float>(sum / count);
    picture.variance->data[i] = static_cast<float>(squares / (count - 1) / count);
  }
  for (std::size_t r = 0; r < replicates.size(); ++r)
    picture.layers["replicate" + std::to_string(r)] = std::move(replicates[r]);
  return picture;
}

}  // namespace

std::string without_base_colour(const std::string& scene_file, const std::string& folder) {
  const std::string bytes = read_all(scene_file);
  const bool binary = bytes.compare(0, 4, "glTF") == 0;
  const std::size_t length = binary ? word(bytes, 12) : bytes.size();
  if (binary && (bytes.size() < 20 || length > bytes.size() - 20))
    base::fail_in(scene_file, "chunk 0", "a length inside the file", std::to_string(length));
  nlohmann::json scene;
  try {
    scene = nlohmann::json::parse(bytes.substr(binary ? 20 : 0, length));
    if (scene.contains("materials"))
      for (auto& material : scene["materials"]) {
        auto& pbr = material["pbrMetallicRoughness"];
        const double alpha =
            pbr.contains("baseColorFactor") ? pbr["baseColorFactor"].at(3).get<double>() : 1.;
        pbr["baseColorFactor"] = {0., 0., 0., alpha};
      }
  } catch (const nlohmann::json::exception& error) {
    base::fail(scene_file, ": wanted glTF, found: ", error.what());
  }
  std::string text = scene.dump();
  if (binary) {
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::string rest = bytes.substr(20 + length);
    const auto size = static_cast<std::uint32_t>(20 + text.size() + rest.size());
    text = bytes.substr(0, 8) + bytes_of(size) + bytes_of(static_cast<std::uint32_t>(text.size())) +
           bytes.substr(16, 4) + text + rest;
  }
  fs::create_directories(folder);
  for (const auto& beside : fs::directory_iterator(fs::path(scene_file).parent_path()))
    if (beside.is_regular_file() && beside.path().extension() != ".glb" &&
        beside.path().extension() != ".gltf")
      fs::copy_file(beside.path(), fs::path(folder) / beside.path().filename(),
                    fs::copy_options::update_existing);
  const std::string file = (fs::path(folder) / fs::path(scene_file).filename()).string();
  image::write_file(file, text.data(), text.size());
  return file;
}

image::Render scaled(const image::Render& picture, const std::function<double(int, int)>& factor) {
  std::vector<image::Image> replicates;
  for (const image::Image* r : image::replicates(picture)) {
    replicates.push_back(*r);
    for (int y = 0; y < r->height; ++y)
      for (int x = 0; x < r->width; ++x)
        for (int c = 0; c < r->channels; ++c)
          replicates.back().at(x, y, c) = static_cast<float>(r->at(x, y, c) * factor(x, y));
  }
  return from_replicates(picture, std::move(replicates));
}

image::Render mixed(const image::Render& picture, const image::Render& other, double share) {
  const std::vector<const image::Image*> ours = image::replicates(picture), others = image::replicates(other);
  if (ours.size() != others.size()) base::fail("study: wanted as many replicates in both pictures");
  std::vector<image::Image> replicates;
  for (std::size_t k = 0; k < ours.size(); ++k) {
    replicates.push_back(*ours[k]);
    for (std::size_t i = 0; i < ours[k]->data.size(); ++i)
      replicates.back().data[i] =
          static_cast<float>((1 - share) * ours[k]->data[i] + share * others[k]->data[i]);
  }
  return from_replicates(picture, std::move(replicates));
}

suite::Golden as_golden(const suite::Case& c, const image::Render& picture) {
  suite::Golden golden;
  golden.render = picture;
  golden.render.header.try_emplace("assay:replicates", c.replicates);
  golden.pixel_hash = image::pixel_hash(picture.mean);
  golden.exposures = metric::automatic_exposures(picture.mean).value_or(metric::Exposures{0, 0, 1});
  golden.replicate_tiles = suite::replicate_tiles(picture);
  return golden;
}

void for_each_case(std::size_t cases, const std::function<void(std::size_t)>& study) {
  std::atomic<std::size_t> next{0};
  std::mutex guard;
  std::exception_ptr failure;
  const auto work = [&] {
    for (std::size_t i = next++; i < cases; i = next++) try {
        study(i);
      } catch (...) {
        const std::lock_guard lock(guard);
        if (!failure) failure = std::current_exception();
        next = cases;
      }
  };
  std::vector<std::thread> workers(
      std::min<std::size_t>(cases, std::max(1u, std::thread::hardware_concurrency())));
  for (std::thread& w : workers) w = std::thread(work);
  for (std::thread& w : workers) w.join();
  if (failure) std::rethrow_exception(failure);
}

std::vector<image::Render> made_pictures(const suite::RendererCommand& renderer,
                                         const std::vector<suite::Job>& jobs, const std::string& scratch) {
  const std::vector<suite::Outcome> outcomes = renderer.run(jobs, scratch);
  std::vector<image::Render> pictures;
  for (std::size_t j = 0; j < jobs.size(); ++j) {
    if (!outcomes[j].ok) base::fail("study: ", outcomes[j].error);
    pictures.push_back(read_job(renderer, jobs[j], scratch));
    fs::remove(jobs[j].out);
  }
  return pictures;
}

}  // namespace app
