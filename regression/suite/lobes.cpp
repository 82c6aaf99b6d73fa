#include "suite/lobes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace suite {
namespace {

constexpr double luma[3] = {.2126, .7152, .0722};
constexpr const char* variance = ".variance";
// Of the picture's mean: below it, two sums of floats differ by their order.
constexpr double rounding = 1e-6;

}  // namespace

std::vector<LobeMean> lobe_means(const image::Render& render) {
  std::vector<LobeMean> lobes;
  for (const auto& [name, mean] : render.layers) {
    const auto noise = render.layers.find(name + variance);
    if (noise == render.layers.end() || mean.channels != 3 || !noise->second.same_shape(mean)) continue;
    LobeMean lobe{name, 0, 0};
    double variance_sum = 0;
    for (std::size_t i = 0; i < mean.data.size(); i += 3) {
      // The channels of a sample rise and fall together, so deviations add up.
      double deviation = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        lobe.mean += luma[c] * static_cast<double>(mean.data[i + c]);
        deviation += luma[c] * std::sqrt(static_cast<double>(noise->second.data[i + c]));
      }
      variance_sum += deviation * deviation;
    }
    const double pixels = static_cast<double>(mean.pixels());
    lobe.mean /= pixels;
    lobe.standard_error = std::sqrt(variance_sum) / pixels;
    lobes.push_back(lobe);
  }
  return lobes;
}

std::string to_text(const std::vector<LobeMean>& lobes) {
  nlohmann::json out = nlohmann::json::object();
  for (const LobeMean& l : lobes) out[l.name] = {l.mean, l.standard_error};
  return out.dump();
}

std::vector<LobeMean> lobes_from_text(const std::string& text, const std::string& file) {
  std::vector<LobeMean> lobes;
  const nlohmann::json in = nlohmann::json::parse(text, nullptr, false);
  const auto fits = [](const nlohmann::json& v) {
    return v.is_array() && v.size() == 2 && v[0].is_number() && v[1].is_number();
  };
  if (!in.is_object() || !std::all_of(in.begin(), in.end(), fits))
    base::fail_in(file, "assay:lobes", "{\"lobe\": [mean, standard error], ...}", text.substr(0, 40));
  for (const auto& [name, value] : in.items()) lobes.push_back({name, value[0], value[1]});
  return lobes;
}

std::string moved_lobes(const std::vector<LobeMean>& golden, const std::vector<LobeMean>& now, int most) {
  struct Move {
    const LobeMean *was, *is;
    double by() const { return is->mean - was->mean; }
  };
  std::vector<Move> moves;
  double whole = 0;
  for (const LobeMean& was : golden) {
    whole += was.mean;
    const auto is = std::find_if(now.begin(), now.end(), [&](const auto& l) { return l.name == was.name; });
    if (is != now.end()) moves.push_back({&was, &*is});
  }
  std::erase_if(moves, [&](const Move& m) { return !(std::abs(m.by()) > rounding * whole); });
  std::sort(moves.begin(), moves.end(),
            [](const Move& a, const Move& b) { return std::abs(a.by()) > std::abs(b.by()); });
  std::string text;
  for (std::size_t i = 0; i < std::min(moves.size(), static_cast<std::size_t>(most)); ++i) {
    const Move& m = moves[i];
    char line[160];
    if (m.was->mean > 0)
      std::snprintf(line, sizeof line, " %+.3g %%", 100 * m.by() / m.was->mean);
    else
      std::snprintf(line, sizeof line, " from 0 to %.2g", m.is->mean);
    text += (i ? ", " : "by lobe: ") + m.was->name + line;
    const double error = std::hypot(m.was->standard_error, m.is->standard_error);
    if (error > 0) {
      const double sigmas = std::abs(m.by()) / error;
      std::snprintf(line, sizeof line, " (%.*f sigma)", sigmas < 10 ? 1 : 0, sigmas);
      text += line;
    }
  }
  return text;
}

}  // namespace suite
