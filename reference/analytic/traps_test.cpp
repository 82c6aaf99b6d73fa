// Whole renders with floating-point traps: an invalid operation or a division by zero anywhere between the
// camera ray and the film stops the process. Row B23 of docs/bsdf-tests.md. Embree 3.13 itself raises both,
// in its builder and on the empty lanes of its nodes, so its functions run untrapped: this program's
// definitions of the two that the renderer calls stand before the library's.

#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <cfenv>
#include <cstdlib>

#include "gltf/load.h"
#include "integrator/render.h"

namespace {

template <typename Function, typename... Arguments>
void untrapped(const char* name, Function*, Arguments... arguments) {
  static auto* const embree = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
  const int traps = fedisableexcept(FE_ALL_EXCEPT);
  embree(arguments...);
  std::feclearexcept(FE_ALL_EXCEPT);
  feenableexcept(traps);
}

}  // namespace

extern "C" void rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* hit) {
  untrapped(__func__, rtcIntersect1, scene, context, hit);
}
extern "C" void rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  untrapped(__func__, rtcOccluded1, scene, context, ray);
}

namespace analytic {
namespace {

struct Trapped {
  const char* scene;
  integrator::Shader shader;
};

integrator::Settings settings_of(const Trapped& t) {
  integrator::Settings s;
  s.shader = t.shader;
  s.width = s.height = 48;
  s.spp = 16;
  s.depth = 8;
  s.d_gamma = 1.5f;
  s.threads = 1;  // the thread that set the traps renders
  return s;
}

class Traps : public ::testing::TestWithParam<Trapped> {};

// Embree 3.13's builder itself divides by zero (a box without extent has no scale), so the traps are set
// behind it.
TEST_P(Traps, a_whole_render_raises_no_floating_point_exception) {
  const scene::Scene scene = gltf::load(ASSAY_SCENES + std::string(GetParam().scene));
  EXPECT_EXIT(
      {
        const integrator::Renderer renderer(scene, settings_of(GetParam()));
        image::Film film = renderer.film();
        std::feclearexcept(FE_ALL_EXCEPT);
        feenableexcept(FE_INVALID | FE_DIVBYZERO);
        const bool finished = renderer.render(film, 0, 16);
        fedisableexcept(FE_ALL_EXCEPT);
        std::_Exit(finished && film.rejected() == 0 ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), "");
}

INSTANTIATE_TEST_SUITE_P(
    scenes, Traps,
    ::testing::Values(Trapped{"basic_pl.glb", integrator::Shader::path_disney},
                      Trapped{"gltf_features.glb", integrator::Shader::disney},
                      Trapped{"sun_sky.glb", integrator::Shader::principled},
                      Trapped{"many_lights.glb", integrator::Shader::principled},
                      Trapped{"clearcoat.glb", integrator::Shader::disney},
                      Trapped{"smooth_silhouette.glb", integrator::Shader::principled}),
    [](const auto& test) {
      return std::string(test.param.scene).substr(0, std::string(test.param.scene).find('.'));
    });

// The traps reach the thread that renders and outlive Embree's functions: the progress is told there, after a
// tile.
TEST(Traps, stop_a_render_that_divides_zero_by_zero) {
  const scene::Scene scene = gltf::load(ASSAY_SCENES "cornell.glb");
  EXPECT_DEATH(
      {
        const integrator::Renderer renderer(scene, settings_of({"", integrator::Shader::disney}));
        image::Film film = renderer.film();
        feenableexcept(FE_INVALID | FE_DIVBYZERO);
        renderer.render(film, 0, 16, [](const integrator::Status&) {
          volatile float zero = 0;
          zero = zero / zero;
          return true;
        });
        std::_Exit(0);
      },
      "");
}

}  // namespace
}  // namespace analytic
