// A glTF primitive to indexed triangles. Data that is wrong in itself (an index past the end, attributes of
// different lengths or types) is refused; data that is merely useless (degenerate triangles, NaN positions,
// zero normals) is mended or left out with a warning, because real assets are full of it.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "gltf/reader.h"

namespace gltf {
using base::fail_in;
using math::Vec2;
using math::Vec3;
using math::Vec4;

namespace {

// Beyond this, Embree's arithmetic has no meaning (its own bound is 1.8e19).
constexpr float largest_coordinate = 1e18f;

class Primitive {
 public:
  Primitive(Source& source, size_t mesh, size_t primitive)
      : source_(source),
        mesh_(source.model.meshes[mesh]),
        primitive_(mesh_.primitives[primitive]),
        place_("meshes[" + std::to_string(mesh) + "].primitives[" + std::to_string(primitive) + ']') {
    out_.name = mesh_.name + (primitive == 0 ? "" : "[" + std::to_string(primitive) + ']');
  }

  std::optional<scene::Mesh> read() {
    if (primitive_.mode < 4) return nothing("points and lines are not rendered");
    if (!primitive_.targets.empty())
      source_.warnings.add("morph targets are ignored: the base shape is rendered");
    if (primitive_.attributes.count("POSITION") == 0) return nothing("it has no POSITION");
    read_attributes();
    read_triangles();
    drop_unusable_positions();
    if (out_.triangles.empty()) return nothing("it has no triangles");
    mend_normals();
    mend_tangents();
    return std::move(out_);
  }

 private:
  std::nullopt_t nothing(const std::string& why) {
    warn("is left out: " + why);
    return std::nullopt;
  }
  void warn(const std::string& what) { source_.warnings.add(place_ + " (" + mesh_.name + ") " + what); }

  // The accessor of an attribute, after checking that its type is one the specification allows and that it
  // has one element per vertex; -1 if the primitive has none.
  int attribute(const std::string& name, std::initializer_list<int> types, bool integers) {
    const auto found = primitive_.attributes.find(name);
    if (found == primitive_.attributes.end()) return -1;
    const std::string place = place_ + ".attributes." + name;
    const tinygltf::Accessor& accessor = source_.model.accessors[static_cast<size_t>(found->second)];
    if (std::find(types.begin(), types.end(), accessor.type) == types.end())
      fail_in(source_.document.file, place, "elements of " + std::to_string(*types.begin()) + " components",
              std::to_string(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type))));
    const bool small_unsigned = accessor.componentType == 5121 || accessor.componentType == 5123;
    if (accessor.componentType != 5126 && !(integers && small_unsigned && accessor.normalized))
      fail_in(source_.document.file, place,
              integers ? "floats or normalized unsigned bytes or shorts" : "floats",
              "componentType " + std::to_string(accessor.componentType) +
                  (accessor.normalized ? " normalized" : ""));
    const size_t vertices =
        source_.model.accessors[static_cast<size_t>(primitive_.attributes.at("POSITION"))].count;
    if (accessor.count != vertices)
      fail_in(source_.document.file, place, std::to_string(vertices) + " elements like POSITION",
              std::to_string(accessor.count));
    return found->second;
  }

  void read_attributes() {
    const int position = attribute("POSITION", {TINYGLTF_TYPE_VEC3}, false);
    const size_t count = source_.model.accessors[static_cast<size_t>(position)].count;
    if ((source_.vertices += count) > source_.limits.vertices)
      fail_in(source_.document.file, place_,
              "at most " + std::to_string(source_.limits.vertices) + " vertices in all", "more");
    const auto vec3s = [&](int accessor) {
      const std::vector<float> f = read_floats(source_, accessor);
      std::vector<Vec3> out(f.size() / 3);
      for (size_t i = 0; i < out.size(); ++i) out[i] = {f[3 * i], f[3 * i + 1], f[3 * i + 2]};
      return out;
    };
    out_.positions = vec3s(position);
    if (const int a = attribute("NORMAL", {TINYGLTF_TYPE_VEC3}, false); a >= 0) out_.normals = vec3s(a);
    if (const int a = attribute("TANGENT", {TINYGLTF_TYPE_VEC4}, false); a >= 0) {
      const std::vector<float> f = read_floats(source_, a);
      for (size_t i = 0; i < f.size(); i += 4) out_.tangents.push_back({f[i], f[i + 1], f[i + 2], f[i + 3]});
    }
    for (const int set : {0, 1}) {
      const int a = attribute("TEXCOORD_" + std::to_string(set), {TINYGLTF_TYPE_VEC2}, true);
      if (a < 0) continue;
      bool bad = false;
      const std::vector<float> f = read_floats(source_, a);
      for (size_t i = 0; i < f.size(); i += 2) {
        const bool good = std::isfinite(f[i]) && std::isfinite(f[i + 1]);
        out_.texcoords[set].push_back(good ? Vec2{f[i], f[i + 1]} : Vec2{0, 0});
        bad |= !good;
      }
      if (bad) warn("has texture coordinates that are not finite: 0 is used for them");
    }
    read_colors();
  }

  void read_colors() {
    const int a = attribute("COLOR_0", {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4}, true);
    if (a < 0) return;
    const size_t channels =
        source_.model.accessors[static_cast<size_t>(a)].type == TINYGLTF_TYPE_VEC3 ? 3 : 4;
    std::vector<float> f = read_floats(source_, a);
    bool bad = false;
    for (float& x : f) {
      const float clamped = x >= 0 ? std::min(x, 1.0f) : 0;  // NaN becomes 0
      bad |= clamped != x;
      x = clamped;
    }
    for (size_t i = 0; i < f.size(); i += channels)
      out_.colors.push_back({f[i], f[i + 1], f[i + 2], channels == 4 ? f[i + 3] : 1});
    if (bad) warn("has vertex colours outside [0,1]: they are clamped");
  }

  void read_triangles() {
    std::vector<std::uint32_t> indices;
    if (primitive_.indices >= 0) {
      const std::string place = place_ + ".indices";
      const tinygltf::Accessor& accessor = source_.model.accessors[static_cast<size_t>(primitive_.indices)];
      const int type = accessor.componentType;
      if (accessor.type != TINYGLTF_TYPE_SCALAR || accessor.normalized ||
          (type != 5121 && type != 5123 && type != 5125))
        fail_in(source_.document.file, place, "unsigned integers", "another accessor type");
      indices = read_indices(source_, primitive_.indices);
      for (size_t i = 0; i < indices.size(); ++i)
        if (indices[i] >= out_.positions.size())
          fail_in(source_.document.file, place + "[" + std::to_string(i) + ']',
                  "a vertex below " + std::to_string(out_.positions.size()), std::to_string(indices[i]));
    } else {
      indices.resize(out_.positions.size());
      for (size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint32_t>(i);
    }

    const auto add = [&](size_t a, size_t b, size_t c) {
      const math::UVec3 t{indices[a], indices[b], indices[c]};
      if (t.x != t.y && t.y != t.z && t.z != t.x) out_.triangles.push_back(t);
    };
    const size_t n = indices.size();
    if (primitive_.mode == TINYGLTF_MODE_TRIANGLES) {
      if (n % 3 != 0)
        warn("has " + std::to_string(n) + " indices, not a multiple of 3: the last ones are left out");
      for (size_t i = 0; i + 2 < n; i += 3) add(i, i + 1, i + 2);
    } else if (primitive_.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      for (size_t i = 0; i + 2 < n; ++i) add(i, i + 1 + i % 2, i + 2 - i % 2);
    } else {
      for (size_t i = 0; i + 2 < n; ++i) add(i + 1, i + 2, 0);
    }
  }

  // Leave out triangles with positions that are not finite or huge; move such vertices onto a good one, so
  // that no bounding box ever sees them.
  void drop_unusable_positions() {
    const auto good = [&](const Vec3& p) {
      return math::max_component(math::abs(p)) < largest_coordinate && math::is_finite(p);
    };
    const auto usable = [&](const math::UVec3& t) {
      return good(out_.positions[t.x]) && good(out_.positions[t.y]) && good(out_.positions[t.z]);
    };
    const size_t before = out_.triangles.size();
    std::erase_if(out_.triangles, [&](const math::UVec3& t) { return !usable(t); });
    if (out_.triangles.empty()) return;
    if (const size_t dropped = before - out_.triangles.size(); dropped > 0)
      warn("has " + std::to_string(dropped) +
           " triangles with positions that are not finite or beyond 1e18: left out");
    const Vec3 home = out_.positions[out_.triangles[0].x];
    for (Vec3& p : out_.positions)
      if (!good(p)) p = home;
  }

  // Normalise; a normal of no usable length becomes the geometric normal of a triangle at its vertex. If none
  // is usable, the mesh is one without normals.
  void mend_normals() {
    if (out_.normals.empty()) return;
    std::vector<bool> bad(out_.normals.size());
    size_t bad_count = 0;
    for (size_t i = 0; i < out_.normals.size(); ++i) {
      const Vec3& n = out_.normals[i];
      const double length =
          std::hypot(static_cast<double>(n.x), static_cast<double>(n.y), static_cast<double>(n.z));
      bad[i] = !(length > 1e-6 && length < 1e6);
      bad_count += bad[i];
      // A normal that is unit but for rounding stays as it is: the same bits for every witness.
      if (!bad[i] && std::fabs(length - 1) > 1e-6) out_.normals[i] = math::normalize(n);
    }
    if (bad_count == 0) return;
    warn("has " + std::to_string(bad_count) + " normals of no usable length: geometric ones are used");
    if (bad_count == bad.size()) return out_.normals.clear();
    for (const math::UVec3& t : out_.triangles)
      for (const std::uint32_t v : {t.x, t.y, t.z}) {
        if (!bad[v]) continue;
        const Vec3 normal = geometric_normal(t);
        if (math::is_black(normal)) continue;
        out_.normals[v] = normal;
        bad[v] = false;
      }
    for (size_t i = 0; i < bad.size(); ++i)
      if (bad[i]) out_.normals[i] = {0, 0, 1};  // of no triangle that has an area
  }

  Vec3 geometric_normal(const math::UVec3& t) const {
    const Vec3 &a = out_.positions[t.x], &b = out_.positions[t.y], &c = out_.positions[t.z];
    // In double: the products of float differences neither overflow nor vanish.
    const double ux = double{b.x} - a.x, uy = double{b.y} - a.y, uz = double{b.z} - a.z;
    const double vx = double{c.x} - a.x, vy = double{c.y} - a.y, vz = double{c.z} - a.z;
    const double n[3] = {uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx};
    const double length = std::hypot(n[0], n[1], n[2]);
    if (!(length > 0)) return {0, 0, 0};
    return {static_cast<float>(n[0] / length), static_cast<float>(n[1] / length),
            static_cast<float>(n[2] / length)};
  }

  // Tangents are all good or not there: the renderer then derives them from the texture coordinates.
  void mend_tangents() {
    if (out_.tangents.empty()) return;
    bool bad = out_.normals.empty();  // a tangent frame needs the normal it was made for
    for (size_t i = 0; i < out_.tangents.size() && !bad; ++i) {
      Vec4& t = out_.tangents[i];
      const Vec3 unit = math::normalize({t.x, t.y, t.z}, {0, 0, 0});
      const float along = math::dot(unit, out_.normals[i]);
      bad = math::is_black(unit) || !(std::fabs(along) < .999f);
      t = {unit.x, unit.y, unit.z, t.w < 0 ? -1.0f : 1.0f};
    }
    if (!bad) return;
    warn("has unusable tangents: all of them are derived from the texture coordinates");
    out_.tangents.clear();
  }

  Source& source_;
  const tinygltf::Mesh& mesh_;
  const tinygltf::Primitive& primitive_;
  const std::string place_;
  scene::Mesh out_;
};

}  // namespace

std::optional<scene::Mesh> read_primitive(Source& source, size_t mesh, size_t primitive) {
  return Primitive(source, mesh, primitive).read();
}

}  // namespace gltf
