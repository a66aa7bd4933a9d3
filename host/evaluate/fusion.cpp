#include "host/evaluate/fusion.h"

#include "dsp/fusion/fuser.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/matcher.h"

namespace stof::host {
namespace {

struct DepthImages {
  dataset::Image<dsp::QuarterMm> depth;
  dataset::Image<dsp::QuarterMm> width;
  dataset::Image<dsp::Source> source;
  dataset::Image<dsp::Cause> cause;

  DepthImages(int w, int h) : depth(w, h), width(w, h), source(w, h), cause(w, h) {}
  dsp::DepthMap map() { return {depth.view(), width.view(), source.view(), cause.view()}; }
};

}  // namespace

dataset::Loaded<FusionResult> fuse_scene(const dataset::StereoScene& scene,
                                         const dataset::PmdRecording& recording,
                                         const dsp::MatchParams& match, int runs) {
  const int width = scene.left.width;
  const int height = scene.left.height;
  dsp::Calibration calibration = recording.calibration;
  calibration.stereo.left.width = width;
  calibration.stereo.left.height = height;
  if (const std::string wrong = dsp::problem(calibration); !wrong.empty()) {
    return std::unexpected(
        dataset::Problem{scene.name + ": " + wrong + ": correct the recording's json"});
  }
  dsp::MatchParams params = match;
  params.confidence = true;
  Workspace matcher_space(dsp::Matcher::bytes_needed(params, width, height));
  dsp::Arena matcher_arena = matcher_space.arena();
  dsp::Matcher matcher(params, width, height, matcher_arena);
  dataset::Image<dsp::Disparity> disparity(width, height);
  const dsp::Pinhole& lens = calibration.pmd.lens;
  Workspace converter_space(dsp::Converter::bytes_needed(lens.width, lens.height));
  dsp::Arena converter_arena = converter_space.arena();
  dsp::Converter converter(calibration.pmd, converter_arena);
  Workspace fuser_space(
      dsp::Fuser::bytes_needed(width, height, params.disparities, lens.width, lens.height));
  dsp::Arena fuser_arena = fuser_space.arena();
  dsp::FusionParams fusion;
  fusion.spread = match.method == dsp::Method::kSemiGlobal ? dsp::kPathSpread : dsp::kBlockSpread;
  dsp::Fuser fuser(calibration, fusion, params.min_disparity, params.disparities, width, height,
                   fuser_arena);

  FusionResult result;
  result.match_ms = median_time_ms(
      runs, [&] { matcher.match(scene.left.view(), scene.right.view(), disparity.view()); });
  const dsp::StereoMaps stereo{disparity.view(), matcher.ratio(), matcher.weak()};
  const dsp::PmdMaps* pmd = nullptr;
  result.convert_ms = median_time_ms(runs, [&] { pmd = &converter.convert(recording.samples(0)); });
  DepthImages images(width, height);
  fuser.fuse({}, pmd, images.map());
  result.pmd = to_metres(images.depth.view(), images.width.view());
  fuser.fuse(stereo, nullptr, images.map());
  result.stereo = to_metres(images.depth.view(), images.width.view());
  result.fuse_ms = median_time_ms(runs, [&] { fuser.fuse(stereo, pmd, images.map()); });
  result.fused = to_metres(images.depth.view(), images.width.view());
  return result;
}

}  // namespace stof::host
