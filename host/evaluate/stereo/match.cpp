#include "host/evaluate/stereo/match.h"

#include <algorithm>
#include <array>
#include <chrono>

#include "dataset/files/file.h"
#include "host/evaluate/stereo/energy.h"
#include "host/evaluate/stereo/median.h"
#include "lab/match_options.h"
#include "lab/matcher.h"
#include "posix/worker_threads.h"

namespace stof::host {
namespace {

using dataset::Problem;

// The value given for an option, or empty.
std::string setting(const MatchRequest& request, const std::string& name) {
  const auto found =
      std::ranges::find(request.settings, name, &std::pair<std::string, std::string>::first);
  return found == request.settings.end() ? std::string() : found->second;
}

bool wants_annealing(const MatchRequest& request) { return setting(request, "method") == "sa"; }

// Where the settings begin: the preset, or what suits the method.
std::expected<lab::MatchParams, Problem> starting_params(const MatchRequest& request) {
  const std::string method = setting(request, "method");
  if (!request.preset.empty()) {
    const dsp::Preset* const preset = dsp::find_preset(request.preset);
    if (preset == nullptr) {
      return dataset::refuse("--preset " + request.preset + ": unknown: use one of " +
                             std::string(dsp::preset_names()));
    }
    return lab::as_the_appliance(preset->params);
  }
  if (wants_annealing(request)) {
    lab::MatchParams params = lab::method_defaults(lab::Method::kScanlineOptimisation);
    params.method = lab::Method::kWinnerTakesAll;
    return params;
  }
  lab::MatchParams params;
  if (!method.empty() && lab::find_match_option("method")->set(method, params)) {
    return lab::method_defaults(params.method);
  }
  return params;
}

// Empty, or a line about an option that does nothing with what was chosen beside it.
std::string unused_option(const MatchRequest& request, const MatchPlan& plan) {
  struct Use {
    const char* option;
    bool given;
    bool used;
    const char* belongs_to;
  };
  const auto given = [&request](const char* option) { return !setting(request, option).empty(); };
  const lab::MatchParams& params = plan.params;
  const bool mixed = params.cost == lab::Cost::kAdCensus;
  const bool has_energy = plan.annealing || plan.energy;
  const std::array<Use, 6> uses{{
      {"block", given("block"), !mixed || params.subpixel == dsp::Subpixel::kLeastSquares,
       "the costs sad, ssd and census, and to --subpixel=least-squares"},
      {"prefilter", given("prefilter"), !mixed || params.min_texture,
       "the costs sad, ssd and census, and to --texture"},
      {"penalties", given("penalties"), params.method != lab::Method::kWinnerTakesAll || has_energy,
       "the methods dp, so, sgm and sa, and to --energy"},
      {"directions", given("directions"), params.method == lab::Method::kSemiGlobal,
       "the method sgm"},
      {"hill-climbing", request.hill_climbing, plan.annealing.has_value(), "the method sa"},
      {"seed", request.seed.has_value(), plan.annealing.has_value(), "the method sa"},
  }};
  const Use* const idle =
      std::ranges::find_if(uses, [](const Use& use) { return use.given && !use.used; });
  return idle == uses.end() ? std::string()
                            : std::string("--") + idle->option +
                                  ": does nothing with this method and cost, it belongs to " +
                                  idle->belongs_to + ": leave it out";
}

}  // namespace

std::expected<MatchPlan, Problem> match_plan(const MatchRequest& request, int disparities) {
  const std::expected<lab::MatchParams, Problem> start = starting_params(request);
  if (!start) {
    return std::unexpected(start.error());
  }
  MatchPlan plan{.params = *start,
                 .seed = request.seed.value_or(MatchPlan{}.seed),
                 .energy = request.energy,
                 .runs = request.runs,
                 .threads = request.threads};
  plan.params.disparities = disparities;
  for (const auto& [name, value] : request.settings) {
    if (name == "method" && value == "sa") {
      plan.annealing =
          request.hill_climbing ? lab::Acceptance::kHillClimbing : lab::Acceptance::kMetropolis;
      continue;
    }
    const lab::MatchOption* const option = lab::find_match_option(name);
    if (option == nullptr || !option->set(value, plan.params)) {
      std::string message = "--" + name;
      message += " " + value + ": not one of its values: use ";
      message += option == nullptr ? "" : option->values;
      return dataset::refuse(message + (name == "method" ? ", or sa" : ""));
    }
  }
  if (const char* const why = lab::problem(plan.params); *why != '\0') {
    return dataset::refuse(why);
  }
  if (std::string idle = unused_option(request, plan); !idle.empty()) {
    return dataset::refuse(std::move(idle));
  }
  if (request.runs < 1) {
    return dataset::refuse("--runs " + std::to_string(request.runs) + ": too few: use 1 or more");
  }
  if (request.threads < 1 || request.threads > dsp::ThreadTeam::kMost) {
    return dataset::refuse("--threads " + std::to_string(request.threads) + ": use 1 to " +
                           std::to_string(dsp::ThreadTeam::kMost));
  }
  return plan;
}

std::string describe(const MatchRequest& request) {
  std::string text = request.preset.empty() ? "" : "preset " + request.preset;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (const auto& [name, value] : request.settings) {
    if (name == "method" || name == "cost" || name == "block") {
      add(value);
    } else {
      add(value == "on" ? name : std::string(name).append(" ").append(value));
    }
  }
  return text.empty() ? "wta, sad 16x16" : text;
}

std::string too_few_threads(int there, int asked) {
  return "--threads " + std::to_string(asked) + ": the system gives " + std::to_string(there) +
         ": use fewer";
}

dataset::Loaded<MatchResult> match_scene(const dataset::StereoScene& scene,
                                         const lab::MatchParams& params, int runs, int threads) {
  const int width = scene.left.width;
  const int height = scene.left.height;
  if (lab::check(params, width, height) != Status::kOk) {
    return dataset::refuse(
        scene.name + ": " + std::to_string(width) + "x" + std::to_string(height) + " pixels with " +
        std::to_string(params.disparities) +
        " disparities are more than this version matches: use a smaller picture or ndisp");
  }
  posix::WorkerThreads workers({.threads = threads});
  if (workers.threads() < threads) {
    return dataset::refuse(too_few_threads(workers.threads(), threads));
  }
  const dsp::ThreadTeam team(workers, threads);
  Workspace workspace(dsp::bytes_taken(
      [&](dsp::Arena& arena) { lab::Matcher(params, width, height, arena, team); }));
  dsp::Arena arena = workspace.arena();
  lab::Matcher matcher(params, width, height, arena, team);
  MatchResult result{.disparity = {width, height}, .filled = {width, height}};
  result.median_ms = median_time_ms(runs, [&] {
    matcher.match({.left = scene.left.view(), .right = scene.right.view()},
                  result.disparity.view());
  });
  const dsp::ImageView<const std::uint8_t> filled = matcher.filled();
  for (int y = 0; y < filled.height(); ++y) {
    std::ranges::copy(filled.row(y), result.filled.view().row(y).begin());
  }
  return result;
}

dataset::Loaded<MatchResult> match_scene(const dataset::StereoScene& scene, const MatchPlan& plan) {
  dataset::Loaded<MatchResult> result = match_scene(scene, plan.params, plan.runs, plan.threads);
  if (!result) {
    return result;
  }
  if (plan.annealing) {
    // Slow: once is enough.
    result->median_ms += median_time_ms(1, [&] {
      result->energy =
          anneal_map(scene, plan.params, *plan.annealing, plan.seed, result->disparity);
    });
  } else if (plan.energy) {
    result->energy = energy_of(scene, plan.params, result->disparity);
  }
  return result;
}

double median_time_ms(int runs, const std::function<void()>& work) {
  std::vector<double> times;
  for (int i = 0; i < std::max(runs, 1); ++i) {
    const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - begin;
    times.push_back(taken.count());
  }
  return median(std::move(times)).value_or(0);
}

}  // namespace stof::host
