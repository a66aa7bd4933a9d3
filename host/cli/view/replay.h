#pragma once

#include "host/cli/view/view.h"

namespace stof::host {

// `stof view FILE`: shows a recording on the page, at the pace at which it was recorded, again and
// again until a signal comes. Throws Failure.
void replay(const ViewOptions& options);

}  // namespace stof::host
