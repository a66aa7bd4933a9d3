#include "tests/bench/bench_opencv.h"

#include <algorithm>
#include <array>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "dsp/calib/stereo/rectification.h"

namespace stof::bench {
namespace {

cv::Mat grey(const dataset::Image<std::uint8_t>& image) {
  cv::Mat mat(image.height, image.width, CV_8U);
  std::ranges::copy(image.pixels, mat.begin<std::uint8_t>());
  return mat;
}

struct StereoState {
  StereoState(const Pictures& pictures, cv::Ptr<cv::StereoMatcher> peer)
      : left(grey(pictures.left)), right(grey(pictures.right)), matcher(std::move(peer)) {}
  cv::Mat left;
  cv::Mat right;
  cv::Mat out;
  cv::Ptr<cv::StereoMatcher> matcher;
};

Work stereo_work(const Pictures& pictures, const cv::Ptr<cv::StereoMatcher>& matcher) {
  const auto state = std::make_shared<StereoState>(pictures, matcher);
  return [state] { state->matcher->compute(state->left, state->right, state->out); };
}

struct PolarState {
  std::array<cv::Mat, 4> samples;
  cv::Mat i, q, magnitude, angle;
};

struct Remapped {
  cv::Mat raw;
  cv::Mat places;     // fixed point
  cv::Mat fractions;  // index in remap()'s table
  cv::Mat out;
};

Remapped remapped(const dataset::Image<std::uint8_t>& image, const dsp::SourceMap& map) {
  cv::Mat x(image.height, image.width, CV_32F);
  cv::Mat y(image.height, image.width, CV_32F);
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const dsp::SourceMap::Place place = map.at(column, row);
      x.at<float>(row, column) = static_cast<float>(place.u);
      y.at<float>(row, column) = static_cast<float>(place.v);
    }
  }
  Remapped state{.raw = grey(image), .places = {}, .fractions = {}, .out = {}};
  cv::convertMaps(x, y, state.places, state.fractions, CV_16SC2);
  return state;
}

}  // namespace

void set_opencv_threads(int threads) { cv::setNumThreads(threads); }

std::string opencv_version() { return "OpenCV " + cv::getVersionString(); }

Work stereo_bm_work(const Pictures& pictures, int disparities, bool dense) {
  const cv::Ptr<cv::StereoBM> peer = cv::StereoBM::create(disparities, 15);
  if (dense) {
    peer->setPreFilterCap(31);
    peer->setTextureThreshold(0);
    peer->setUniquenessRatio(0);
  }
  return stereo_work(pictures, peer);
}

Work stereo_sgbm_work(const Pictures& pictures, int disparities, bool three_way) {
  return stereo_work(pictures,
                     cv::StereoSGBM::create(
                         0, disparities, 3, 8 * 9, 32 * 9, 1, 0, 0, 0, 0,
                         three_way ? cv::StereoSGBM::MODE_SGBM_3WAY : cv::StereoSGBM::MODE_SGBM));
}

Work polar_work(const Samples& samples) {
  const auto state = std::make_shared<PolarState>();
  for (std::size_t k = 0; k < state->samples.size(); ++k) {
    const dataset::Image<std::uint16_t>& image = samples.images[k];
    state->samples[k].create(image.height, image.width, CV_16U);
    std::ranges::copy(image.pixels, state->samples[k].begin<std::uint16_t>());
  }
  return [state] {
    PolarState& s = *state;
    cv::subtract(s.samples[0], s.samples[2], s.i, cv::noArray(), CV_32F);
    cv::subtract(s.samples[3], s.samples[1], s.q, cv::noArray(), CV_32F);
    cv::cartToPolar(s.i, s.q, s.magnitude, s.angle);
  };
}

Work remap_work(const Pictures& pictures) {
  const dsp::StereoRig rig = raw_rig(pictures.left.width, pictures.left.height);
  const dsp::Rectification turns = dsp::rectify(*rig.raw);
  using Both = std::array<Remapped, 2>;
  const auto state = std::make_shared<Both>(
      Both{remapped(pictures.left, {rig.raw->left, turns.left_turn, turns.left}),
           remapped(pictures.right, {rig.raw->right, turns.right_turn, turns.right})});
  return [state] {
    for (Remapped& one : *state) {
      cv::remap(one.raw, one.out, one.places, one.fractions, cv::INTER_LINEAR,
                cv::BORDER_REPLICATE);
    }
  };
}

}  // namespace stof::bench
