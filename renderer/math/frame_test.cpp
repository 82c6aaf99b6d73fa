#include "math/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "math/sampler.h"
#include "math/warp.h"

using math::Vec3;

namespace {

// The largest deviation from orthonormal and right-handed, in double.
double deviation(const math::Frame& f) {
  const auto dot = [](const Vec3& a, const Vec3& b) {
    return double{a.x} * b.x + double{a.y} * b.y + double{a.z} * b.z;
  };
  const double handed = dot(math::cross(f.tangent, f.bitangent), f.normal);
  return std::max({std::fabs(dot(f.tangent, f.normal)), std::fabs(dot(f.bitangent, f.normal)),
                   std::fabs(dot(f.tangent, f.bitangent)),
                   std::fabs(1 - std::sqrt(dot(f.tangent, f.tangent))),
                   std::fabs(1 - std::sqrt(dot(f.bitangent, f.bitangent))), std::fabs(1 - handed)});
}

std::vector<Vec3> normals(int count) {
  std::vector<Vec3> all = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (int i = 0; i < count; ++i) {
    const math::Vec4 u =
        math::Sampler(math::Sampler::Kind::random, 1, 0, 0, 0, static_cast<std::uint32_t>(i)).get(0);
    all.push_back(math::sample_sphere(u.x, u.y));
    // Close to the poles, where Frisvad's basis breaks.
    all.push_back(math::normalize({(u.x - .5f) * 2e-4f, (u.y - .5f) * 2e-4f, i % 2 ? -1.f : 1.f}));
  }
  return all;
}

}  // namespace

TEST(Frame, FromANormalIsOrthonormalEverywhere) {
  double worst = 0;
  for (const Vec3& n : normals(1000000)) worst = std::max(worst, deviation(math::frame_from_normal(n)));
  EXPECT_LT(worst, 1e-6);
}

TEST(Frame, FromANormalAndATangentIsOrthonormalAndFollowsTheTangent) {
  double worst = 0;
  for (const Vec3& n : normals(200000))
    for (const Vec3& t : {Vec3{1, 0, 0}, Vec3{.3f, -.7f, .2f}, n + Vec3{1e-3f, 0, 0}, Vec3{1e-20f, 3e-20f, 0},
                          Vec3{1e19f, 0, 1e19f}}) {
      const math::Frame frame = math::frame_from_normal_and_tangent(n, t);
      worst = std::max(worst, deviation(frame));
      const Vec3 unit = math::normalize(t);
      if (std::fabs(math::dot(unit, n)) < .99f) {
        EXPECT_GT(math::dot(frame.tangent, unit), 0);
        EXPECT_NEAR(math::dot(frame.bitangent, unit), 0, 1e-6);
      }
    }
  EXPECT_LT(worst, 1e-6);
}

TEST(Frame, UselessTangentsFallBack) {
  const Vec3 n = math::normalize({.3f, .5f, -.8f});
  const math::Frame plain = math::frame_from_normal(n);
  for (const Vec3& t : {Vec3{0, 0, 0}, n, n * -3.f, Vec3{NAN, 0, 0}, Vec3{INFINITY, 0, 0}}) {
    const math::Frame frame = math::frame_from_normal_and_tangent(n, t);
    EXPECT_EQ(frame.tangent, plain.tangent);
    EXPECT_EQ(frame.bitangent, plain.bitangent);
  }
}

TEST(Frame, LocalAndWorldAreInverse) {
  const math::Frame frame = math::frame_from_normal_and_tangent(math::normalize({.2f, -.9f, .4f}), {1, 2, 3});
  EXPECT_EQ(math::length(frame.to_local(frame.normal) - Vec3{0, 0, 1}) < 1e-6f, true);
  for (const Vec3& v : {Vec3{1, 0, 0}, Vec3{-.3f, .4f, 7}}) {
    EXPECT_LT(math::length(frame.to_world(frame.to_local(v)) - v), 2e-6f);
    EXPECT_LT(math::length(frame.to_local(frame.to_world(v)) - v), 2e-6f);
  }
}
