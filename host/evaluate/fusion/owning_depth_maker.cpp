#include "host/evaluate/fusion/owning_depth_maker.h"

#include "dataset/files/file.h"
#include "dsp/fusion/interval/disparity_sigma.h"
#include "host/evaluate/stereo/match.h"

namespace stof::host {

OwningDepthMaker::OwningDepthMaker(const dsp::Calibration& calibration,
                                   const lab::MatchParams& match, int threads)
    : calibration_(calibration),
      match_(match),
      workers_({.threads = threads}),
      continued_(calibration_.stereo.left.width, calibration_.stereo.left.height) {}

dataset::Loaded<std::unique_ptr<OwningDepthMaker>> OwningDepthMaker::make(
    const std::string& scene, const dsp::Calibration& rig, int width, int height,
    const lab::MatchParams& match, const DepthMakerOptions& options) {
  dsp::Calibration calibration = rig;
  calibration.stereo.left.width = width;
  calibration.stereo.left.height = height;
  if (const std::string wrong = dsp::problem(calibration); !wrong.empty()) {
    return dataset::refuse(scene + ": " + wrong + ": correct the rig");
  }
  if (lab::check(match, width, height) != Status::kOk) {
    return dataset::refuse(scene + ": " + std::to_string(width) + "x" + std::to_string(height) +
                           " pixels with " + std::to_string(match.disparities) +
                           " disparities are more than this version matches: use a smaller "
                           "picture");
  }
  std::unique_ptr<OwningDepthMaker> made(new OwningDepthMaker(calibration, match, options.threads));
  if (made->workers_.threads() < options.threads) {
    return dataset::refuse(too_few_threads(made->workers_.threads(), options.threads));
  }
  const std::optional<dsp::MatchParams> of_the_appliance = lab::appliance_params(match);
  dsp::DepthParams params{.match = of_the_appliance.value_or(match),
                          .fusion = {},
                          .guided = options.guided,
                          .temporal = options.temporal};
  params.match.search = lab::sums_paths(match) ? dsp::Search::kSemiGlobal : dsp::Search::kBlocks;
  params.fusion.max_range = options.max_range;
  params.fusion.trust = dsp::trust_of(params.match);
  const dsp::ThreadTeam team(made->workers_, options.threads);
  const auto searches = [&]() -> dsp::SearchMaker* {
    return of_the_appliance ? nullptr
                            : &made->searches_.emplace(made->match_, made->continued_.view());
  };
  made->space_.emplace(dsp::bytes_taken([&](dsp::Arena& arena) {
    dsp::DepthMaker(made->calibration_, params, arena, team, searches());
  }));
  dsp::Arena arena = made->space_->arena();
  made->maker_.emplace(made->calibration_, params, arena, team, searches());
  return made;
}

}  // namespace stof::host
