#include "suite/lobes.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace suite {
namespace {

image::Render parts() {
  image::Render r;
  r.mean = image::Image(4, 2, 3, 1);
  r.layers["diffuse.direct"] = image::Image(4, 2, 3, .75f);
  r.layers["diffuse.direct.variance"] = image::Image(4, 2, 3, .0008f);
  r.layers["specular.direct"] = image::Image(4, 2, 3, .25f);
  r.layers["specular.direct.variance"] = image::Image(4, 2, 3, 0);
  r.layers["albedo"] = image::Image(4, 2, 3, 1);  // no variance: no lobe
  return r;
}

TEST(Lobes, means_and_their_standard_errors_follow_from_the_layers) {
  const std::vector<LobeMean> lobes = lobe_means(parts());
  ASSERT_EQ(lobes.size(), 2u);
  EXPECT_EQ(lobes[0].name, "diffuse.direct");
  EXPECT_NEAR(lobes[0].mean, .75, 1e-7);
  EXPECT_NEAR(lobes[0].standard_error, .01, 1e-7);  // sqrt(.0008 / 8 pixels): pixels vary on their own
  EXPECT_NEAR(lobes[1].mean, .25, 1e-7);
  EXPECT_EQ(lobes[1].standard_error, 0);
}

TEST(Lobes, those_that_moved_are_named_the_largest_first_with_the_change_of_the_lobe) {
  const std::vector<LobeMean> golden = {
      {"diffuse.direct", .7, .003}, {"sheen.direct", .1, .001}, {"specular.direct", .2, .003}};
  std::vector<LobeMean> now = golden;
  EXPECT_EQ(moved_lobes(golden, now), "");
  now[2].mean = .21;
  EXPECT_EQ(moved_lobes(golden, now), "by lobe: specular.direct +5 % (2.4 sigma)");
  now[0].mean = .665;
  EXPECT_EQ(moved_lobes(golden, now),
            "by lobe: diffuse.direct -5 % (8.2 sigma), specular.direct +5 % (2.4 sigma)");
  EXPECT_EQ(moved_lobes(golden, now, 1), "by lobe: diffuse.direct -5 % (8.2 sigma)");
  now = golden;
  now[1].mean += 5e-7;  // the order of a sum of floats
  EXPECT_EQ(moved_lobes(golden, now), "");
}

TEST(Lobes, one_that_was_dark_and_without_noise_is_named_with_its_brightness) {
  EXPECT_EQ(moved_lobes({{"diffuse.direct", 1, 0}, {"clearcoat.direct", 0, 0}},
                        {{"diffuse.direct", 1, 0}, {"clearcoat.direct", .02, 0}}),
            "by lobe: clearcoat.direct from 0 to 0.02");
}

TEST(Lobes, survive_the_header_to_the_bit_and_damage_is_refused) {
  const std::vector<LobeMean> lobes = lobe_means(parts()), again = lobes_from_text(to_text(lobes), "a.exr");
  ASSERT_EQ(again.size(), lobes.size());
  for (std::size_t i = 0; i < lobes.size(); ++i) {
    EXPECT_EQ(again[i].name, lobes[i].name);
    EXPECT_EQ(again[i].mean, lobes[i].mean);
    EXPECT_EQ(again[i].standard_error, lobes[i].standard_error);
  }
  EXPECT_TRUE(lobes_from_text("{}", "a.exr").empty());
  for (const char* bad : {"", "[]", "{", "{\"a\": 1}", "{\"a\": [1]}", "{\"a\": [1, null]}"})
    EXPECT_THROW(lobes_from_text(bad, "a.exr"), base::Error) << bad;
}

}  // namespace
}  // namespace suite
