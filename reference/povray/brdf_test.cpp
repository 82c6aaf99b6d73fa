// The renderer's BRDF against POV-Ray's: every pixel of the stored renders/brdf_NAME.exr (made by brdf.py
// from formulas written apart from ours, evaluated in double) is evaluated again by bsdf::eval. brdf.json
// says what each picture is.
//
// Pixel (i, j) of N x N, j from the top: n = (X, Y, sqrt(1 - X^2 - Y^2)), X = (2i+1)/N - 1, Y = 1 - (2j+1)/N;
// the eye is at +z. Tangent (n.z, 0, -n.x), turned counter-clockwise about n. Values are f (n.l).
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bsdf/disney.h"

namespace {

using math::Vec3;
using Json = nlohmann::json;

const std::string folder = std::string(ASSAY_SOURCE_DIR) + "/reference/povray/";
constexpr double tolerance = 1e-5;  // of a picture's largest value

struct Vec3d {
  double x = 0, y = 0, z = 0;
};
double dot(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vec3d unit(const Vec3d& v) {
  const double scale = 1 / std::sqrt(dot(v, v));
  return {v.x * scale, v.y * scale, v.z * scale};
}
Vec3 rounded(const Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

Json listing() {
  std::ifstream file(folder + "brdf.json");
  return Json::parse(file);
}

const Json& configuration(const Json& list, const std::string& name) {
  for (const Json& entry : list["configurations"])
    if (entry["name"] == name) return entry;
  throw std::runtime_error("brdf.json has no configuration " + name);
}

std::vector<float> witness(const std::string& name, int size) {
  const std::string path = folder + "renders/brdf_" + name + ".exr";
  const auto file = OIIO::ImageInput::open(path);
  if (!file || file->spec().width != size || file->spec().height != size || file->spec().nchannels < 3) {
    ADD_FAILURE() << path << ": wanted a picture of " << size << " x " << size
                  << "; brdf.py --all remakes it";
    return {};
  }
  std::vector<float> pixels(static_cast<size_t>(size) * size * 3);
  if (!file->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, pixels.data()))
    ADD_FAILURE() << path << ": " << file->geterror();
  return pixels;
}

bsdf::Model model_of(const std::string& name) {
  if (name == "disney") return bsdf::Model::disney;
  if (name == "principled") return bsdf::Model::principled;
  if (name == "path") return bsdf::Model::path;
  if (name == "path_disney") return bsdf::Model::path_disney;
  throw std::runtime_error("brdf.json: unknown model " + name);
}

// The renderer's answer for one entry of brdf.json.
class Ours {
 public:
  explicit Ours(const Json& entry)
      : model_(model_of(entry["model"])), lobe_(entry["lobe"]), light_(unit(vector(entry["light"]))) {
    for (const auto& [key, value] : entry["parameters"].items()) {
      if (key == "base")
        parameters_.base_color = rounded(vector(value));
      else if (key == "anisotropic_rotation")
        turns_ = value;
      else if (key == "d_gamma")
        gtr_.gamma = value;
      else if (key == "d_constant")
        gtr_.constant = value.get<float>();
      else
        number(key) = value;
    }
  }

  float& number(const std::string& key) {
    auto& p = parameters_;
    if (key == "metallic") return p.metallic;
    if (key == "roughness") return p.roughness;
    if (key == "specular") return p.specular;
    if (key == "specular_tint") return p.specular_tint;
    if (key == "anisotropic") return p.anisotropic;
    if (key == "sheen") return p.sheen;
    if (key == "sheen_tint") return p.sheen_tint;
    if (key == "clearcoat") return p.clearcoat;
    if (key == "clearcoat_roughness") return p.clearcoat_roughness;
    throw std::runtime_error("brdf.json: unknown parameter " + key);
  }
  double& turns() { return turns_; }
  bsdf::Gtr& gtr() { return gtr_; }

  Vec3 at(const Vec3d& n) const {
    const Vec3d t0 = unit({n.z, 0, -n.x});
    const Vec3d b0 = cross(n, t0);
    const double c = std::cos(2 * bsdf::pi * turns_), s = std::sin(2 * bsdf::pi * turns_);
    const Vec3d t{c * t0.x + s * b0.x, c * t0.y + s * b0.y, c * t0.z + s * b0.z};
    const Vec3d b = cross(n, t);
    const auto local = [&](const Vec3d& v) { return rounded(unit({dot(v, t), dot(v, b), dot(v, n)})); };
    const Vec3 wo = local({0, 0, 1}), wi = local(light_);
    bsdf::Bsdf bsdf = bsdf::prepare(model_, gtr_, parameters_, {}, wo);
    // A single lobe: silence the others.
    if (lobe_ != "all") {
      if (lobe_ != "diffuse") bsdf.diffuse.weight = Vec3(0);
      if (lobe_ != "sheen") bsdf.sheen.weight = Vec3(0);
      if (lobe_ != "specular") bsdf.probability[static_cast<int>(bsdf::Lobe::specular)] = 0;
      if (lobe_ != "clearcoat") bsdf.probability[static_cast<int>(bsdf::Lobe::clearcoat)] = 0;
    }
    return bsdf::eval(bsdf, wo, wi).f_cos;
  }

 private:
  static Vec3d vector(const Json& v) { return {v[0], v[1], v[2]}; }

  bsdf::Model model_;
  std::string lobe_;
  Vec3d light_;
  double turns_ = 0;
  bsdf::Gtr gtr_;
  bsdf::Parameters parameters_;
};

struct Difference {
  double largest = 0, full_scale = 0;  // over pixels and channels
  int lit = 0, x = 0, y = 0;
  double relative() const { return largest / full_scale; }
};

Difference compare(const Ours& ours, const std::string& name, int size) {
  Difference d;
  const std::vector<float> theirs = witness(name, size);
  if (theirs.empty()) return d;
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      const double x = (2. * i + 1) / size - 1, y = 1 - (2. * j + 1) / size;
      const bool on_sphere = x * x + y * y < 1;
      const Vec3 our = on_sphere ? ours.at({x, y, std::sqrt(1 - x * x - y * y)}) : Vec3(0);
      const float* their = &theirs[3 * (static_cast<size_t>(j) * size + i)];
      d.lit += their[0] + their[1] + their[2] > 0;
      for (int k = 0; k < 3; ++k) {
        d.full_scale = std::max(d.full_scale, static_cast<double>(their[k]));
        const double difference = std::fabs(static_cast<double>(our[k]) - their[k]);
        if (!(difference <= d.largest)) d = {difference, d.full_scale, d.lit, i, j};  // NaN counts as larger
      }
    }
  return d;
}

class PovrayBrdf : public testing::TestWithParam<std::string> {};

TEST_P(PovrayBrdf, AgreesWithOursWithinAHundredThousandthOfFullScale) {
  const Json list = listing();
  const Difference d = compare(Ours(configuration(list, GetParam())), GetParam(), list["size"]);
  ASSERT_GT(d.lit, 100) << "the witness shows almost nothing";
  EXPECT_LT(d.relative(), tolerance) << "at pixel " << d.x << ", " << d.y << " by " << d.largest << " of "
                                     << d.full_scale;
  RecordProperty("largest_difference_of_full_scale", std::to_string(d.relative()));
  std::cout << GetParam() << ": " << d.relative() << " of full scale " << d.full_scale << '\n';
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  const Json list = listing();
  for (const Json& entry : list["configurations"]) all.push_back(entry["name"]);
  return all;
}
INSTANTIATE_TEST_SUITE_P(Stored, PovrayBrdf, testing::ValuesIn(names()),
                         [](const auto& parameter) { return parameter.param; });

TEST(PovrayBrdfList, EveryLobeOfEveryModelHasAWitnessOfItsOwn) {
  const std::pair<const char*, std::vector<const char*>> wanted[] = {
      {"disney", {"diffuse", "sheen", "specular", "clearcoat", "all"}},
      {"principled", {"diffuse", "sheen", "specular", "clearcoat", "all"}},
      {"path", {"diffuse", "specular", "all"}},
      {"path_disney", {"diffuse", "specular", "all"}},
  };
  const Json list = listing();
  const auto some = [&](auto&& is_one) {
    return std::any_of(list["configurations"].begin(), list["configurations"].end(), is_one);
  };
  for (const auto& entry : wanted) {
    const auto& model = entry.first;  // clang 14 captures no structured bindings
    const auto& lobes = entry.second;
    for (const char* lobe : lobes)
      EXPECT_TRUE(some([&](const Json& e) { return e["model"] == model && e["lobe"] == lobe; }))
          << model << ' ' << lobe;
    // And what a lobe has several forms of.
    EXPECT_TRUE(some([&](const Json& e) {
      return e["model"] == model && e["parameters"].value("metallic", 0.) > 0;
    })) << model;
    if (lobes.size() == 5) {
      EXPECT_TRUE(some([&](const Json& e) {
        return e["model"] == model && e["lobe"] == "specular" &&
               e["parameters"].value("anisotropic", 0.) > 0 &&
               e["parameters"].value("anisotropic_rotation", 0.) > 0;
      })) << model;
    }
  }
}

// The comparison's own test: faults planted on our side must be found, each far above the tolerance.
template <class Plant>
double fault(const std::string& name, Plant plant) {
  const Json list = listing();
  Ours ours(configuration(list, name));
  plant(ours);
  return compare(ours, name, list["size"]).relative();
}

TEST(PovrayBrdfFault, AnAlphaThreePerCentTooLargeIsFoundInEveryMicrofacetLobe) {
  for (const char* name : {"disney_gtr2_rough_05", "disney_gtr2_rough_02", "disney_gtr2_anisotropic",
                           "path_plastic", "path_disney_gamma_1", "path_disney_gamma_03"})
    EXPECT_GT(fault(name, [](Ours& o) { o.number("roughness") *= std::sqrt(1.03f); }), 100 * tolerance)
        << name;
  EXPECT_GT(fault("disney_clearcoat", [](Ours& o) { o.number("clearcoat_roughness") *= std::sqrt(1.03f); }),
            100 * tolerance);
}

TEST(PovrayBrdfFault, AnAlphaOneInTenThousandTooLargeIsFound) {
  EXPECT_GT(fault("disney_gtr2_rough_02", [](Ours& o) { o.number("roughness") *= 1.00005f; }), tolerance);
}

TEST(PovrayBrdfFault, ATangentTurnedTheOtherWayIsFound) {
  EXPECT_GT(fault("disney_gtr2_anisotropic_rotated", [](Ours& o) { o.turns() *= -1; }), 100 * tolerance);
}

TEST(PovrayBrdfFault, ARoughnessOffByOnePerCentIsFoundInTheDiffuseLobe) {
  EXPECT_GT(fault("disney_diffuse_rough", [](Ours& o) { o.number("roughness") = .99f; }), 100 * tolerance);
}

TEST(PovrayBrdfFault, DisneysLuminanceInPlaceOfRec709IsFoundInTheSheensTint) {
  const Json list = listing();
  Json entry = configuration(list, "principled_sheen_tinted");
  entry["model"] = "disney";
  EXPECT_GT(compare(Ours(entry), "principled_sheen_tinted", list["size"]).relative(), 100 * tolerance);
}

TEST(PovrayBrdfFault, SchlicksFresnelInPlaceOfTheDielectricCurveIsFound) {
  const Json list = listing();
  Json entry = configuration(list, "principled_dielectric");
  entry["model"] = "disney";
  EXPECT_GT(compare(Ours(entry), "principled_dielectric", list["size"]).relative(), 100 * tolerance);
}

TEST(PovrayBrdfFault, RetroReflectionInPlaceOfLambertIsFound) {
  const Json list = listing();
  Json entry = configuration(list, "path_lambert");
  entry["model"] = "path_disney";
  EXPECT_GT(compare(Ours(entry), "path_lambert", list["size"]).relative(), 100 * tolerance);
}

TEST(PovrayBrdfFault, SchlicksFresnelInPlaceOfTheDielectricCurveIsFoundInTheCoat) {
  const Json list = listing();
  for (const char* name : {"principled_clearcoat", "principled_clearcoat_glossy"}) {
    Json entry = configuration(list, name);
    entry["model"] = "disney";
    EXPECT_GT(compare(Ours(entry), name, list["size"]).relative(), 10 * tolerance) << name;
  }
}

TEST(PovrayBrdfFault, TheReportsConstantInPlaceOfTheNormalisedOneIsFound) {
  EXPECT_GT(fault("path_disney_gamma_1_auto", [](Ours& o) { o.gtr().constant = .03f; }), 100 * tolerance);
}

}  // namespace
