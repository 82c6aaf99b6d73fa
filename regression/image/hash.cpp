#include "image/hash.h"

#include <openssl/evp.h>

#include <bit>
#include <cassert>
#include <cstdint>
#include <fstream>

#include "base/error.h"

namespace image {

static_assert(std::endian::native == std::endian::little, "pixel_hash is defined on little-endian bytes");

Hasher::Hasher() : context_(EVP_MD_CTX_new()) {
  if (!context_ || !EVP_DigestInit_ex(static_cast<EVP_MD_CTX*>(context_), EVP_sha256(), nullptr))
    base::fail("OpenSSL: cannot start SHA-256");
}

Hasher::~Hasher() { EVP_MD_CTX_free(static_cast<EVP_MD_CTX*>(context_)); }

void Hasher::add(std::string_view bytes) {
  EVP_DigestUpdate(static_cast<EVP_MD_CTX*>(context_), bytes.data(), bytes.size());
}

void Hasher::add_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) base::fail_in(path, "", "a file to hash", "none that can be opened");
  char block[1 << 16];
  while (file.read(block, sizeof block) || file.gcount() > 0)
    add({block, static_cast<std::size_t>(file.gcount())});
  if (file.bad() || !file.eof()) base::fail_in(path, "", "a file to hash", "an error while reading");
}

std::string Hasher::hex() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  EVP_DigestFinal_ex(static_cast<EVP_MD_CTX*>(context_), digest, &size);
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += "0123456789abcdef"[digest[i] >> 4];
    text += "0123456789abcdef"[digest[i] & 15];
  }
  return text;
}

std::string sha256(std::string_view bytes) {
  Hasher hasher;
  hasher.add(bytes);
  return hasher.hex();
}

std::string sha256_file(const std::string& path) {
  Hasher hasher;
  hasher.add_file(path);
  return hasher.hex();
}

std::string pixel_hash(const Image& rgb) {
  assert(rgb.channels == 3);
  Hasher hasher;
  const std::uint32_t size[2] = {static_cast<std::uint32_t>(rgb.width),
                                 static_cast<std::uint32_t>(rgb.height)};
  hasher.add({reinterpret_cast<const char*>(size), sizeof size});
  hasher.add({reinterpret_cast<const char*>(rgb.data.data()), rgb.data.size() * sizeof(float)});
  return hasher.hex();
}

}  // namespace image
