// Pooling of an error map, in double precision.
#pragma once

#include <vector>

#include "metric/flip.h"

namespace metric {

// Fills mean, min, max and the weighted percentiles of `flip` from its map: sorted ascending, the first error
// whose running sum exceeds the share of the total; 0 if the total is 0.
void pool(Flip& flip);

}  // namespace metric
