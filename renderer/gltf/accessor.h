// Accessors to vectors. The guard has proved every range read here; the *values* of sparse indices are
// checked here, where they are first seen.
#pragma once

#include <cstring>

#include "gltf/reader.h"

namespace gltf {

template <typename T>
T load(const unsigned char* p) {  // unaligned
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

// Bytes, shorts and ints are 5121, 5123 and 5125; their signed twins and float are even.
inline bool is_unsigned(const tinygltf::Accessor& accessor) { return accessor.componentType % 2 == 1; }

// One component of a type that is read at all: float and the unsigned ones. Exact.
inline double component(const unsigned char* p, int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? *p
         : type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? load<std::uint16_t>(p)
         : type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT   ? load<std::uint32_t>(p)
                                                          : double{load<float>(p)};
}

// All elements of an accessor whose type the caller has checked; `Element` is a vector of math/ or an
// unsigned integer. Integers are scaled to [0,1] if the accessor is `normalized`: the quotient in double,
// rounded to float, is the correctly rounded one. Components that the accessor has not keep those of `fill`;
// without a bufferView all are 0. Sparse values are put in place.
template <typename Element>
std::vector<Element> read_accessor(const Source& source, int index, const Element& fill) {
  const tinygltf::Accessor& accessor = source.model.accessors[static_cast<size_t>(index)];
  const std::string place = at("accessors", static_cast<size_t>(index));
  // Without a bufferView no range bounds the count.
  source.document.take(place, accessor.count, sizeof(Element));
  const int type = accessor.componentType,
            count = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
  const size_t size = component_size(type), packed = static_cast<size_t>(count) * size;
  const double scale = !accessor.normalized ? 1 : size == 1 ? 255 : 65535;
  std::vector<Element> out(accessor.count, fill);
  if (out.empty()) return out;
  const auto put = [&](size_t i, const unsigned char* p) {
    for (int c = 0; c < count; ++c, p += size)
      if constexpr (std::is_integral_v<Element>)
        out[i] = static_cast<Element>(component(p, type));
      else
        out[i][c] = static_cast<float>(component(p, type) / scale);
  };
  const auto bytes = [&](int view, size_t offset) {
    const tinygltf::BufferView& from = source.model.bufferViews[static_cast<size_t>(view)];
    return source.document.buffers[static_cast<size_t>(from.buffer)].data() + from.byteOffset + offset;
  };
  if (accessor.bufferView >= 0) {
    const size_t stride = source.model.bufferViews[static_cast<size_t>(accessor.bufferView)].byteStride;
    const unsigned char* first = bytes(accessor.bufferView, accessor.byteOffset);
    for (size_t i = 0; i < out.size(); ++i) put(i, first + i * (stride != 0 ? stride : packed));
  }
  if (!accessor.sparse.isSparse) return out;
  const auto& sparse = accessor.sparse;
  const unsigned char *target =
                          bytes(sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset)),
                      *value = bytes(sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset));
  size_t least = 0;
  for (int i = 0; i < sparse.count; ++i) {
    const size_t found = static_cast<size_t>(component(target, sparse.indices.componentType));
    if (found < least || found >= out.size())
      source.document.fail(place + ".sparse.indices",
                           "increasing indices below " + std::to_string(out.size()), found);
    put(found, value);
    least = found + 1, value += packed, target += component_size(sparse.indices.componentType);
  }
  return out;
}

}  // namespace gltf
