// The pictures of one case as HTML: for the golden and for each witness ours, theirs, the error map, the
// signed difference and the significance of tiles, all of one comparison at one exposure.
#pragma once

#include <map>
#include <string>

#include "image/image.h"
#include "report/parts.h"
#include "report/pixels.h"
#include "report/results.h"

namespace report {

class Gallery {
 public:
  Gallery(std::string build, const CaseResult& result, Floats& floats);

  std::string golden_html();

  struct Witness {
    std::string html;            // empty for a closed form, which has no pictures
    std::optional<Parts> parts;  // where both are radiance with variances
  };
  Witness witness(const Json& witness);

 private:
  struct Picture {
    Estimate pixels;    // three channels; empty if there is none, and then
    std::string fault;  // says why
    bool empty() const { return pixels.mean.empty(); }
  };
  struct Comparison;
  struct Figure;

  const Picture& load(const std::string& path, const std::string& layer = "");
  double exposure_for(const image::Image& image) const;
  std::string figure_html(const Figure& figure, const image::Image& floats, const image::Image& encoded);
  std::string picture_html(const Comparison& comparison, const std::string& name, const char* role,
                           const Picture& picture);
  std::string pair_html(const Comparison& comparison);
  std::string map_html(const Comparison& comparison);
  std::string difference_html(const Comparison& comparison, const Picture& ours, const Picture& theirs);
  std::string tiles_html(const Json& tiles, const std::string& group, const image::Image& ours);

  std::string build_;
  const Json& result_;
  Floats& floats_;
  bool needs_floats_;                        // see Floats::add
  std::map<std::string, Picture> pictures_;  // from path and layer
  double exposure_ = 0;                      // the case's: the middle of the golden's stored ones
};

}  // namespace report
