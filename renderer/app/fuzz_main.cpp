// libFuzzer's entry, for scripts/fuzz: .gltf, .glb, PNG, JPEG, EXR and HDR, told apart by their first bytes.
// What random changes nearly always break, and a forger would mend, is mended and tried too: a .glb's lengths
// and a PNG's checksums.
#include "app/survive_test.h"

namespace {

void put(std::string& bytes, size_t at, std::uint32_t value, bool big_endian) {
  for (size_t i = 0; i < 4; ++i)
    bytes[at + i] = static_cast<char>(value >> 8 * (big_endian ? 3 - i : i) & 255);
}

std::uint32_t big_endian(const std::string& bytes, size_t at) {
  std::uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

std::uint32_t crc32(const std::string& bytes, size_t at, size_t length) {
  std::uint32_t crc = ~0u;
  for (size_t i = 0; i < 8 * length; ++i) {
    if (i % 8 == 0) crc ^= static_cast<unsigned char>(bytes[at + i / 8]);
    crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

std::string mended(std::string bytes) {
  if (bytes.size() > 28 && bytes.rfind("glTF", 0) == 0) {
    put(bytes, 8, static_cast<std::uint32_t>(bytes.size()), false);
  } else if (bytes.rfind("\x89PNG", 0) == 0) {
    for (size_t at = 8; at + 12 <= bytes.size();) {
      const size_t length = big_endian(bytes, at);
      if (bytes.size() - at - 12 < length) break;
      put(bytes, at + 8 + length, crc32(bytes, at + 4, length + 4), true);
      at += 12 + length;
    }
  }
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, size_t size) {
  static const std::string file = "/dev/shm/assay-fuzz-" + std::to_string(getpid()) + ".gltf";
  const std::string bytes(reinterpret_cast<const char*>(data), size), more = mended(bytes);
  app::survive(bytes, file);
  if (more != bytes) app::survive(more, file);
  return 0;
}
