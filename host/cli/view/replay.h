#pragma once

#include "host/cli/view/view.h"

namespace stof::host {

// Whether SENSOR names a recording: a regular file.
bool is_recording(const ViewOptions& options);

// `stof view FILE`: shows a recording on the page, at the pace at which it was recorded, again and
// again until a signal comes. Throws Failure.
void replay(const ViewOptions& options);

}  // namespace stof::host
