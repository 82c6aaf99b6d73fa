#include "accel/accel.h"

#include <embree3/rtcore.h>

#include <chrono>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace accel {

namespace {

// Embree asserts on larger components (and Debian's build has its asserts on, so one bad ray would end the
// process).
constexpr float embree_limit = 1.844e18f;

// `limit` is that of Embree, or what is left of it for rays that go into instances (limit_of).
bool valid(const Ray& r, float limit) {
  for (int i = 0; i < 3; ++i)
    if (!(std::fabs(r.origin[i]) < limit) || !(std::fabs(r.direction[i]) < limit)) return false;
  return r.t_max > 0;  // false for NaN
}

// Embree takes rays into an instance's space by the inverse of its matrix, and asserts there too. The largest
// component that a ray may have before; 0 for a matrix that has no inverse, or one that enlarges 1e12 times.
float limit_of(const math::Mat4& to_world) {
  const glm::dmat4 inverse = glm::inverse(glm::dmat4(to_world));
  const double growth = std::fmax(1., math::growth(inverse));
  for (int row = 0; row < 3; ++row)
    if (!(std::fabs(inverse[3][row]) < embree_limit / 4)) return 0;
  if (!(growth < 1e12)) return 0;
  return static_cast<float>(embree_limit / (2 * growth));
}

RTCRay to_embree(const Ray& r) {
  RTCRay e{};
  e.org_x = r.origin.x, e.org_y = r.origin.y, e.org_z = r.origin.z;
  e.dir_x = r.direction.x, e.dir_y = r.direction.y, e.dir_z = r.direction.z;
  // Embree's robust mode counts t = tnear as a hit, and a ray leaving a plane such as z = 0, whose points
  // carry no rounding error to offset by, starts at t = 0 exactly.
  e.tnear = std::numeric_limits<float>::min();
  e.tfar = r.t_max;
  e.mask = 0xffffffffu;
  return e;
}

struct Geometry {     // of one RTCGeometry that carries triangles, found through its user data
  int instance = -1;  // -1: shared mesh, look at the instance id
  const Filter* filter = nullptr;
};

struct Context {  // passed through Embree to the filter callback
  RTCIntersectContext embree;
  const Ray* ray;
  std::uint32_t key;
  const std::vector<int>* instance_of;  // top-level geometry id -> instance

  Context(const Ray& r, std::uint32_t k, const std::vector<int>& instances)
      : ray(&r), key(k), instance_of(&instances) {
    rtcInitIntersectContext(&embree);
  }
};

void filter_callback(const RTCFilterFunctionNArguments* args) {
  const auto& geometry = *static_cast<const Geometry*>(args->geometryUserPtr);
  const auto& context = *reinterpret_cast<const Context*>(args->context);
  const RTCHit hit = rtcGetHitFromHitN(args->hit, args->N, 0);
  Hit h;
  h.instance = geometry.instance >= 0 ? geometry.instance : (*context.instance_of)[hit.instID[0]];
  h.triangle = static_cast<int>(hit.primID);
  h.u = hit.u;
  h.v = hit.v;
  if (args->valid[0] == -1 && !(*geometry.filter)(*context.ray, h, context.key)) args->valid[0] = 0;
}

[[noreturn]] void embree_error(void*, RTCError code, const char* text) {
  if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  base::fail("Embree: ", text);
}

}  // namespace

struct Accel::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<RTCScene> shared;      // one per shared mesh
  std::vector<Geometry> geometries;  // user data, addresses must not move
  std::vector<int> instance_of;      // top-level geometry id -> instance
  Filter filter;
  double seconds = 0;
  std::string isa;
  float limit = embree_limit;  // of the components of rays

  ~Impl() {
    for (RTCScene s : shared)
      if (s) rtcReleaseScene(s);
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  RTCGeometry triangles(const scene::Mesh& mesh, const math::Mat4& to_world, Geometry* user) {
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
        g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions.size()));
    for (const math::Vec3& p : mesh.positions) {
      const math::Vec3 w = math::transform_point(to_world, p);
      *vertex++ = w.x, *vertex++ = w.y, *vertex++ = w.z;
    }
    auto* index = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
    for (const math::UVec3& t : mesh.triangles) *index++ = t.x, *index++ = t.y, *index++ = t.z;
    rtcSetGeometryUserData(g, user);
    if (user->filter) {
      rtcSetGeometryIntersectFilterFunction(g, filter_callback);
      rtcSetGeometryOccludedFilterFunction(g, filter_callback);
    }
    rtcCommitGeometry(g);
    return g;
  }
  void attach(RTCScene to, RTCGeometry g, int instance) {
    const unsigned id = rtcAttachGeometry(to, g);
    rtcReleaseGeometry(g);
    if (to != scene) return;
    if (instance_of.size() <= id) instance_of.resize(id + 1, -1);
    instance_of[id] = instance;
  }
  static void configure(RTCScene s) {
    // ROBUST: watertight edges (measured: 0 misses against up to 14 % far from the origin), for 5 to 20 % of
    // ray speed.
    rtcSetSceneFlags(s, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(s, RTC_BUILD_QUALITY_MEDIUM);
  }
};

Accel::Accel(const scene::Scene& scene, bool fastest_isa, const std::vector<bool>& filtered, Filter filter)
    : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  m.filter = std::move(filter);
  const auto start = std::chrono::steady_clock::now();
  // Instruction sets without FMA find the same triangle on every x86-64 (measured; with FMA a few hits in a
  // million differ), so the default is AVX where there is AVX and SSE4.2 otherwise. start_threads=0: the
  // build uses TBB.
  m.isa = fastest_isa ? "fastest" : __builtin_cpu_supports("avx") ? "avx" : "sse4.2";
  m.device = rtcNewDevice(fastest_isa ? "" : m.isa == "avx" ? "isa=avx" : "isa=sse4.2");
  if (!m.device) embree_error(nullptr, rtcGetDeviceError(nullptr), "could not start");
  rtcSetDeviceErrorFunction(m.device, embree_error, nullptr);
  m.scene = rtcNewScene(m.device);
  Impl::configure(m.scene);

  const std::vector<size_t> copies = scene::copies(scene);
  std::vector<char> mesh_filtered(scene.meshes.size(), 0);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const auto mesh = static_cast<size_t>(scene.instances[i].mesh);
    if (!filtered.empty() && filtered[i]) mesh_filtered[mesh] = 1;
  }
  m.shared.resize(scene.meshes.size(), nullptr);
  m.geometries.resize(scene.instances.size() + scene.meshes.size());
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const scene::Instance& instance = scene.instances[i];
    const auto mesh = static_cast<size_t>(instance.mesh);
    const Filter* f = mesh_filtered[mesh] ? &m.filter : nullptr;
    const float limit = copies[mesh] > 0 ? 0 : limit_of(instance.to_world);
    if (limit == 0) {  // placed directly: so it should be, or there is no way into its space
      m.geometries[i] = {static_cast<int>(i), f};
      m.attach(m.scene, m.triangles(scene.meshes[mesh], instance.to_world, &m.geometries[i]),
               static_cast<int>(i));
      continue;
    }
    if (!m.shared[mesh]) {
      m.shared[mesh] = rtcNewScene(m.device);
      Impl::configure(m.shared[mesh]);
      Geometry* user = &m.geometries[scene.instances.size() + mesh];
      *user = {-1, f};
      m.attach(m.shared[mesh], m.triangles(scene.meshes[mesh], math::Mat4(1.0f), user), -1);
      rtcCommitScene(m.shared[mesh]);
    }
    RTCGeometry g = rtcNewGeometry(m.device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(g, m.shared[mesh]);
    rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &instance.to_world[0][0]);
    rtcCommitGeometry(g);
    m.limit = std::fmin(m.limit, limit);
    m.attach(m.scene, g, static_cast<int>(i));
  }
  rtcCommitScene(m.scene);
  m.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Accel::~Accel() = default;

bool Accel::closest(const Ray& ray, std::uint32_t key, Hit& hit) const {
  if (!valid(ray, impl_->limit)) return false;
  Context context(ray, key, impl_->instance_of);
  RTCRayHit query;
  query.ray = to_embree(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &context.embree, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  const unsigned top =
      query.hit.instID[0] != RTC_INVALID_GEOMETRY_ID ? query.hit.instID[0] : query.hit.geomID;
  hit.instance = impl_->instance_of[top];
  hit.triangle = static_cast<int>(query.hit.primID);
  hit.u = query.hit.u;
  hit.v = query.hit.v;
  return true;
}

bool Accel::occluded(const Ray& ray, std::uint32_t key) const {
  if (!valid(ray, impl_->limit)) return false;
  Context context(ray, key, impl_->instance_of);
  RTCRay query = to_embree(ray);
  rtcOccluded1(impl_->scene, &context.embree, &query);
  return query.tfar < 0;
}

double Accel::build_seconds() const { return impl_->seconds; }
std::string Accel::isa() const { return impl_->isa; }

}  // namespace accel
