// stof_bench SCENE_DIR...: presets and OpenCV's StereoSGBM 3WAY in turn in one process, on one
// thread; medians, and how many times as fast each preset is. SGBM searches as many candidates with
// 3x3 blocks and no filters, the settings that are fastest.

#include <cstdio>
#include <vector>

#include <opencv2/calib3d.hpp>

#include "dsp/stereo/match_params.h"
#include "dsp/stereo/matcher.h"
#include "host/evaluate/match.h"
#include "host/evaluate/median.h"
#include "tests/bench/fusion_peer.h"

namespace stof::host {
namespace {

constexpr int kRuns = 31;

void compare(const dataset::StereoScene& scene, const char* name) {
  dsp::MatchParams params = dsp::find_preset(name)->params;
  params.disparities = (scene.ndisp + 15) / 16 * 16;  // what SGBM takes
  const int width = scene.left.width;
  const int height = scene.left.height;
  Workspace workspace(dsp::Matcher::bytes_needed(params, width, height));
  dsp::Arena arena = workspace.arena();
  dsp::Matcher matcher(params, width, height, arena);
  dataset::Image<dsp::Disparity> ours(width, height);

  std::vector<std::uint8_t> left = scene.left.pixels;
  std::vector<std::uint8_t> right = scene.right.pixels;
  const cv::Mat left_view(height, width, CV_8U, left.data());
  const cv::Mat right_view(height, width, CV_8U, right.data());
  cv::Mat theirs;
  const cv::Ptr<cv::StereoSGBM> peer = cv::StereoSGBM::create(
      0, params.disparities, 3, 8 * 9, 32 * 9, 1, 0, 0, 0, 0, cv::StereoSGBM::MODE_SGBM_3WAY);
  std::vector<double> our_ms;
  std::vector<double> their_ms;
  for (int run = 0; run < kRuns; ++run) {
    our_ms.push_back(median_time_ms(
        1, [&] { matcher.match(scene.left.view(), scene.right.view(), ours.view()); }));
    their_ms.push_back(median_time_ms(1, [&] { peer->compute(left_view, right_view, theirs); }));
  }
  const double our_median = median(our_ms).value_or(0);
  const double their_median = median(their_ms).value_or(0);
  std::printf("%-12s %4dx%-4d %4d  %-8s %7.2f ms   StereoSGBM 3WAY %7.2f ms   %.2f times as fast\n",
              scene.name.c_str(), width, height, params.disparities, name, our_median, their_median,
              their_median / our_median);
}

}  // namespace
}  // namespace stof::host

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "stof_bench: no scene: name folders with left.pgm, right.pgm, meta.txt\n");
    return 2;
  }
  cv::setNumThreads(1);
  for (int i = 1; i < argc; ++i) {
    const auto scene = stof::dataset::read_stereo_scene(argv[i]);
    if (!scene) {
      std::fprintf(stderr, "stof_bench: %s\n", scene.error().message.c_str());
      return 2;
    }
    for (const char* const preset : {"quality", "fast"}) {
      stof::host::compare(*scene, preset);
    }
  }
  stof::host::compare_fusion();
  return 0;
}
