// What stands above the cases: the outcome, the histogram of p-values, the table of all witnesses, the
// filters.
#pragma once

#include <string>
#include <vector>

#include "report/card.h"
#include "report/results.h"

namespace report {

std::string header_html(const RunResults& results);

// One button per word that some case has, by groups; the page's script fills in the counts again.
std::string filters_html(const RunResults& results);

// Every comparison with another renderer or a closed form in one table.
std::string witnesses_html(const std::vector<WitnessRow>& rows);

// The p-values of the image's luminance, of all comparisons of pictures that are not the same bits, in twenty
// bins: the whole picture's, because a comparison's smallest p is a bound and lies high. Where only noise is
// left they are uniform.
std::string histograms_html(const RunResults& results);

}  // namespace report
