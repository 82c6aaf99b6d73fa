// Pictures from disk, to look at beside our own.
#pragma once

#include <string>

#include "image/image.h"

namespace image {

// An .exr (channels R, G, B) or .hdr as it is, a .png or .jpg with the sRGB curve undone: radiance as far as
// the file has it. Values may be negative or not finite. Throws base::Error.
Image read_picture(const std::string& path);

}  // namespace image
