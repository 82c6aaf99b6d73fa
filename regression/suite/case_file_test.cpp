#include "suite/case_file.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "suite/case_edit.h"
#include "suite/schema.h"
#include "suite/testing.h"

namespace suite {
namespace {

using nlohmann::json;

const std::string minimal =
    R"({"name": "a", "why": "w", "scene": "box.gltf", "shader": "path", "size": [8, 4],
 "spp": 16, "replicates": 8, "seed": 1, "depth": 4})";

// The case `a` with one change: the JSON patch-like {"key": value}, null removing the key.
class CaseFile : public ::testing::Test {
 protected:
  Case read_text(const std::string& text) {
    testing::write_text(suite_.layout.case_file("a"), text);
    return read_case(suite_.layout, "a");
  }
  Case read_changed(const std::string& change) {
    json j = json::parse(minimal);
    j.merge_patch(json::parse(change));
    return read_text(j.dump());
  }
  std::string error_of(const std::string& text) {
    try {
      read_text(text);
    } catch (const base::Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return std::string(error.what()).substr(suite_.layout.case_file("a").size());
    }
    return "no error";
  }
  std::string error_of_changed(const std::string& change) {
    json j = json::parse(minimal);
    j.merge_patch(json::parse(change));
    return error_of(j.dump());
  }
  testing::FakeSuite suite_;
};

TEST_F(CaseFile, gives_absent_keys_the_documented_defaults) {
  const Case c = read_text(minimal);
  EXPECT_EQ(c.camera, 0);
  EXPECT_EQ(c.options, json::object());
  EXPECT_TRUE(c.witnesses.empty());
  EXPECT_EQ(c.margin_image, .005);
  EXPECT_EQ(c.margin_tile, .05);
  EXPECT_FALSE(c.limits.has_value());
  EXPECT_EQ(c.timeout_s, 60);
  EXPECT_TRUE(c.tags.empty());
}

TEST_F(CaseFile, gives_witnesses_the_documented_defaults) {
  const Case c = read_changed(R"({"witnesses": [{"kind": "blender"}, {"kind": "povray", "quantity": "direct"},
    {"kind": "povray", "quantity": "position"}, {"kind": "analytic", "mean": [1, 2, 3], "source": "s"},
    {"kind": "analytic", "mean": [1, 2, 3], "source": "s", "rect": [0, 0, 8, 2], "shader": "direct", "depth": 2}]})");
  ASSERT_EQ(c.witnesses.size(), 5u);
  EXPECT_EQ(c.witnesses[0].margin, .005);
  EXPECT_EQ(c.witnesses[0].spp, 1024);
  EXPECT_EQ(c.witnesses[0].seeds, 8);
  EXPECT_EQ(c.witnesses[0].shader, "path");
  EXPECT_EQ(c.witnesses[0].depth, 4);
  EXPECT_EQ(c.witnesses[1].margin, .001);
  EXPECT_EQ(c.witnesses[1].depth, 1);
  EXPECT_EQ(c.witnesses[1].tolerance, .02);
  EXPECT_EQ(c.witnesses[2].shader, "position");
  EXPECT_EQ(c.witnesses[2].tolerance, 1e-4);
  EXPECT_EQ(c.witnesses[2].label, "povray.position");
  EXPECT_EQ(c.witnesses[3].label, "analytic");
  EXPECT_EQ(c.witnesses[4].label, "analytic-2");
  EXPECT_EQ(c.witnesses[4].shader, "direct");
  EXPECT_EQ(c.witnesses[4].depth, 2);
  EXPECT_EQ(c.witnesses[4].rect->at(3), 2);
}

TEST_F(CaseFile, names_the_near_miss_of_an_unknown_key) {
  EXPECT_EQ(error_of_changed(R"({"sead": 3})"),
            ": sead: wanted a known key (did you mean \"seed\"?), found \"sead\"");
  EXPECT_EQ(error_of_changed(R"({"witnesses": [{"kind": "blender", "margn": 1}]})"),
            ": witnesses[0].margn: wanted a known key (did you mean \"margin\"?), found \"margn\"");
  EXPECT_EQ(error_of_changed(R"({"limits": {"flip": 0.1, "rmse": 0.1, "ssim": 0.1}})"),
            ": limits.ssim: wanted one of flip, rmse, found \"ssim\"");
}

TEST_F(CaseFile, refuses_wrong_types_and_ranges_naming_the_place) {
  EXPECT_EQ(error_of_changed(R"({"spp": "many"})"), ": spp: wanted an integer, found \"many\"");
  EXPECT_EQ(error_of_changed(R"({"spp": 16.0})"), ": spp: wanted an integer, found 16.0");
  EXPECT_EQ(error_of_changed(R"({"spp": 0})"),
            ": spp: wanted a number at least 1 and at most 1048576, found 0");
  EXPECT_EQ(error_of_changed(R"({"spp": 17})"), ": spp: wanted a multiple of replicates, 8, found 17");
  EXPECT_EQ(error_of_changed(R"({"size": [8]})"), ": size: wanted 2 elements, found 1");
  EXPECT_EQ(error_of_changed(R"({"size": [8, -4]})"),
            ": size[1]: wanted a number at least 1 and at most 4096, found -4");
  EXPECT_EQ(error_of_changed(R"({"replicates": 1})"),
            ": replicates: wanted a number at least 2 and at most 64, found 1");
  EXPECT_EQ(error_of_changed(R"({"why": ""})"), ": why: wanted a text, found an empty string");
  EXPECT_EQ(error_of_changed(R"({"depth": null})").substr(0, 36), ": top level: wanted the key \"depth\",");
  EXPECT_EQ(error_of_changed(R"({"shader": "disnay"})").substr(0, 24), ": shader: wanted one of ");
  EXPECT_EQ(error_of_changed(R"({"limits": {"flip": 0, "rmse": 1}})"),
            ": limits.flip: wanted a number above 0 and at most 1, found 0");
  EXPECT_EQ(error_of_changed(R"({"timeout_s": 0})"),
            ": timeout_s: wanted a number above 0 and at most 3600, found 0");
}

TEST_F(CaseFile, refuses_a_name_that_is_not_the_files_and_a_scene_that_is_not_there) {
  EXPECT_EQ(error_of_changed(R"({"name": "b"})"), ": name: wanted \"a\" as the file is called, found \"b\"");
  EXPECT_NE(error_of_changed(R"({"scene": "absent.glb"})").find(": scene: wanted a file in "),
            std::string::npos);
  EXPECT_NE(error_of_changed(R"({"scene": "../../etc/passwd.glb"})").find(": scene: wanted a string like"),
            std::string::npos);
}

TEST_F(CaseFile, refuses_options_that_the_case_decides_itself_or_that_name_files) {
  EXPECT_EQ(error_of_changed(R"({"options": {"seed": 3}})"),
            ": options.seed: wanted another key, found \"seed\"");
  EXPECT_EQ(error_of_changed(R"({"options": {"environment": "sky.exr"}})"),
            ": options.environment: wanted another key, found \"environment\"");
  EXPECT_EQ(error_of_changed(R"({"options": {"d-gamma": [1]}})"),
            ": options.d-gamma: wanted a boolean or number or string, found [1]");
  EXPECT_EQ(read_changed(R"({"options": {"d-gamma": 1.5}})").options, json::parse(R"({"d-gamma": 1.5})"));
}

TEST_F(CaseFile, refuses_witnesses_that_make_no_sense) {
  EXPECT_EQ(error_of_changed(R"({"witnesses": [{"kind": "mitsuba"}]})"),
            ": witnesses[0].kind: wanted one of \"blender\", \"povray\", \"analytic\", found \"mitsuba\"");
  EXPECT_EQ(error_of_changed(R"({"witnesses": [{"kind": "blender", "expect": "differs"}]})"),
            ": witnesses[0]: wanted the key \"because\" beside \"expect\": \"differs\", found none");
  EXPECT_EQ(error_of_changed(R"({"witnesses": [{"kind": "blender"}, {"kind": "blender"}]})"),
            ": witnesses[1]: wanted each stored picture once, found blender twice");
  EXPECT_EQ(
      error_of_changed(
          R"({"witnesses": [{"kind": "analytic", "mean": [1, 1, 1], "source": "s", "rect": [4, 0, 8, 4]}]})"),
      ": witnesses[0].rect: wanted a rectangle inside the image, found [4,0,8,4]");
  EXPECT_EQ(error_of_changed(R"({"witnesses": [{"kind": "blender", "quantity": "direct"}]})").substr(0, 35),
            ": witnesses[0].quantity: wanted one");
}

TEST_F(CaseFile, says_where_the_json_is_broken_and_refuses_repeated_keys) {
  EXPECT_NE(error_of("{\"name\": \"a\",\n \"why\" }").find("line 2"), std::string::npos);
  EXPECT_EQ(error_of(R"({"name": "a", "name": "a"})"), ": name: wanted each key once, found it twice");
  EXPECT_EQ(error_of("[]"), ": top level: wanted an object, found []");
  EXPECT_NE(error_of("").find("wanted JSON"), std::string::npos);
}

TEST_F(CaseFile, is_compiled_from_the_schema_in_the_repository) {
  EXPECT_EQ(case_schema(), read_json(ASSAY_SOURCE_DIR "/regression/cases/schema.json"));
}

// Every default the schema states, against what an absent key becomes; and every key it allows must be read.
TEST_F(CaseFile, has_the_defaults_that_the_schema_states) {
  const json& schema = case_schema();
  const Case c = read_changed(R"({"witnesses": [{"kind": "blender"}, {"kind": "povray", "quantity": "normal"},
                                                {"kind": "analytic", "mean": [1, 1, 1], "source": "s"}]})");
  EXPECT_EQ(schema["properties"]["camera"]["default"], c.camera);
  EXPECT_EQ(schema["properties"]["timeout_s"]["default"], c.timeout_s);
  EXPECT_EQ(schema["properties"]["margins"]["properties"]["image"]["default"], c.margin_image);
  EXPECT_EQ(schema["properties"]["margins"]["properties"]["tile"]["default"], c.margin_tile);
  const char* const kinds[] = {"blender", "povray", "analytic"};
  for (size_t i = 0; i < 3; ++i) {
    const json& properties = schema["$defs"][kinds[i]]["properties"];
    EXPECT_EQ(properties["margin"]["default"], c.witnesses[i].margin) << kinds[i];
    EXPECT_EQ(properties["expect"]["default"], "agrees");
    EXPECT_FALSE(c.witnesses[i].expect_differs);
  }
  EXPECT_EQ(schema["$defs"]["blender"]["properties"]["spp"]["default"], c.witnesses[0].spp);
  EXPECT_EQ(schema["$defs"]["blender"]["properties"]["seeds"]["default"], c.witnesses[0].seeds);
  EXPECT_EQ(schema["$defs"]["blender"]["properties"]["flip"]["default"], c.witnesses[0].flip);
  EXPECT_EQ(schema["$defs"]["povray"]["properties"]["coverage"]["default"], c.witnesses[1].coverage);
}

TEST_F(CaseFile, reads_every_case_of_the_repository) {
  const Layout layout = Layout::find(ASSAY_SOURCE_DIR "/regression", "");
  for (const std::string& name : case_names(layout)) EXPECT_NO_THROW(read_case(layout, name)) << name;
}

TEST(Pattern, is_a_substring_or_a_glob_over_the_whole_name) {
  EXPECT_TRUE(matches("nell", "cornell"));
  EXPECT_FALSE(matches("nelly", "cornell"));
  EXPECT_TRUE(matches("c*l", "cornell"));
  EXPECT_TRUE(matches("*e*l*", "cornell"));
  EXPECT_FALSE(matches("c*n", "cornell"));
  EXPECT_TRUE(matches("corne??", "cornell"));
  EXPECT_FALSE(matches("corne?", "cornell"));
  EXPECT_TRUE(matches("*", "cornell"));
}

TEST(CaseEdit, replaces_a_value_and_leaves_everything_else_as_it_was) {
  const std::string text =
      "{\n  \"name\": \"a\",  \"spp\":16, \"why\": \"a \\\"spp\\\": 3, {\",\n  \"limits\": {\"flip\": 1,\n "
      "\"rmse\": [2]},\n  \"tags\": []\n}\n";
  EXPECT_EQ(with_member(text, "spp", "32"),
            "{\n  \"name\": \"a\",  \"spp\":32, \"why\": \"a \\\"spp\\\": 3, {\",\n  \"limits\": {\"flip\": "
            "1,\n \"rmse\": [2]},\n  \"tags\": []\n}\n");
  EXPECT_EQ(with_member(text, "limits", "7"),
            "{\n  \"name\": \"a\",  \"spp\":16, \"why\": \"a \\\"spp\\\": 3, {\",\n  \"limits\": 7,\n  "
            "\"tags\": []\n}\n");
}

TEST(CaseEdit, adds_an_absent_member_at_the_end_on_its_own_line) {
  EXPECT_EQ(with_member("{\n  \"a\": {\"limits\": 1}\n}\n", "limits", "2"),
            "{\n  \"a\": {\"limits\": 1},\n  \"limits\": 2\n}\n");
  EXPECT_EQ(json::parse(with_member("{}", "limits", "2")), json::parse(R"({"limits": 2})"));
}

TEST(NearMiss, finds_what_was_meant_and_nothing_far_away) {
  EXPECT_EQ(near_miss("acept", {"run", "accept", "reject"}), "accept");
  EXPECT_EQ(near_miss("rnu", {"run", "accept"}), "run");
  EXPECT_EQ(near_miss("zebra", {"run", "accept", "reject"}), "");
}

}  // namespace
}  // namespace suite
