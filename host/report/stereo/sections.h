#pragma once

#include "host/report/stereo/study.h"

// The sections of the report, each from its own experiments. Tables and figures leave out what
// the matcher refuses and what has no truth.
namespace stof::host {

void add_scenes(Study& study, Page& page);
void add_methods(Study& study, Page& page);      // Table 1
void add_block_time(Study& study, Page& page);   // cost matrix against block size
void add_maps(Study& study, Page& page);         // disparity, difference, 2.5D
void add_block_sizes(Study& study, Page& page);  // 30x10, 60x20, left-right check
void add_adaptive(Study& study, Page& page);     // cross and region blocks, edges
void add_interest(Study& study, Page& page);     // interest operators
void add_filters(Study& study, Page& page);      // histogram, subpixel
void add_brightness(Study& study, Page& page);
void add_pyramid(Study& study, Page& page);
void add_annealing(Study& study, Page& page);
void add_presets(Study& study, Page& page);
void add_corridor(Study& study, Page& page);

}  // namespace stof::host
