// Images and samplers.
#include "gltf/sample_test.h"
#include "image/display.h"

using namespace gltf;
using namespace gltf::sample;
using math::Vec4;

namespace {

// 2 x 2 RGBA: red, half-transparent green / (51, 102, 153) with alpha 0, white.
const std::string png =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAF0lEQVR42mP4z8DwHwgbGIzTZjL8BwIAQdUIrMbWMH4AAAAASUVORK5C"
    "YII=";

}  // namespace

TEST(Texture, decodes_each_used_image_once_with_its_sampler) {
  File f = triangle();
  f.root["images"] = json::parse(
      R"([{"uri": "data:image/png;base64,AAAA"}, {"name": "checker", "uri": "data:image/png;base64,)" + png +
      "\"}]");
  f.root["samplers"] = json::parse(R"([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}])");
  f.root["textures"] = json::parse(R"([{"source": 1, "sampler": 0}, {"source": 1}, {"source": 0}])");
  f.root["materials"] = json::parse(R"([{"emissiveTexture": {"index": 1, "texCoord": 1},
    "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
  f.root["meshes"][0]["primitives"][0]["material"] = 0;
  const scene::Scene scene = load_file(f);
  ASSERT_EQ(scene.bitmaps.size(), 1u);
  EXPECT_EQ(scene.bitmaps[0].name, "checker");
  EXPECT_EQ(scene.bitmaps[0].width, 2);
  // Unassociated alpha, and no sRGB decoding: 51/255 stays .2 where alpha is 0.
  const std::vector<Vec4> texels = {{1, 0, 0, 1}, {0, 1, 0, 128 / 255.0f}, {.2f, .4f, .6f, 0}, {1, 1, 1, 1}};
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(scene::fraction(scene.bitmaps[0].texels.at(i)), texels[i]);
  const scene::Texture &base = scene.materials[0].base_color_texture,
                       &emissive = scene.materials[0].emissive_texture;
  EXPECT_EQ(base.bitmap, 0);
  EXPECT_EQ(base.wrap_u, scene::Wrap::clamp);
  EXPECT_EQ(base.wrap_v, scene::Wrap::mirror);
  EXPECT_EQ(base.filter, scene::Filter::nearest);
  EXPECT_EQ(emissive.bitmap, 0);
  EXPECT_EQ(emissive.texcoord_set, 1);
  EXPECT_EQ(emissive.wrap_u, scene::Wrap::repeat);
  EXPECT_EQ(emissive.filter, scene::Filter::linear);
  EXPECT_TRUE(warned(scene, "lacks TEXCOORD_1"));

  f.root["materials"][0]["emissiveTexture"]["index"] = 2;
  expect_refused(complaint(f), "images[0]");
}

TEST(Texture, refuses_other_image_formats_by_their_first_bytes_and_warns_of_wrong_labels) {
  const auto with = [](const std::string& mime, const Bytes& bytes) {
    File f = triangle();
    f.view(bytes);
    f.root["images"] = json::parse("[{\"bufferView\": 2, \"mimeType\": \"" + mime + "\"}]");
    f.root["textures"] = json::parse(R"([{"source": 0}])");
    f.root["materials"] = json::parse(R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
    return f;
  };
  for (const std::string magic : {"GIF89a", "BM......", "8BPS\0\1..", "#?RADIANCE\n", "<svg>", "v/1\1....",
                                  "RIFF....WEBP", "P6 1 1 255 ", "\x01\x01\x01...TGA"})
    expect_refused(complaint(with("image/png", Bytes(magic.begin(), magic.end()))), "images[0]");
  File f = triangle();
  f.root["images"] =
      json::parse(R"([{"mimeType": "image/jpeg", "uri": "data:image/png;base64,)" + png + "\"}]");
  f.root["textures"] = json::parse(R"([{"source": 0}])");
  f.root["materials"] = json::parse(R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
  EXPECT_TRUE(warned(load_file(f), "says image/jpeg and is a PNG"));
}

TEST(Texture, decodes_an_image_once_however_often_it_is_declared) {
  const Folder folder;
  image::write_display(folder / "a.png", image::Image(1024, 1024), {});
  File f = triangle();
  for (int i = 0; i < 1000; ++i) {
    f.root["images"].push_back({{"uri", i % 2 == 0 ? "a.png" : "%61.png"}});
    f.root["textures"].push_back({{"source", i}});
    f.root["materials"].push_back({{"normalTexture", {{"index", i}}}});
  }
  EXPECT_EQ(load(folder.write("scene.glb", f.to_glb())).bitmaps.size(), 1u);
}

TEST(Texture, stops_when_images_take_more_memory_than_there_may_be) {
  const Folder folder;
  File f = triangle();
  for (int i = 0; i < 8; ++i) {  // 8 MB each, a few kilobytes in the file
    const std::string name = std::to_string(i) + ".png";
    image::write_display(folder / name, image::Image(1024, 1024), {});
    f.root["images"].push_back({{"uri", name}});
    f.root["textures"].push_back({{"source", i}});
    f.root["materials"].push_back({{"normalTexture", {{"index", i}}}});
  }
  const std::string file = folder.write("scene.glb", f.to_glb());
  Options options;
  options.limits.memory = 80'000'000;
  EXPECT_EQ(load(file, options).bitmaps.size(), 8u);
  options.limits.memory = 40'000'000;
  try {
    load(file, options);
    ADD_FAILURE();
  } catch (const base::Error& error) {
    expect_refused(error.what(), "images[3]: header: wanted a size of at most 16384 x 16384 and ");
  }
}
