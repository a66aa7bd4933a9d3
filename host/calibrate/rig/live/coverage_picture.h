#pragma once

#include <vector>

#include "host/calibrate/rig/live/view_guide.h"
#include "host/picture/png.h"

namespace stof::host {

// What the views cover so far: of both eyes the corners that were found, the newest view's in
// orange, and the corners of the pictures, green where a view reaches them; below, a bar for each
// further want. width, height: of the cameras' pictures, which are drawn 320 px wide.
dataset::Image<Rgb> coverage_picture(const std::vector<PairView>& views,
                                     const std::vector<ViewWant>& wants, int width, int height);

}  // namespace stof::host
