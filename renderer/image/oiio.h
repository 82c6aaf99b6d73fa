// What every use of OpenImageIO here starts with. Private to this room.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <memory>
#include <string>

namespace image {

// One thread each for OpenImageIO and OpenEXR: rendering has its own, and a suite of tiny images should not
// start pools.
inline void prepare_oiio() {
  static const bool done = OIIO::attribute("threads", 1) && OIIO::attribute("exr_threads", -1);
  static_cast<void>(done);
}

// Opens a file, or memory, as the format of one extension (".png") and as no other: OpenImageIO would go on
// to try every decoder it has. Null if it cannot; the reason is then in `error`.
inline std::unique_ptr<OIIO::ImageInput> open_as(const std::string& extension, const std::string& file,
                                                 OIIO::Filesystem::IOProxy* memory, std::string& error) {
  prepare_oiio();
  const std::string format = extension == ".exr" ? "openexr" : extension.substr(1);
  auto input = OIIO::ImageInput::create(format);
  OIIO::ImageSpec spec, wishes;
  wishes.attribute("oiio:UnassociatedAlpha", 1);
  if (!input) {
    error = OIIO::geterror();
  } else if (!(memory ? input->set_ioproxy(memory) : true) || !input->open(file, spec, wishes)) {
    error = input->geterror();
    input.reset();
  }
  return input;
}

}  // namespace image
