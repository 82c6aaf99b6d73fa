// The pictures of one case as HTML: for the golden and for each witness ours, theirs, the error map and the
// signed difference, all of one comparison at one exposure.
#pragma once

#include <map>
#include <string>

#include "image/image.h"
#include "report/pixels.h"
#include "report/results.h"

namespace report {

class Gallery {
 public:
  Gallery(std::string build, const Json& result, Floats& floats);

  std::string golden_html();
  std::string witness_html(const Json& witness);  // empty for a closed form, which has no pictures

 private:
  struct Picture {
    image::Image pixels;  // three channels; empty if there is none, and then
    std::string fault;    // says why
  };
  struct Comparison;

  const Picture& load(const std::string& path, const std::string& layer = "");
  double exposure_for(const image::Image& image) const;
  std::string pair_html(const Comparison& comparison);
  std::string theirs_html(const Comparison& comparison, const Picture& theirs, const Picture& ours);
  std::string map_html(const Comparison& comparison);
  std::string difference_html(const Comparison& comparison, const Picture& ours, const Picture& theirs);
  std::string significance_html(const image::Image& ours) const;

  std::string build_;
  const Json& result_;
  Floats& floats_;
  std::map<std::string, Picture> pictures_;  // from path and layer
  double exposure_ = 0;                      // the case's: the middle of the golden's stored ones
};

}  // namespace report
