#include "report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <limits>

#include "base/error.h"
#include "image/io.h"
#include "report/html.h"
#include "report/results.h"
#include "suite/testing.h"

namespace report {
namespace {

using suite::testing::write_text;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

// A build folder with results of cases as docs/formats.md has them.
class Report : public ::testing::Test {
 protected:
  std::string build() const { return folder_.path() + "/build"; }

  std::string picture(const std::string& name, unsigned seed, int width = 16) {
    suite::testing::Recipe recipe;
    recipe.width = width, recipe.height = width, recipe.seed = seed;
    recipe.replicates = 2;
    image::Render render = suite::testing::render(recipe);
    render.layers.clear();
    image::write_exr(build() + "/" + name, render);
    return name;
  }

  Json result(const std::string& name, const std::string& verdict, bool passed) {
    return {{"case", name},
            {"verdict", verdict},
            {"passed", passed},
            {"exit_code", passed ? 0 : 1},
            {"reason", passed ? "" : "bias of the image 1.2 %"},
            {"why", "Notices what " + name + " notices."},
            {"margins", {{"image", .005}}},
            {"golden",
             {{"measures",
               {{{"name", "flip"}, {"value", .0625}, {"limit", .03125}, {"ok", false}},
                {{"name", "relative mse"}, {"value", nullptr}, {"ok", true}}}},
              {"images", {{"render", nullptr}, {"golden", nullptr}, {"flip", nullptr}}}}},
            {"witnesses", Json::array()},
            {"accept", ""}};
  }

  void save(const std::vector<Json>& results) {
    Json run = {{"finished", "2026-01-02T03:04:05Z"}, {"seconds", 12.5}, {"renderer", "assay-render"}};
    for (const Json& r : results) {
      run["cases"].push_back(r["case"]);
      write_text(build() + "/results/" + r["case"].get<std::string>() + ".json", r.dump());
    }
    write_text(build() + "/run.json", run.dump());
  }

  suite::testing::TemporaryFolder folder_;
};

TEST_F(Report, shows_verdicts_numbers_with_limits_and_how_to_accept) {
  Json changed = result("box", "CHANGED", false);
  changed["accept"] = "assay accept box --because \"…\"";
  changed["golden"]["images"] = {{"render", picture("renders/box.exr", 1)},
                                 {"golden", picture("goldens/box.exr", 2)},
                                 {"flip", picture("results/box.flip.exr", 3)}};
  changed["golden"]["welch"] = {
      {"image",
       {{"red", {{"relative", .012}, {"low", .011}, {"high", .013}, {"p", 1e-9}, {"significant", true}}}}},
      {"tiles", {{{"x", 8}, {"y", 8}, {"width", 8}, {"height", 800}, {"t", 9.5}}}}};
  changed["witnesses"] = {{{"label", "blender"},
                           {"kind", "blender"},
                           {"verdict", "DIFFERS"},
                           {"passed", true},
                           {"expect", "differs"},
                           {"because", "its clearcoat is biased"},
                           {"measures", Json::array()},
                           {"images",
                            {{"render", "renders/box.exr"},
                             {"witness", picture("blender.exr", 4)},
                             {"map", "results/box.flip.exr"},
                             {"map_is", "flip"}}}}};
  save({changed});
  const std::string html = page(build());
  for (const char* part :
       {">CHANGED</span>",
        "DIFFERS as expected",
        "its clearcoat is biased",
        "0.0625",
        "0.0312",
        "not finite",
        "bias of the image 1.2 %",
        "assay accept box --because &quot;…&quot;",
        "+1.2 %",
        "Notices what box notices.",
        "data-name=\"ours\" data-group=\"golden\" data-role=\"ours\" data-show=\"radiance\"",
        "data-name=\"golden\" data-group=\"golden\" data-role=\"theirs\"",
        "data-name=\"FLIP\" data-group=\"golden\" data-role=\"map\"",
        "data-name=\"difference\" data-group=\"golden\"",
        "data-name=\"significance\" data-group=\"golden\" data-role=\"tiles\"",
        "&quot;significant&quot;:false,&quot;t&quot;:9.5,&quot;width&quot;:8,",
        "data-name=\"Blender\" data-group=\"Blender\" data-role=\"theirs\"",
        "data-name=\"FLIP\" data-group=\"Blender\"",
        "data-name=\"difference\" data-group=\"Blender\"",
        "data-name=\"significance\" data-group=\"Blender\"",
        "RMS difference ",
        "2026-01-02T03:04:05Z",
        "1 of 1 cases fail, 1 pending"})
    EXPECT_TRUE(contains(html, part)) << part;
  EXPECT_EQ(count(html, "src=\"data:image/png;base64,"), 0u) << "every picture has floats";
  EXPECT_EQ(count(html, "\"z\":"), 6u) << "ours, golden, Blender, two differences and the one map, each once";
}

TEST_F(Report, puts_failures_first_and_opens_only_those) {
  Json expected_later = result("a_fine", "IDENTICAL", true), noted = result("b_noted", "EQUIVALENT", true);
  save({expected_later, noted, result("c_noisy", "NOISIER", false), result("d_changed", "CHANGED", false)});
  const std::string html = page(build());
  std::size_t last = 0;
  for (const char* name : {"d_changed", "c_noisy", "b_noted", "a_fine"}) {
    const std::size_t at = html.find("id=\"case-" + std::string(name));
    ASSERT_NE(at, std::string::npos) << name;
    EXPECT_GT(at, last) << name;
    last = at;
  }
  EXPECT_EQ(count(html, " open><summary>"), 2u);
  EXPECT_TRUE(contains(html, "data-word=\"status:failing\" aria-pressed=\"false\">failing <b>2</b>"));
}

TEST_F(Report, shows_a_picture_once_if_ours_and_the_golden_have_the_same_bits) {
  Json r = result("same", "IDENTICAL", true);
  r["golden"]["images"] = {
      {"render", picture("a.exr", 1)}, {"golden", picture("b.exr", 1)}, {"flip", nullptr}};
  save({r});
  const std::string html = page(build());
  EXPECT_TRUE(contains(html, "data-name=\"ours = golden\""));
  EXPECT_EQ(count(html, "class=\"shot\""), 1u);
  EXPECT_EQ(count(html, "\"z\":"), 1u);
}

TEST_F(Report, escapes_everything_that_comes_from_files) {
  const std::string evil = "<script>alert(1)</script>\"'&\x01 http://example.org/";
  Json r = result("evil", "CHANGED", false);
  for (const char* key : {"verdict", "reason", "why", "scene", "shader", "accept"}) r[key] = evil;
  r["tags"] = {evil};
  r["options"] = {{evil, evil}};
  r["size"] = {evil, evil};
  r["golden"]["measures"] = {{{"name", evil}, {"value", 1}, {"limit", 2}, {"ok", true}}};
  r["golden"]["images"] = {{"render", evil}, {"golden", evil}, {"flip", evil}};
  r["provenance"] = {{"render", {{"commit", evil}, {evil, {{evil, evil}}}}}};
  for (const char* kind : {"analytic", "povray", "strange"}) {
    Json w = {{"images", {{"witness", evil}, {"render", evil}, {"map", evil}}}, {"kind", kind}};
    for (const char* key : {"label", "quantity", "verdict", "reason", "said_by", "because"}) w[key] = evil;
    r["witnesses"].push_back(w);
  }
  save({r});
  Json run = {{"cases", {"evil"}}, {"finished", evil}, {"renderer", evil}, {"orphans", {evil}}};
  write_text(build() + "/run.json", run.dump());
  const std::string html = page(build());
  EXPECT_FALSE(contains(html, "<script>alert"));
  EXPECT_TRUE(contains(html, "&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;&amp;\xef\xbf\xbd"));
  EXPECT_EQ(count(html, "<script"), 2u) << "the table of floats and the page's own";
  EXPECT_FALSE(contains(html, "=\"http")) << "no address becomes a link";
}

TEST_F(Report, refers_to_nothing_outside_itself) {
  Json r = result("box", "CHANGED", false);
  r["golden"]["images"]["render"] = picture("a.exr", 1);
  save({r});
  const std::string html = page(build());
  for (const char* part : {"http:", "https:", "//www", "@import", "url(", "<link", "<iframe", "src=\"/",
                           "src=\".", "fetch(", "XMLHttp", "import("})
    EXPECT_FALSE(contains(html, part)) << part;
  EXPECT_TRUE(contains(html, "default-src &#39;none&#39;"));
}

TEST_F(Report, shows_what_is_missing_or_damaged_and_goes_on) {
  Json gone = result("gone", "CHANGED", false), damaged = result("damaged", "BROKEN", false);
  gone["golden"]["images"] = {
      {"render", "renders/nowhere.exr"}, {"golden", picture("b.exr", 1)}, {"flip", 7}};
  write_text(build() + "/bad.exr", "not a picture");
  damaged["golden"]["images"] = {{"render", "bad.exr"}, {"golden", "b.exr"}, {"flip", "bad.exr"}};
  Json sizes = result("sizes", "BROKEN", false);
  sizes["golden"]["images"] = {{"render", picture("small.exr", 1, 8)}, {"golden", "b.exr"}};
  Json odd = {
      {"case", "odd"}, {"verdict", 3}, {"golden", "?"}, {"witnesses", {1, "x", nullptr}}, {"size", {1}}};
  save({gone, damaged, sizes, odd, result("lost", "CHANGED", false), result("cut", "CHANGED", false)});
  std::filesystem::remove(build() + "/results/lost.json");
  write_text(build() + "/results/cut.json", "{\"case\": \"cut\", ");
  const std::string html = page(build());
  EXPECT_TRUE(contains(html, "missing: " + build() + "/renders/nowhere.exr"));
  EXPECT_TRUE(contains(html, build() + "/bad.exr: "));
  EXPECT_TRUE(contains(html, "sizes differ: 8 × 8, 16 × 16"));
  EXPECT_TRUE(contains(html, "results/lost.json: missing"));
  EXPECT_TRUE(contains(html, "results/cut.json: not a JSON object"));
  EXPECT_EQ(count(html, "<details class=\"case\""), 6u);
}

TEST_F(Report, of_pictures_that_are_not_finite_shows_them) {
  image::Render bad;
  bad.mean = image::Image(4, 4, 3, std::numeric_limits<float>::quiet_NaN());
  image::write_exr(build() + "/nan.exr", bad);
  bad.mean = image::Image(4, 4, 3, std::numeric_limits<float>::infinity());
  image::write_exr(build() + "/inf.exr", bad);
  Json r = result("nan", "BROKEN", false);
  r["golden"]["images"] = {{"render", "nan.exr"}, {"golden", "inf.exr"}, {"flip", "nan.exr"}};
  save({r});
  EXPECT_EQ(count(page(build()), "class=\"shot\""), 3u) << "ours, golden, FLIP";
}

TEST_F(Report, of_a_run_that_did_not_finish_says_so) {
  save({result("box", "IDENTICAL", true)});
  std::filesystem::remove(build() + "/run.json");
  EXPECT_TRUE(contains(page(build()), "the run did not finish"));
  std::filesystem::remove_all(build() + "/results");
  EXPECT_THROW(page(build()), base::Error);
}

TEST_F(Report, counts_p_values_in_twenty_bins) {
  std::vector<Json> results;
  for (const double p : {0., .01, .02, .03, .04, .041, .52, .53, .999, 1.}) {
    Json r = result("g" + std::to_string(results.size()), "EQUIVALENT", true);
    r["golden"]["welch"] = {{"image", {{"luminance", {{"p", p}}}}}};
    results.push_back(r);
  }
  const auto witness = [](double p, bool expected) {
    return Json{{"kind", "blender"},
                {"expect", expected ? "differs" : "agrees"},
                {"image", {{"luminance", {{"p", p}}}}}};
  };
  // 2 and 1 in the first bin: in floating point the two bars are higher than the plot.
  results[0]["witnesses"] = Json::array({witness(.3, false)});  // to clang {one} is that one
  for (int i = 1; i < 4; ++i) results[i]["witnesses"] = Json::array({witness(.001, i == 1)});
  save(results);
  const std::string html = page(build());
  EXPECT_TRUE(contains(html, "Goldens: 10 p-values"));
  EXPECT_TRUE(contains(html, "Witnesses: 4 p-values<"));
  for (const char* part : {"<title>p 0 to 0.05: g0, g1, g2, g3, g4, g5<", "<title>p 0.5 to 0.55: g6, g7<",
                           "<title>p 0.95 to 1: g8, g9<", "<title>p 0.3 to 0.35: g0 / Blender<"})
    EXPECT_TRUE(contains(html, part)) << part;
  EXPECT_FALSE(contains(html, "=\"−")) << "a minus sign is for people, not for coordinates";
  EXPECT_FALSE(contains(html, "y=\"-"));
}

TEST_F(Report, names_the_worst_wrong_pixels) {
  Json r = result("box", "CHANGED", false);
  for (int i = 0; i < 20; ++i)
    r["golden"]["wrong_pixels"].push_back(
        {{"x", 10 + i}, {"y", 3}, {"reference", .5}, {"test", 2}, {"sigmas", i ? Json(40 - i) : Json()}});
  save({r});
  const std::string html = page(build());
  for (const char* part :
       {"data-x=\"10\" data-y=\"3\" aria-label=\"show pixel 10, 3\">10, 3</button> 2 instead of 0.5, where",
        "11, 3</button> 2 instead of 0.5, 39 σ", "and 12 more</p>"})
    EXPECT_TRUE(contains(html, part)) << part;
  EXPECT_EQ(count(html, "class=\"pixel\""), 8u);
}

TEST_F(Report, offers_one_command_for_all_that_is_pending) {
  Json a = result("a", "CHANGED", false), b = result("b", "NOISIER", false);
  a["accept"] = "build/bin/assay accept a --because \"…\"";
  b["accept"] = "build/bin/assay accept b --because \"…\"";
  save({a, b, result("c", "IDENTICAL", true)});
  EXPECT_TRUE(contains(page(build()), "<code>build/bin/assay accept a b --because &quot;…&quot;</code>"));
  save({a, result("c", "IDENTICAL", true)});
  EXPECT_FALSE(contains(page(build()), "all new pictures"));
}

TEST_F(Report, is_the_same_bytes_for_the_same_results) {
  Json r = result("box", "CHANGED", false);
  r["golden"]["images"] = {{"render", picture("a.exr", 1)}, {"golden", picture("b.exr", 2)}};
  save({r, result("sphere", "IDENTICAL", true)});
  EXPECT_EQ(page(build()), page(build()));
  EXPECT_EQ(suite::testing::read_text(write(build())), page(build()));
  EXPECT_EQ(write(build(), folder_.path() + "/x/y.html"), folder_.path() + "/x/y.html");
}

TEST_F(Report, of_a_hundred_changed_cases_with_a_witness_each_stays_below_15_MB) {
  std::vector<Json> results;
  for (unsigned i = 0; i < 100; ++i) {
    const std::string name = "case" + std::to_string(i);
    Json r = result(name, "CHANGED", false);
    const std::string ours = picture(name + ".a.exr", 4 * i, 64);
    const std::string golden = picture(name + ".b.exr", 4 * i + 1, 64);
    const std::string blender = picture(name + ".c.exr", 4 * i + 3, 64);
    r["golden"]["images"] = {{"render", ours},
                             {"golden", golden},
                             {"fresh", picture(name + ".f.exr", 4 * i + 2, 64)},
                             {"flip", ours}};
    r["witnesses"] = {
        {{"kind", "blender"},
         {"images", {{"render", ours}, {"witness", blender}, {"map", golden}, {"map_is", "flip"}}}}};
    results.push_back(r);
  }
  save(results);
  const std::string html = page(build());
  EXPECT_LE(html.size(), 15'000'000u);
  EXPECT_GT(html.size(), 12'000'000u) << "or this test shows nothing";
  EXPECT_GT(count(html, "\"z\":"), 500u);
  std::cout << "a hundred cases of noise: " << html.size() << " bytes, " << count(html, "\"z\":")
            << " pictures with floats, " << count(html, "src=\"data:image/png") << " as PNG\n";
}

TEST_F(Report, that_is_too_large_takes_floats_from_identical_cases_and_then_from_the_last) {
  std::vector<Json> results;
  for (unsigned i = 0; i < 8; ++i) {
    const std::string name = "c" + std::to_string(i);
    Json r = result(name, i < 4 ? "CHANGED" : "IDENTICAL", i >= 4);
    const std::string ours = picture(name + ".a.exr", 2 * i, 64);
    r["golden"]["images"] = {{"render", ours},
                             {"golden", i < 4 ? picture(name + ".b.exr", 2 * i + 1, 64) : ours}};
    if (i == 4)
      r["witnesses"] = {
          {{"kind", "blender"}, {"images", {{"render", ours}, {"witness", picture("blender.exr", 99, 64)}}}}};
    results.push_back(r);
  }
  save(results);
  const std::string whole = page(build());
  const auto pngs = [](const std::string& html) { return count(html, "src=\"data:image/png"); };
  EXPECT_EQ(pngs(whole), 0u);
  const std::string less = page(build(), whole.size() - 10'000);
  EXPECT_EQ(pngs(less), 3u) << "the identical ones without another renderer's picture";
  EXPECT_LT(less.find("id=\"case-c5"), less.find("src=\"data:image/png"));
  const std::string least = page(build(), less.size() - 40'000);
  EXPECT_LE(least.size(), less.size() - 40'000);
  EXPECT_GT(pngs(least), 3u);
  EXPECT_EQ(count(page(build(), 1), "\"z\":"), 0u) << "no room at all: every picture is a PNG";
  EXPECT_LT(least.find("id=\"case-c2"), least.find("src=\"data:image/png")) << "of the failing the last";
}

}  // namespace
}  // namespace report
