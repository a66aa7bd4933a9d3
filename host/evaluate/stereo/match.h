#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/base/fixed.h"
#include "dsp/base/thread_team.h"
#include "host/evaluate/workspace.h"
#include "lab/match_params.h"
#include "lab/search/annealing.h"

namespace stof::host {

// A request to `stof evaluate`, as text from the command line.
struct MatchRequest {
  std::string preset;  // of dsp/stereo/match_params.h; empty: a method alone, dense and integer
  // Options of dsp/stereo/match_options.h and their values. "method" may also be "sa".
  std::vector<std::pair<std::string, std::string>> settings;
  bool hill_climbing = false;                        // of sa
  std::optional<std::uint64_t> seed = std::nullopt;  // of sa; without it MatchPlan's
  bool energy = false;                               // of the map, on the cost it was matched with
  int runs = 5;                                      // of which the median time is taken
  int threads = 1;  // that match, 1 .. dsp::ThreadTeam::kMost; not those of sa
};

// The parameters that follow from a request for one scene.
struct MatchPlan {
  lab::MatchParams params;
  // Simulated annealing, which begins with the map of params.
  std::optional<lab::Acceptance> annealing = std::nullopt;
  std::uint64_t seed = 1;
  bool energy = false;
  int runs = 5;
  int threads = 1;
};

// The plan for a scene of `disparities` candidates, or one line that says which option is unknown,
// out of range, does not go with another or does nothing with the method and cost.
std::expected<MatchPlan, dataset::Problem> match_plan(const MatchRequest& request, int disparities);

// The request in words, such as "wta, sad 16x16, lr 1".
std::string describe(const MatchRequest& request);

struct MatchResult {
  dataset::Image<dsp::Disparity> disparity;  // of the left view
  dataset::Image<std::uint8_t> filled;       // 1: made up, not matched
  double median_ms = 0;                      // of matching alone
  // E = sum C + lambda sum |d - d'|, where it is asked for.
  std::optional<std::uint64_t> energy = std::nullopt;
};

// Runs lab::Matcher over the scene; the maps are the same for any number of threads. One line when
// the scene is too large for it, or the system has no such number of threads.
dataset::Loaded<MatchResult> match_scene(const dataset::StereoScene& scene,
                                         const lab::MatchParams& params, int runs, int threads = 1);
// The same, and what the plan adds to it.
dataset::Loaded<MatchResult> match_scene(const dataset::StereoScene& scene, const MatchPlan& plan);

// The line of who asked for more threads than the system gives.
std::string too_few_threads(int there, int asked);

// Median time in ms of `runs` calls, at least one.
double median_time_ms(int runs, const std::function<void()>& work);

}  // namespace stof::host
