#pragma once

#include "tests/bench/bench_work.h"

// Debian's OpenCV on the same inputs. How many threads it uses is set for the process:
// cv::setNumThreads().
namespace stof::bench {

void set_opencv_threads(int threads);
// "OpenCV 4.6.0".
std::string opencv_version();

// StereoBM, 15x15, prefilter cap 31. Dense: no texture or uniqueness check, so that every pixel is
// matched; else its defaults.
Work stereo_bm_work(const Pictures& pictures, int disparities, bool dense);
// StereoSGBM, 3x3, no filters; 3WAY or its five paths.
Work stereo_sgbm_work(const Pictures& pictures, int disparities, bool three_way);
// PMD samples to phase and amplitude: two differences and cartToPolar, in floats.
Work polar_work(const Samples& samples);
// Rectification of both pictures by remap() through fixed-point maps, the lenses of raw_rig().
Work remap_work(const Pictures& pictures);

}  // namespace stof::bench
