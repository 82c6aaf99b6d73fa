// The comparison's own test: mistakes planted in Assay's evaluation, each of which the soup must reject, and
// by which subsets. A subset rejects a model by the same verdict that soup_test.cpp demands: a sample that
// float does not explain, or, where both roughnesses are at least .3, more than 0.1 % beyond 1e-4 or any
// beyond 1e-3.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "blender/soup.h"
#include "blender/soup_verdict.h"

namespace {

using namespace blender;
using bsdf::Bsdf;
using bsdf::Parameters;
using math::Vec3;

double lambda(double cosine, double alpha2) {
  return (std::sqrt(1 + alpha2 * (1 - cosine * cosine) / (cosine * cosine)) - 1) / 2;
}
void scale_alpha(Bsdf& b, float by) {
  for (float* alpha : {&b.specular.ax, &b.specular.ay, &b.specular.ax_g, &b.specular.ay_g}) *alpha *= by;
}
void set_coat_alpha(Bsdf& b, float alpha) {
  b.clearcoat.alpha = alpha;
  b.clearcoat.log_alpha2 = alpha < 1 ? 2 * std::log(static_cast<double>(alpha)) : 0;
}
// The base colour over this luminance, white if black.
Vec3 hue(const Vec3& base, double r, double g, double b) {
  const double y = r * base.x + g * base.y + b * base.z;
  return y > 0 ? base * static_cast<float>(1 / y) : Vec3(1);
}

struct Planted {
  Fault fault;
  std::vector<const char*> rejected_by;  // at least
};

const std::vector<Planted>& planted() {
  static const std::vector<Planted> faults = {
      {{"diffuse: Lambert", nullptr, [](Bsdf& b, const Parameters&) { b.diffuse.retro = -1; }}, {"diffuse"}},
      {{"diffuse: retro-reflection 1 % low", nullptr,
        [](Bsdf& b, const Parameters&) { b.diffuse.retro *= .99f; }},
       {"diffuse"}},
      {{"diffuse: dimmed by the specular lobe", nullptr,
        [](Bsdf& b, const Parameters& p) { b.diffuse.weight *= 1 - .08f * p.specular; }},
       {"specular", "everything"}},
      {{"sheen 3 % low", nullptr, [](Bsdf& b, const Parameters&) { b.sheen.weight *= .97f; }},
       {"sheen", "sheen tinted", "everything"}},
      {{"sheen's tint by Disney's luma", nullptr,
        [](Bsdf& b, const Parameters& p) {
          const Vec3 tint = hue(p.base_color, .3, .6, .1);
          b.sheen.weight = (Vec3(1 - p.sheen_tint) + tint * p.sheen_tint) * (p.sheen * (1 - p.metallic));
        }},
       {"sheen tinted", "everything"}},
      {{"specular tint by Rec.709's luma", nullptr,
        [](Bsdf& b, const Parameters& p) {
          const Vec3 tint = hue(p.base_color, .2126729, .7151522, .0721750);
          const Vec3 dielectric = (Vec3(1 - p.specular_tint) + tint * p.specular_tint) * (.08f * p.specular);
          b.specular.f0 = dielectric * (1 - p.metallic) + p.base_color * p.metallic;
        }},
       {"specular tinted", "everything"}},
      {{"specular: alpha 1 % high", nullptr, [](Bsdf& b, const Parameters&) { scale_alpha(b, 1.01f); }},
       {"specular", "metal", "metal, narrow", "anisotropic", "anisotropic, narrow", "everything"}},
      {{"specular: alpha 0.1 % high", nullptr, [](Bsdf& b, const Parameters&) { scale_alpha(b, 1.001f); }},
       {"specular", "metal", "metal, narrow", "anisotropic", "anisotropic, narrow", "everything"}},
      {{"specular: Schlick's Fresnel", nullptr,
        [](Bsdf& b, const Parameters&) { b.specular.dielectric = false; }},
       {"specular", "metal", "everything"}},
      {{"specular: index 1.5 for a metal", nullptr,
        [](Bsdf& b, const Parameters& p) {
          if (p.metallic == 1) b.specular.eta = 1.5, b.specular.fresnel0 = .04;
        }},
       {"metal", "anisotropic"}},
      {{"metallic 0.1 % low", [](Parameters& p, double&) { p.metallic *= .999f; }},
       {"metal", "metallic share"}},
      {{"anisotropy: rotation the other way", [](Parameters&, double& turns) { turns = -turns; }},
       {"anisotropic", "anisotropic, narrow", "everything"}},
      {{"anisotropy: axes swapped", nullptr,
        [](Bsdf& b, const Parameters&) {
          std::swap(b.specular.ax, b.specular.ay);
          std::swap(b.specular.ax_g, b.specular.ay_g);
        }},
       {"anisotropic", "anisotropic, narrow", "everything"}},
      {{"anisotropy: alpha above 1 not clamped", nullptr,
        [](Bsdf& b, const Parameters& p) {
          b.specular.ax = b.specular.ax_g = p.roughness * p.roughness / std::sqrt(1 - .9f * p.anisotropic);
        }},
       {"anisotropic", "everything"}},
      {{"no G1", nullptr, nullptr,
        [](double o, double i, double ao, double ai) { return (1 + lambda(o, ao)) * (1 + lambda(i, ai)); }},
       {"specular", "metal", "anisotropic", "clearcoat", "everything", "everything, grazing"}},
      {{"G1 of the light missing", nullptr, nullptr,
        [](double, double i, double, double ai) { return 1 + lambda(i, ai); }},
       {"specular", "metal", "anisotropic", "clearcoat", "everything", "everything, grazing"}},
      {{"G height-correlated (Blender 3.5)", nullptr, nullptr,
        [](double o, double i, double ao, double ai) {
          return (1 + lambda(o, ao)) * (1 + lambda(i, ai)) / (1 + lambda(o, ao) + lambda(i, ai));
        }},
       {"specular", "metal", "anisotropic", "clearcoat", "everything"}},
      {{"clearcoat x 4", nullptr, [](Bsdf& b, const Parameters&) { b.clearcoat.weight *= 4; }},
       {"clearcoat", "clearcoat, narrow", "everything"}},
      {{"clearcoat: alpha 1 % high", nullptr,
        [](Bsdf& b, const Parameters&) { set_coat_alpha(b, b.clearcoat.alpha * 1.01f); }},
       {"clearcoat", "clearcoat, narrow"}},
      {{"clearcoat: alpha = roughness", nullptr,
        [](Bsdf& b, const Parameters& p) { set_coat_alpha(b, p.clearcoat_roughness); }},
       {"clearcoat", "clearcoat, narrow", "everything"}},
      {{"clearcoat: Schlick's Fresnel", nullptr,
        [](Bsdf& b, const Parameters&) { b.clearcoat.dielectric = false; }},
       {"clearcoat", "everything"}},
      {{"clearcoat dims what is below it (Blender 4)", nullptr,
        [](Bsdf& b, const Parameters& p) { b.diffuse.weight *= 1 - .01f * p.clearcoat; }},
       {"everything"}},
      {{"linked normals: no bump terminator", nullptr, [](Bsdf& b, const Parameters&) { b.normals = {}; }},
       {"everything, linked normal"}},
  };
  return faults;
}

class SoupFault : public testing::Test {
 protected:
  static const Soup& soup() {
    static const Soup read = read_soup(std::string(ASSAY_SOURCE_DIR) + "/reference/blender/soup/soup.exr");
    return read;
  }
  // Whether subset `index` rejects.
  static bool rejects(int index, const Fault& fault) {
    const Verdict v = judge(
        soup(), bsdf::Model::principled, [=](const Configuration& c) { return c.subset == index; }, fault);
    const std::string& name = soup().subsets[static_cast<std::size_t>(index)];
    const bool rough = name.find("narrow") == std::string::npos &&
                       name.find("grazing") == std::string::npos && name != "mirror threshold";
    return !v.within_float() || (rough && !v.close());
  }
};

TEST_F(SoupFault, NothingIsRejectedWithoutAFault) {
  for (int i = 0; i < static_cast<int>(soup().subsets.size()); ++i)
    EXPECT_FALSE(rejects(i, {})) << soup().subsets[static_cast<std::size_t>(i)];
}

TEST_F(SoupFault, EveryPlantedFaultIsRejectedByEachSubsetThatShowsItAndStandsInTheBulletin) {
  std::ifstream file(std::string(ASSAY_SOURCE_DIR) + "/docs/blender.md");
  const std::string bulletin(std::istreambuf_iterator<char>(file), {});
  for (const auto& [fault, expected] : planted()) {
    std::string alone;  // the subsets that show a lobe alone
    std::vector<std::string> rejecting;
    for (std::size_t i = 0; i < soup().subsets.size(); ++i) {
      const std::string& name = soup().subsets[i];
      if (!rejects(static_cast<int>(i), fault)) continue;
      rejecting.push_back(name);
      if (name.find("everything") != 0) alone += (alone.empty() ? "" : "; ") + name;
    }
    const auto mixed = std::count_if(rejecting.begin(), rejecting.end(),
                                     [](const std::string& name) { return name.find("everything") == 0; });
    const std::string row =
        std::string("| ") + fault.name + " | " + alone + " | " + std::to_string(mixed) + " of 4 |";
    std::printf("%s\n", row.c_str());
    EXPECT_NE(bulletin.find(row), std::string::npos) << "docs/blender.md has another row than\n" << row;
    for (const char* name : expected)
      EXPECT_NE(std::find(rejecting.begin(), rejecting.end(), name), rejecting.end())
          << fault.name << " is not found by: " << name;
  }
}

// A fault must not be found where its lobe is not.
TEST_F(SoupFault, ASubsetIsBlindToFaultsOfLobesItDoesNotShow) {
  for (const auto& [fault, expected] : planted()) {
    const std::string name = fault.name;
    for (std::size_t i = 0; i < soup().subsets.size(); ++i) {
      const std::string& subset = soup().subsets[i];
      const bool coat = subset.find("coat") != std::string::npos;
      if ((subset == "diffuse" && name.find("diffuse") != 0) || (coat && name.find("specular:") == 0) ||
          (subset == "metal" && name.find("clearcoat") == 0)) {
        EXPECT_FALSE(rejects(static_cast<int>(i), fault)) << name << " in " << subset;
      }
    }
  }
}

}  // namespace
