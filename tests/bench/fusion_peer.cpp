#include "tests/bench/fusion_peer.h"

#include <cstdio>
#include <vector>

#include <opencv2/calib3d.hpp>

#include "dsp/depth/depth_maker.h"
#include "hal/emu/rendered.h"
#include "hal/emu/rig.h"
#include "hal/emu/scene.h"
#include "host/evaluate/match.h"
#include "host/evaluate/median.h"
#include "host/evaluate/workspace.h"

namespace stof::host {
namespace {

constexpr int kRuns = 31;

struct Pictures {
  explicit Pictures(hal::emu::RenderedScene& scene)
      : left(scene.stereo_size().width, scene.stereo_size().height),
        right(left),
        depth(left.width, left.height),
        width(depth),
        source(left.width, left.height),
        cause(left.width, left.height) {
    scene.left(1, left.view());
    scene.right(1, right.view());
    for (int k = 0; k < 4; ++k) {
      samples.emplace_back(scene.pmd_size().width, scene.pmd_size().height);
      scene.pmd(1, k, samples.back().view());
    }
  }
  dsp::DepthMap map() { return {depth.view(), width.view(), source.view(), cause.view()}; }

  dataset::Image<std::uint8_t> left, right;
  std::vector<dataset::Image<std::uint16_t>> samples;
  dataset::Image<dsp::QuarterMm> depth, width;
  dataset::Image<dsp::Source> source;
  dataset::Image<dsp::Cause> cause;
};

double time_ms(const std::function<void()>& work) { return median_time_ms(1, work); }

}  // namespace

void compare_fusion() {
  const hal::emu::Rig rig = hal::emu::corridor_rig();
  hal::emu::RenderedScene scene(hal::emu::corridor(), rig);
  const dsp::Calibration& calibration = scene.calibration();
  Pictures p(scene);
  dsp::DepthParams params{.match = dsp::for_depth(*dsp::find_preset("fast")), .fusion = {}};
  params.match.disparities = 64;
  params.fusion.spread = dsp::spread_of(params.match);
  Workspace workspace(dsp::DepthMaker::bytes_needed(calibration, params));
  dsp::Arena arena = workspace.arena();
  dsp::DepthMaker maker(calibration, params, arena);
  const dsp::PmdExposure exposure{.samples = {p.samples[0].view(), p.samples[1].view(),
                                              p.samples[2].view(), p.samples[3].view()}};
  const cv::Mat left(p.left.height, p.left.width, CV_8U, p.left.pixels.data());
  const cv::Mat right(p.right.height, p.right.width, CV_8U, p.right.pixels.data());
  const cv::Ptr<cv::StereoBM> peer = cv::StereoBM::create(64, 15);
  peer->setPreFilterCap(31);
  peer->setTextureThreshold(0);
  peer->setUniquenessRatio(0);
  cv::Mat theirs;
  std::vector<double> convert;
  std::vector<double> fuse;
  std::vector<double> bm;
  for (int run = 0; run < kRuns; ++run) {
    convert.push_back(time_ms([&] { maker.convert({.first = {&exposure, 1}}); }));
    maker.match(p.left.view(), p.right.view());
    fuse.push_back(time_ms([&] { maker.fuse(p.map()); }));
    bm.push_back(time_ms([&] { peer->compute(left, right, theirs); }));
  }
  const double ours = median(convert).value_or(0) + median(fuse).value_or(0);
  std::printf(
      "%-12s %4dx%-4d %dx%d PMD: convert %.2f + fuse %.2f ms   StereoBM dense %.2f ms   %.2f of "
      "it\n",
      "corridor", p.left.width, p.left.height, rig.pmd_lens.width, rig.pmd_lens.height,
      median(convert).value_or(0), median(fuse).value_or(0), median(bm).value_or(0),
      ours / median(bm).value_or(1));
}

}  // namespace stof::host
