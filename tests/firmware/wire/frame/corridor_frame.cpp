#include "tests/firmware/wire/frame/corridor_frame.h"

#include <algorithm>

#include "dsp/depth/depth_maker.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"
#include "tests/support/guarded_part.h"

namespace stof::test {
namespace {

constexpr int kDisparities = 64;

}  // namespace

CorridorFrame::CorridorFrame(std::string_view preset) {
  const hal::emu::Rig rig = hal::emu::corridor_rig();
  hal::emu::RenderedScene scene(hal::emu::corridor(), rig);
  const int width = scene.stereo_size().width;
  const int height = scene.stereo_size().height;
  left_ = {width, height};
  right_ = {width, height};
  depth_ = {width, height};
  width_ = {width, height};
  source_ = {width, height};
  cause_ = {width, height};
  disparity_ = {width, height};
  scene.left(1, left_.view());
  scene.right(1, right_.view());
  for (int k = 0; k < 4; ++k) {
    scene.pmd(1, k, samples_.emplace_back(rig.pmd_lens.width, rig.pmd_lens.height).view());
  }
  dsp::DepthParams params{.match = dsp::for_depth(*dsp::find_preset(preset)), .fusion = {}};
  params.match.disparities = kDisparities;
  params.fusion.trust = dsp::trust_of(params.match);
  GuardedPart<dsp::DepthMaker> maker(
      [&](dsp::Arena& arena) { return dsp::DepthMaker(scene.calibration(), params, arena); });
  const dsp::PmdExposure exposure{
      .samples = {samples_[0].view(), samples_[1].view(), samples_[2].view(), samples_[3].view()}};
  maker->convert({.first = {&exposure, 1}});
  maker->match(left_.view(), right_.view());
  maker->fuse({depth_.view(), width_.view(), source_.view(), cause_.view()});
  for (int y = 0; y < height; ++y) {
    std::ranges::copy(maker->stereo().disparity.row(y), disparity_.view().row(y).begin());
  }
}

wire::FrameImages CorridorFrame::images() noexcept {
  return {.map = {depth_.view(), width_.view(), source_.view(), cause_.view()},
          .disparity = disparity_.view(),
          .pmd = {samples_[0].view(), samples_[1].view(), samples_[2].view(), samples_[3].view()},
          .left = left_.view(),
          .right = right_.view()};
}

wire::FrameSizes CorridorFrame::sizes() const noexcept {
  return {.width = left_.width,
          .height = left_.height,
          .pmd_width = samples_.front().width,
          .pmd_height = samples_.front().height};
}

}  // namespace stof::test
