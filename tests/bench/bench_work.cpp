#include "tests/bench/bench_work.h"

#include <utility>

#include "dsp/pmd/phase/phase.h"
#include "dsp/stereo/rectify/rectifier.h"
#include "host/evaluate/workspace.h"
#include "lab/matcher.h"
#include "posix/worker_threads.h"
#include "tests/dsp/stereo/raw_pair_scene.h"

namespace stof::bench {
namespace {

struct MatchState {
  MatchState(const Pictures& both, const lab::MatchParams& params, int threads)
      : pictures(both),
        workers({.threads = threads}),
        workspace(dsp::bytes_taken([&](dsp::Arena& measure) {
          lab::Matcher(params, both.left.width, both.left.height, measure,
                       dsp::ThreadTeam::standing_for(workers.threads()));
        })),
        arena(workspace.arena()),
        matcher(params, both.left.width, both.left.height, arena,
                dsp::ThreadTeam(workers, workers.threads())),
        out(both.left.width, both.left.height) {}

  Pictures pictures;
  posix::WorkerThreads workers;
  host::Workspace workspace;
  dsp::Arena arena;
  lab::Matcher matcher;
  dataset::Image<dsp::Disparity> out;
};

struct RectifyState {
  explicit RectifyState(const Pictures& both)
      : pictures(both),
        rig(raw_rig(both.left.width, both.left.height)),
        workspace(
            dsp::bytes_taken([&](dsp::Arena& measure) noexcept { dsp::Rectifier(rig, measure); })),
        arena(workspace.arena()),
        rectifier(rig, arena) {}

  Pictures pictures;
  dsp::StereoRig rig;
  host::Workspace workspace;
  dsp::Arena arena;
  dsp::Rectifier rectifier;
};

struct PhaseState {
  explicit PhaseState(Samples four)
      : samples(std::move(four)),
        phase(samples.images[0].width, samples.images[0].height),
        amp2(phase.width, phase.height),
        offset(phase.width, phase.height),
        flags(phase.width, phase.height) {}

  void run() {
    for (int y = 0; y < phase.height; ++y) {
      const auto row = [&](std::size_t k) {
        return std::as_const(samples.images[k]).view().row(y);
      };
      dsp::best::phase(
          {row(0), row(1), row(2), row(3)}, {},
          {phase.view().row(y), amp2.view().row(y), offset.view().row(y), flags.view().row(y)});
    }
  }

  Samples samples;
  dataset::Image<dsp::Phase> phase;
  dataset::Image<std::uint16_t> amp2;
  dataset::Image<std::uint16_t> offset;
  dataset::Image<std::uint8_t> flags;
};

}  // namespace

dsp::MatchParams block_params(int disparities) {
  return {.disparities = disparities,
          .block_width = 15,
          .block_height = 15,
          .subpixel = dsp::Subpixel::kParabola};
}

dsp::MatchParams preset_params(const char* preset, int disparities) {
  dsp::MatchParams params = dsp::find_preset(preset)->params;
  params.disparities = disparities;
  return params;
}

dsp::MatchParams appliance_params(const char* preset, int disparities) {
  dsp::MatchParams params = dsp::for_depth(*dsp::find_preset(preset));
  params.disparities = disparities;
  return params;
}

lab::MatchParams pyramid_params(int levels, int disparities) {
  lab::MatchParams params = lab::as_the_appliance(block_params(disparities));
  params.subpixel = dsp::Subpixel::kWhole;
  if (levels > 0) {
    params.pyramid_levels = levels;
  }
  return params;
}

Work match_work(const Pictures& pictures, const dsp::MatchParams& params, int threads) {
  return match_work(pictures, lab::as_the_appliance(params), threads);
}

Work match_work(const Pictures& pictures, const lab::MatchParams& params, int threads) {
  const auto state = std::make_shared<MatchState>(pictures, params, threads);
  return [state] {
    state->matcher.match({.left = std::as_const(state->pictures.left).view(),
                          .right = std::as_const(state->pictures.right).view()},
                         state->out.view());
  };
}

Samples::Samples(int width, int height) {
  std::uint32_t state = 1;
  for (int k = 0; k < 4; ++k) {
    dataset::Image<std::uint16_t>& image = images.emplace_back(width, height);
    for (std::uint16_t& value : image.pixels) {
      state = state * 1664525U + 1013904223U;
      value = static_cast<std::uint16_t>(200U + (state >> 20U) * 7U / 8U);
    }
  }
}

Work phase_work(const Samples& samples) {
  const auto state = std::make_shared<PhaseState>(samples);
  return [state] { state->run(); };
}

dsp::StereoRig raw_rig(int width, int height) {
  dsp::StereoRig rig;
  rig.raw = dsp::raw::raw_pair(width, height);
  const char* const wrong = dsp::complete(rig);
  STOF_CHECK(*wrong == '\0');
  return rig;
}

Work rectify_work(const Pictures& pictures) {
  const auto state = std::make_shared<RectifyState>(pictures);
  return [state] {
    state->rectifier.rectify(std::as_const(state->pictures.left).view(),
                             std::as_const(state->pictures.right).view(),
                             state->rectifier.left().rows());
  };
}

}  // namespace stof::bench
