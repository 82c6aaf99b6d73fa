// Accessors to vectors. The guard has proved every range read here; the *values* of sparse indices are
// checked here, where they are first seen.
#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "gltf/reader.h"

namespace gltf {
using base::fail_in;

namespace {

std::string place(int accessor) { return "accessors[" + std::to_string(accessor) + ']'; }

const unsigned char* bytes_of(const Source& source, int buffer_view, size_t offset) {
  const tinygltf::BufferView& view = source.model.bufferViews[static_cast<size_t>(buffer_view)];
  return source.model.buffers[static_cast<size_t>(view.buffer)].data.data() + view.byteOffset + offset;
}

template <typename T>
T load(const unsigned char* p) {  // unaligned
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

std::uint32_t load_index(const unsigned char* p, int component_type) {
  return component_type == 5121   ? *p
         : component_type == 5123 ? load<std::uint16_t>(p)
                                  : load<std::uint32_t>(p);
}

float load_float(const unsigned char* p, int component_type, bool normalized) {
  // glTF 2.0, section 3.11: signed integers clamp at -1.
  const auto scaled = [&](int value, int maximum) {
    const float f = static_cast<float>(value);
    return normalized ? std::max(f / static_cast<float>(maximum), -1.0f) : f;
  };
  switch (component_type) {
    case 5120:
      return scaled(load<std::int8_t>(p), 127);
    case 5121:
      return scaled(*p, 255);
    case 5122:
      return scaled(load<std::int16_t>(p), 32767);
    case 5123:
      return scaled(load<std::uint16_t>(p), 65535);
    case 5125:
      return static_cast<float>(load<std::uint32_t>(p));
    default:
      return load<float>(p);
  }
}

// Calls take(i, p) with every component i of the accessor and where it lies.
template <typename Take>
void each_component(const Source& source, int index, const Take& take) {
  const tinygltf::Accessor& accessor = source.model.accessors[static_cast<size_t>(index)];
  const size_t components =
      static_cast<size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
  const size_t size = component_size(accessor.componentType), element = components * size;
  const auto take_element = [&](size_t i, const unsigned char* p) {
    for (size_t c = 0; c < components; ++c) take(i * components + c, p + c * size);
  };
  if (accessor.bufferView >= 0) {
    const size_t stride = source.model.bufferViews[static_cast<size_t>(accessor.bufferView)].byteStride;
    const unsigned char* first = bytes_of(source, accessor.bufferView, accessor.byteOffset);
    for (size_t i = 0; i < accessor.count; ++i) take_element(i, first + i * (stride != 0 ? stride : element));
  }
  if (!accessor.sparse.isSparse) return;
  const auto& sparse = accessor.sparse;
  const unsigned char* at =
      bytes_of(source, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset));
  const unsigned char* values =
      bytes_of(source, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset));
  for (size_t i = 0, least = 0; i < static_cast<size_t>(sparse.count); ++i) {
    const size_t target =
        load_index(at + i * component_size(sparse.indices.componentType), sparse.indices.componentType);
    if (target < least || target >= accessor.count)
      fail_in(source.document.file, place(index) + ".sparse.indices",
              "increasing indices below " + std::to_string(accessor.count), std::to_string(target));
    take_element(target, values + i * element);
    least = target + 1;
  }
}

size_t component_total(const Source& source, int index) {
  const tinygltf::Accessor& accessor = source.model.accessors[static_cast<size_t>(index)];
  // Without a bufferView no range bounds the count.
  if (accessor.count > source.limits.vertices * 3)
    fail_in(source.document.file, place(index) + ".count",
            "at most " + std::to_string(source.limits.vertices * 3), std::to_string(accessor.count));
  return accessor.count *
         static_cast<size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
}

}  // namespace

std::vector<float> read_floats(const Source& source, int index) {
  const tinygltf::Accessor& accessor = source.model.accessors[static_cast<size_t>(index)];
  std::vector<float> out(component_total(source, index));
  each_component(source, index, [&](size_t i, const unsigned char* p) {
    out[i] = load_float(p, accessor.componentType, accessor.normalized);
  });
  return out;
}

std::vector<std::uint32_t> read_indices(const Source& source, int index) {
  const tinygltf::Accessor& accessor = source.model.accessors[static_cast<size_t>(index)];
  std::vector<std::uint32_t> out(component_total(source, index));
  each_component(source, index,
                 [&](size_t i, const unsigned char* p) { out[i] = load_index(p, accessor.componentType); });
  return out;
}

}  // namespace gltf
