#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/base/fixed.h"
#include "dsp/stereo/matcher.h"

namespace stof::host {

// What `stof evaluate` was asked for, as text from the command line.
struct MatchOptions {
  std::string method = "wta";
  std::string cost = "sad";
  std::string block = "16x16";  // WxH, 1x1 to 64x64
  std::string preset;
  bool left_right = false;
  bool subpixel = false;
  bool fill = false;
  int runs = 5;  // of which the median time is taken
};

// Largest difference in px that `--lr` accepts between a match and the match of the match.
inline constexpr int kLeftRightTolerancePx = 1;

// The parameters for a scene of `disparities` candidates, or one line that says which option is
// unknown, out of range or not in this version.
std::expected<dsp::MatchParams, dataset::Problem> match_params(const MatchOptions& options,
                                                               int disparities);

// Options in words, such as "wta, sad 16x16, left-right check".
std::string describe(const MatchOptions& options);

struct MatchResult {
  dataset::Image<dsp::Disparity> disparity;  // of the left view
  double median_ms = 0;                      // of match() alone
};

// Runs dsp::Matcher over the scene. One line when the scene is too large for it.
dataset::Loaded<MatchResult> match_scene(const dataset::StereoScene& scene,
                                         const dsp::MatchParams& params, int runs);

// Median time in ms of `runs` calls, at least one.
double median_time_ms(int runs, const std::function<void()>& work);

// Memory for a dsp::Arena of `bytes`.
class Workspace {
 public:
  explicit Workspace(std::size_t bytes);
  dsp::Arena arena() noexcept;

 private:
  struct alignas(dsp::Arena::kAlign) Line {
    std::byte bytes[dsp::Arena::kAlign];
  };
  std::vector<Line> lines_;
};

}  // namespace stof::host
