// A glTF primitive to indexed triangles. Data that is wrong in itself (an index past the end, attributes of
// different lengths or types) is refused; data that is merely useless (degenerate triangles, NaN positions,
// zero normals) is mended or left out with a warning, because real assets are full of it.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "gltf/accessor.h"

namespace gltf {
using math::DVec3;
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
        place_(at(at("meshes", mesh) + ".primitives", primitive)) {
    out_.name = primitive == 0 ? mesh_.name : at(mesh_.name, primitive);
  }

  std::optional<scene::Mesh> read() {
    if (primitive_.mode < 4) return nothing("points and lines are not rendered");
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
  const tinygltf::Accessor& accessor(int index) const {
    return source_.model.accessors[static_cast<size_t>(index)];
  }
  void warn(const std::string& what) { source_.warnings.add(place_ + " (" + mesh_.name + ") " + what); }

  // The values of an attribute, after checking that its type is one the specification allows and that it has
  // one element per vertex; empty if the primitive has none. It has as many components as Vec, or at least
  // `least`.
  template <typename Vec>
  std::vector<Vec> attribute(const std::string& name, bool integers, int least = Vec::length(),
                             const Vec& fill = Vec(0)) {
    const auto found = primitive_.attributes.find(name);
    if (found == primitive_.attributes.end()) return {};
    const std::string place = place_ + ".attributes." + name;
    const tinygltf::Accessor& a = accessor(found->second);
    // tinygltf's code for VEC3 is 3.
    source_.document.want(a.type >= least && a.type <= Vec::length(), place,
                          "elements of " + std::to_string(least) + " components",
                          tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type)));
    const bool fraction = a.normalized && is_unsigned(a) && component_size(a.componentType) < 4;
    source_.document.want(
        a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT || (integers && fraction), place,
        integers ? "floats or normalized unsigned bytes or shorts" : "floats",
        "componentType " + std::to_string(a.componentType) + (a.normalized ? " normalized" : ""));
    const size_t vertices = accessor(primitive_.attributes.at("POSITION")).count;
    source_.document.want(a.count == vertices, place, std::to_string(vertices) + " elements like POSITION",
                          a.count);
    return read_accessor(source_, found->second, fill);
  }

  void read_attributes() {
    out_.positions = attribute<Vec3>("POSITION", false);
    out_.normals = attribute<Vec3>("NORMAL", false);
    out_.tangents = attribute<Vec4>("TANGENT", false);
    bool bad = false;
    for (const int set : {0, 1}) {
      out_.texcoords[set] = attribute<Vec2>("TEXCOORD_" + std::to_string(set), true);
      for (Vec2& t : out_.texcoords[set])
        if (!std::isfinite(t.x) || !std::isfinite(t.y)) t = {0, 0}, bad = true;
    }
    if (bad) warn("has texture coordinates that are not finite: 0 is used for them");
    out_.colors = attribute<Vec4>("COLOR_0", true, 3, {0, 0, 0, 1});
    bad = false;
    for (Vec4& color : out_.colors)
      for (int c = 0; c < 4; ++c)
        if (const float x = color[c]; !(x >= 0 && x <= 1))
          color[c] = x > 1 ? 1.0f : 0.0f, bad = true;  // NaN: 0
    if (bad) warn("has vertex colours outside [0,1]: they are clamped");
  }

  void read_triangles() {
    std::vector<std::uint32_t> indices(out_.positions.size());
    std::iota(indices.begin(), indices.end(), 0u);
    if (primitive_.indices >= 0) {
      const std::string place = place_ + ".indices";
      const tinygltf::Accessor& a = accessor(primitive_.indices);
      source_.document.want(a.type == TINYGLTF_TYPE_SCALAR && is_unsigned(a) && !a.normalized, place,
                            "unsigned integers", "another accessor type");
      indices = read_accessor(source_, primitive_.indices, 0u);
      for (size_t i = 0; i < indices.size(); ++i)
        if (indices[i] >= out_.positions.size())
          source_.document.fail(at(place, i), "a vertex below " + std::to_string(out_.positions.size()),
                                indices[i]);
    }

    const auto add = [&](size_t a, size_t b, size_t c) {
      const math::UVec3 t{indices[a], indices[b], indices[c]};
      if (t.x != t.y && t.y != t.z && t.z != t.x) out_.triangles.push_back(t);
    };
    const size_t n = indices.size();
    const bool list = primitive_.mode == TINYGLTF_MODE_TRIANGLES;
    source_.document.take(place_, list ? n / 3 : n, 2 * sizeof(math::UVec3));  // the vector grows
    if (list) {
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
    std::vector<Vec3>& normals = out_.normals;
    const auto length = [](const Vec3& n) { return std::hypot(double{n.x}, double{n.y}, double{n.z}); };
    const auto bad = [&](const Vec3& n) { return !(length(n) > 1e-6 && length(n) < 1e6); };
    const auto bad_count = static_cast<size_t>(std::count_if(normals.begin(), normals.end(), bad));
    if (bad_count > 0) {
      warn("has " + std::to_string(bad_count) + " normals of no usable length: geometric ones are used");
      if (bad_count == normals.size()) return normals.clear();
      for (const math::UVec3& t : out_.triangles)
        for (const std::uint32_t v : {t.x, t.y, t.z})
          if (bad(normals[v])) normals[v] = geometric_normal(t);
    }
    for (Vec3& n : normals)
      if (bad(n))
        n = {0, 0, 1};  // of no triangle that has an area
      else if (std::fabs(length(n) - 1) > 1e-6)
        n = math::normalize(n);  // else unit but for rounding, and kept: the same bits for every witness
  }

  // 0 if the triangle has no area. In double: the products of float differences neither overflow nor vanish.
  Vec3 geometric_normal(const math::UVec3& t) const {
    const DVec3 a(out_.positions[t.x]), u = DVec3(out_.positions[t.y]) - a,
                                        v = DVec3(out_.positions[t.z]) - a;
    const DVec3 n(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
    const double length = std::hypot(n.x, n.y, n.z);
    return length > 0 ? Vec3(n / length) : Vec3(0);
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
