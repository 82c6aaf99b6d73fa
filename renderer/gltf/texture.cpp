// Textures: which image, how it is looked up (sampler, KHR_texture_transform), and the image itself, decoded
// when it is first used.
#include <algorithm>
#include <array>
#include <cmath>

#include "gltf/reader.h"
#include "image/decode.h"

namespace gltf {
using nlohmann::json;

namespace {

float as_float(double x) { return static_cast<float>(x); }

scene::EncodedBitmap decode(Source& source, size_t index) {
  const auto& [bytes, name, mime_type] = source.document.images[index];
  const std::string place = at("images", index);
  // A decoder may need as much again as the texels take.
  constexpr std::uint64_t texel = sizeof(math::U16Vec4);
  image::Limits limits;
  limits.pixels =
      std::min(limits.pixels, static_cast<std::int64_t>(source.document.memory_left / (2 * texel)));
  image::Decoded decoded =
      image::decode(bytes.data(), bytes.size(), source.document.file + ": " + place, limits);
  source.document.take(place, decoded.texels.size(), texel);
  const std::string kind = bytes[0] == 0x89 ? "PNG" : "JPEG";
  if (!mime_type.empty() && mime_type != (kind == "PNG" ? "image/png" : "image/jpeg"))
    source.warnings.add(place + " says " + mime_type.substr(0, 40) + " and is a " + kind);
  return {name.empty() ? place : name, decoded.width, decoded.height, std::move(decoded.texels)};
}

scene::Wrap wrap(int code) {
  return code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? scene::Wrap::clamp
         : code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? scene::Wrap::mirror
                                                         : scene::Wrap::repeat;
}

}  // namespace

scene::Texture read_texture(Source& source, const json& object, const char* key) {
  scene::Texture out;
  const json& info = list(object, key);
  if (info.empty()) return out;
  const size_t index = info["index"];
  const tinygltf::Texture& texture = source.model.textures[index];
  if (texture.source < 0) {
    source.warnings.add(at("textures", index) + " has no image in a format that is read: ignored");
    return out;
  }
  const auto image = static_cast<size_t>(texture.source);
  const auto [known, fresh] =
      source.bitmaps.try_emplace(source.document.images[image].bytes, source.scene.bitmaps.size());
  if (fresh) source.scene.bitmaps.push_back(decode(source, image));
  out.bitmap = static_cast<int>(known->second);
  out.texcoord_set = info["texCoord"];
  if (texture.sampler >= 0) {
    const tinygltf::Sampler& sampler = source.model.samplers[static_cast<size_t>(texture.sampler)];
    out.wrap_u = wrap(sampler.wrapS);
    out.wrap_v = wrap(sampler.wrapT);
    if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) out.filter = scene::Filter::nearest;
  }
  // KHR_texture_transform: uv' = T R S uv, the rotation counter-clockwise as seen with v pointing down.
  const json& e = list(list(info, "extensions"), "KHR_texture_transform");
  if (e.empty()) return out;
  const std::array<double, 2> offset = e["offset"], scale = e["scale"];
  const double rotation = e["rotation"], c = std::cos(rotation), s = std::sin(rotation);
  out.a = as_float(c * scale[0]), out.b = as_float(s * scale[1]), out.c = as_float(offset[0]);
  out.d = as_float(-s * scale[0]), out.e = as_float(c * scale[1]), out.f = as_float(offset[1]);
  out.texcoord_set = e.value("texCoord", out.texcoord_set);
  return out;
}

}  // namespace gltf
