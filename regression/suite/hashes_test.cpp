#include "suite/hashes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "base/error.h"
#include "image/hash.h"
#include "suite/testing.h"

namespace suite {
namespace {

using nlohmann::json;

// Right-hand sides by Python 3.11: json.dumps(json.loads(LEFT), sort_keys=True, separators=(",", ":"),
// ensure_ascii=False).
TEST(CanonicalJson, is_what_python_writes) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"b": 1, "a": [1, 2.0, -3], "B": {}, "aa": true, "_": null})",
       R"({"B":{},"_":null,"a":[1,2.0,-3],"aa":true,"b":1})"},
      {"[0.1, 1e-4, 0.00001, 1e16, 123456789012345680.0, 1e15]",
       "[0.1,0.0001,1e-05,1e+16,1.2345678901234568e+17,1000000000000000.0]"},
      {"[0.005, 1.5, 100.0, -0.0, 0.0, 5e-324, 1.7976931348623157e308]",
       "[0.005,1.5,100.0,-0.0,0.0,5e-324,1.7976931348623157e+308]"},
      {"[1234.5678, 9999999999999998.0, 0.1e1, 3.14159265358979, 1e22, 1e23, 12345e-9]",
       "[1234.5678,9999999999999998.0,1.0,3.14159265358979,1e+22,1e+23,1.2345e-05]"},
      {"[2147483648, -9007199254740993, 18446744073709551615, -0]",
       "[2147483648,-9007199254740993,18446744073709551615,0]"},
      {R"(["a\"b\\c/\n\t\u0001é"])", "[\"a\\\"b\\\\c/\\n\\t\\u0001\u00e9\"]"},
  };
  for (const auto& [text, expected] : cases) EXPECT_EQ(canonical_json(json::parse(text)), expected);
}

class Hashing : public ::testing::Test {
 protected:
  std::string file(const std::string& name) { return folder_.path() + "/" + name; }
  testing::TemporaryFolder folder_;
};

TEST_F(Hashing, of_a_self_contained_scene_is_that_of_its_bytes) {
  // By sha256sum.
  testing::write_text(file("a.gltf"), R"({"asset": {"version": "2.0"}})");
  EXPECT_EQ(scene_hash(file("a.gltf")), image::sha256(R"({"asset": {"version": "2.0"}})"));
  const std::string chunk = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":0}]} )";
  std::string glb = "glTF" + std::string(16, '\0') + chunk;
  const auto length = static_cast<std::uint32_t>(chunk.size());
  std::memcpy(&glb[12], &length, 4);
  testing::write_text(file("a.glb"), glb);
  EXPECT_EQ(scene_hash(file("a.glb")), image::sha256(glb));
}

TEST_F(Hashing, of_a_scene_covers_the_files_it_names_in_order) {
  const std::string scene =
      R"({"buffers": [{"uri": "b%20c.bin"}, {"uri": "data:;base64,AA=="}], "images": [{"uri": "i.png"},
    {"bufferView": 0}], "scene": 1, "scenes": [{"extras": {"environment": "no.exr"}}, {"extras": {"environment": "e.exr"}}]})";
  testing::write_text(file("a.gltf"), scene);
  testing::write_text(file("b c.bin"), "BUFFER");
  testing::write_text(file("i.png"), "IMAGE");
  testing::write_text(file("e.exr"), "ENVIRONMENT");
  EXPECT_EQ(scene_hash(file("a.gltf")), image::sha256(scene + "BUFFER" + "IMAGE" + "ENVIRONMENT"));
  std::filesystem::remove(file("i.png"));
  EXPECT_THROW(scene_hash(file("a.gltf")), base::Error);
}

TEST_F(Hashing, never_reads_outside_the_scenes_folder) {
  testing::write_text(file("secret"), "S");
  for (const char* uri : {"../secret", "/etc/hostname", "a/../../secret", "%2e%2e/secret"}) {
    testing::write_text(file("s/a.gltf"), std::string(R"({"buffers": [{"uri": ")") + uri + R"("}]})");
    EXPECT_THROW(scene_hash(file("s/a.gltf")), base::Error) << uri;
  }
}

TEST_F(Hashing, of_damaged_scenes_is_an_error_of_one_line) {
  for (const std::string& text :
       {std::string("{"), std::string("glTF"), "glTF" + std::string(8, '\0') + "\xff\xff\xff\xff" + "JSON",
        std::string()}) {
    testing::write_text(file("a.glb"), text);
    EXPECT_THROW(scene_hash(file("a.glb")), base::Error);
  }
  EXPECT_NO_THROW((testing::write_text(file("a.gltf"), "[1]"), scene_hash(file("a.gltf"))));
}

// By Python: sha256 of json.dumps({...}, sort_keys=True, separators=(",", ":")).
TEST_F(Hashing, of_a_case_is_the_documented_one) {
  const testing::FakeSuite suite;
  suite.add_case("a", R"("options": {"d-gamma": 1, "d-constant": 0.00001})");
  const Case c = read_case(suite.layout, "a");
  const Hashes hashes = hashes_of(suite.layout, c);
  const std::string object = R"({"camera":0,"depth":4,"options":{"d-constant":1e-05,"d-gamma":1},)";
  EXPECT_EQ(hashes.picture, image::sha256(object + R"("scene_hash":")" + hashes.scene +
                                          R"(","shader":"path","size":[16,16]})"));
  EXPECT_EQ(hashes.a_case, image::sha256(object + R"("replicates":8,"scene_hash":")" + hashes.scene +
                                         R"(","seed":1,"shader":"path","size":[16,16],"spp":64})"));
}

TEST_F(Hashing, of_scripts_covers_the_python_files_in_the_order_of_their_names) {
  testing::write_text(file("b.py"), "B");
  testing::write_text(file("a.py"), "A");
  testing::write_text(file("c.txt"), "C");
  EXPECT_EQ(script_hash(folder_.path()), image::sha256("AB"));
}

}  // namespace
}  // namespace suite
