// What the studies share: pictures made by the renderer and changed by a known amount.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "image/image.h"
#include "suite/case_file.h"
#include "suite/judge.h"
#include "suite/renderer_command.h"

namespace app {

// The same scene with black base colours, in `folder` beside copies of the files that it names. Its picture
// is what a scene keeps when the lobes that base colour weighs are gone.
std::string without_base_colour(const std::string& scene_file, const std::string& folder);

// A picture as if its radiance were factor(x, y) times as large, or mixed with another picture of the same
// seed: (1 - share) of the one and `share` of the other. Variance follows from the replicates.
image::Render scaled(const image::Render& picture, const std::function<double(int x, int y)>& factor);
image::Render mixed(const image::Render& picture, const image::Render& other, double share);

// What a golden of this render would hold.
suite::Golden as_golden(const suite::Case& c, const image::Render& picture);

// Calls study(i) for every case, as many at a time as there are processors; the renderer should take one
// thread each. The first exception ends it and is thrown again.
void for_each_case(std::size_t cases, const std::function<void(std::size_t)>& study);

// Renders, reads and deletes. A job that fails is a base::Error.
std::vector<image::Render> made_pictures(const suite::RendererCommand& renderer,
                                         const std::vector<suite::Job>& jobs, const std::string& scratch);

}  // namespace app
