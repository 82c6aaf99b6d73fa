// Float arrays in an EXR header, as text "float[3] 1 2.5 -3": OpenImageIO 2.4 drops array attributes
// silently.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace image {

std::string floats_to_text(const std::vector<float>& floats);

// Nothing if the text is not of that form.
std::optional<std::vector<float>> floats_from_text(const std::string& text);

}  // namespace image
