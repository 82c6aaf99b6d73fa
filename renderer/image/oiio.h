// What every use of OpenImageIO here starts with. Private to this room.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

namespace image {

// One thread each for OpenImageIO and OpenEXR: rendering has its own, and a suite of tiny images should not
// start pools.
inline void prepare_oiio() {
  static const bool done = OIIO::attribute("threads", 1) && OIIO::attribute("exr_threads", -1);
  static_cast<void>(done);
}

}  // namespace image
