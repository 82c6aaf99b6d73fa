// How long after an interaction its first picture is there.
#pragma once

#include "view/session.h"

namespace view {

// Turns the camera `edits` times by a little, at various moments of the rendering before, and waits for each
// preview. Prints what it measured.
void measure(Session& session, int edits);

}  // namespace view
