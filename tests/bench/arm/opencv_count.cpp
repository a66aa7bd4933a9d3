// opencv_count: StereoBM on the pictures of stof_count, as dense as task `wta`, between the same
// marks. Read with Debian's headers, linked with its arm64 libraries; not part of any build.

#include <cstdio>

#include <opencv2/calib3d.hpp>

#include "tests/bench/arm/marks.h"
#include "tests/bench/bench_work.h"

int main() {
  stof::bench::Pictures pictures = stof::bench::made_pictures(640, 480);
  cv::setNumThreads(1);
  const cv::Mat left(480, 640, CV_8U, pictures.left.pixels.data());
  const cv::Mat right(480, 640, CV_8U, pictures.right.pixels.data());
  const cv::Ptr<cv::StereoBM> peer = cv::StereoBM::create(64, 15);
  peer->setPreFilterCap(31);
  peer->setTextureThreshold(0);
  peer->setUniquenessRatio(0);
  cv::Mat out;
  peer->compute(left, right, out);
  stof::bench::count_begin();
  peer->compute(left, right, out);
  stof::bench::count_end();
  std::puts("stereo_bm");
  return out.rows == 480 ? 0 : 1;
}
