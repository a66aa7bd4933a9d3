#pragma once

#include <cstdint>
#include <filesystem>

#include "host/cli/receive.h"
#include "host/cli/view/page_view.h"
#include "host/picture/colour_scale.h"

namespace stof::host {

struct ViewOptions : ReceiveOptions {
  std::uint64_t frames = 0;        // 0: until SIGINT or SIGTERM
  std::filesystem::path out;       // empty: no files
  std::filesystem::path truth;     // PFM, Z in metres, read when the first frame is there
  std::filesystem::path headless;  // folder of PNG files of frames; empty: none
  PageOptions page;
  ColourScale scale;
  // Raw pictures to ask the sensor for: none, unless some are named. Written to `out`.
  wire::RawRequest raw;
  std::uint64_t raw_count = 0;  // end after so many whole exposures; 0: as `frames` says
};

// Whether the browser gets a page: not where the command ends by itself (`frames`, `raw_count`) or
// writes pictures in the page's place (`headless`), unless a flag of the page asks for it.
bool has_page(const ViewOptions& options);

// `stof view`: receives, prints a line a second and a summary, serves the page, leaves pictures of
// the newest complete frame, and those of every raw exposure. Throws Failure.
void view(const ViewOptions& options);

}  // namespace stof::host
