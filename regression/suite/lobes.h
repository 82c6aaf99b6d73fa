// Which lobe moved? The means of the parts into which a renderer can take its picture apart (docs/formats.md,
// "--layers lobes"), kept with each golden. They decide nothing: they explain a CHANGED.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"

namespace suite {

struct LobeMean {
  std::string name;           // "specular.direct"
  double mean = 0;            // luminance, over the picture
  double standard_error = 0;  // of that mean, by the part's variance layer
};

// Every layer NAME of three channels that has a NAME.variance, in the order of names.
std::vector<LobeMean> lobe_means(const image::Render& render);

// As a golden's header holds them. Throws base::Error, naming `file`, if they are damaged.
std::string to_text(const std::vector<LobeMean>& lobes);
std::vector<LobeMean> lobes_from_text(const std::string& text, const std::string& file);

// "by lobe: specular.direct -8.3 % (12 sigma), ...", the largest changes of the picture first, at most
// `most`; empty if no part moved by more than rounding. Sigma: as if the two were drawn with unrelated random
// numbers; with the golden's own a lobe that is sound stays the same to the bit.
std::string moved_lobes(const std::vector<LobeMean>& golden, const std::vector<LobeMean>& now, int most = 3);

}  // namespace suite
