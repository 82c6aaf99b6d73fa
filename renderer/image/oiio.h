// What every use of OpenImageIO here starts with. Private to this room.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/file.h"
#include "image/image.h"

namespace image {

// One thread each for OpenImageIO and OpenEXR: rendering has its own, and a suite of tiny images should not
// start pools.
inline void prepare_oiio() {
  static const bool done = OIIO::attribute("threads", 1) && OIIO::attribute("exr_threads", -1);
  static_cast<void>(done);
}

// Opens a file, or memory, as the format of one extension (".png") and as no other: OpenImageIO would go on
// to try every decoder it has. Throws base::Error "NAME: cannot read: REASON".
inline std::unique_ptr<OIIO::ImageInput> open_as(const std::string& extension, const std::string& name,
                                                 OIIO::Filesystem::IOProxy* memory = nullptr) {
  prepare_oiio();
  auto input = OIIO::ImageInput::create(extension == ".exr" ? "openexr" : extension.substr(1));
  if (!input) base::fail(name, ": cannot read: ", OIIO::geterror());
  OIIO::ImageSpec spec, wishes;
  wishes.attribute("oiio:UnassociatedAlpha", 1);
  if (memory) input->set_ioproxy(memory);
  if (!input->open(memory ? "memory" : name, spec, wishes))
    base::fail(name, ": cannot read: ", input->geterror());
  return input;
}

// The channels R, G, B of an open file, which stand together. Throws base::Error naming `name`.
inline Image read_rgb(OIIO::ImageInput& input, const std::string& name) {
  const OIIO::ImageSpec& spec = input.spec();
  int first = -1;
  for (int c = 0; c + 2 < spec.nchannels; ++c)
    if (spec.channel_name(c) == "R" && spec.channel_name(c + 1) == "G" && spec.channel_name(c + 2) == "B")
      first = c;
  if (first < 0) base::fail(name, ": wanted channels R, G, B, found others");
  Image image(spec.width, spec.height);
  static_assert(sizeof(math::Vec3) == 3 * sizeof(float));
  if (!input.read_image(0, 0, first, first + 3, OIIO::TypeFloat, image.pixels.data()))
    base::fail(name, ": cannot read: ", input.geterror());
  return image;
}

// Encodes `pixels`, of the type and the layout of `spec`, in memory as the format of one extension and writes
// them in one piece. Throws base::Error "PATH: cannot write: REASON".
inline void write_as(const std::string& extension, const std::string& path, const OIIO::ImageSpec& spec,
                     OIIO::TypeDesc type, const void* pixels) {
  prepare_oiio();
  const std::string name = "memory" + extension;
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create(name);
  if (!output) base::fail(path, ": cannot write: ", OIIO::geterror());
  if (!output->set_ioproxy(&memory) || !output->open(name, spec) || !output->write_image(type, pixels) ||
      !output->close())
    base::fail(path, ": cannot write: ", output->geterror());
  write_whole(path, bytes.data(), bytes.size());
}

}  // namespace image
