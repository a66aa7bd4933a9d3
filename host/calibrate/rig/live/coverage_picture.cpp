#include "host/calibrate/rig/live/coverage_picture.h"

#include <algorithm>
#include <array>
#include <string>

#include <opencv2/imgproc.hpp>

#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr int kEyeWidth = 320;
constexpr int kGap = 12;
constexpr int kTitle = 22;
constexpr int kLine = 22;

// Blue, green, red: as OpenCV draws them; put into Rgb at the end.
const cv::Scalar kPaper(255, 255, 255);
const cv::Scalar kInk(40, 40, 40);
const cv::Scalar kPanel(236, 232, 230);
const cv::Scalar kCorner(178, 114, 0);
const cv::Scalar kNewest(0, 94, 213);
const cv::Scalar kReached(210, 232, 205);
const cv::Scalar kMissing(200, 205, 245);
const cv::Scalar kDone(115, 158, 0);

void write(cv::Mat& canvas, const std::string& text, int x, int y) {
  cv::putText(canvas, text, cv::Point(x, y), cv::FONT_HERSHEY_SIMPLEX, 0.45, kInk, 1, cv::LINE_AA);
}

// One eye, its upper left corner at x, y.
void draw_eye(cv::Mat& canvas, const cv::Rect& at, double scale, unsigned reached,
              const std::vector<PairView>& views, std::vector<PixelPoint> PairView::* eye) {
  cv::rectangle(canvas, at, kPanel, cv::FILLED);
  const int w = static_cast<int>(kCornerShare * at.width);
  const int h = static_cast<int>(kCornerShare * at.height);
  for (unsigned i = 0; i < 4; ++i) {  // upper left, upper right, lower left, lower right
    const cv::Rect zone(i % 2 == 0 ? at.x : at.x + at.width - w,
                        i < 2 ? at.y : at.y + at.height - h, w, h);
    cv::rectangle(canvas, zone, ((reached >> i) & 1U) != 0 ? kReached : kMissing, cv::FILLED);
  }
  for (const PairView& view : views) {
    const bool newest = &view == &views.back();
    for (const PixelPoint& p : view.*eye) {
      if (p.seen()) {
        const cv::Point2d place((p.u + 0.5) * scale + at.x, (p.v + 0.5) * scale + at.y);
        cv::circle(canvas, cv::Point(place), newest ? 2 : 1, newest ? kNewest : kCorner,
                   cv::FILLED);
      }
    }
  }
  cv::rectangle(canvas, at, kInk);
}

void draw_want(cv::Mat& canvas, const ViewWant& want, int x, int y, int width) {
  constexpr int kText = 110;
  constexpr int kNumbers = 70;
  write(canvas, want.name == "more" ? "views" : want.name, x, y + 14);
  const cv::Rect bar(x + kText, y + 4, width - kText - kNumbers, 12);
  cv::rectangle(canvas, bar, kMissing, cv::FILLED);
  const double share =
      std::min(1.0, static_cast<double>(want.have) / static_cast<double>(want.need));
  cv::rectangle(canvas, cv::Rect(bar.x, bar.y, static_cast<int>(share * bar.width), bar.height),
                kDone, cv::FILLED);
  write(canvas, printed("%zu of %zu", want.have, want.need), bar.x + bar.width + 6, y + 14);
}

}  // namespace

dataset::Image<Rgb> coverage_picture(const std::vector<PairView>& views,
                                     const std::vector<ViewWant>& wants, int width, int height) {
  const double scale = static_cast<double>(kEyeWidth) / width;
  const int eye_height = std::max(1, static_cast<int>(scale * height));
  std::vector<const ViewWant*> bars;
  for (const ViewWant& want : wants) {
    if (!want.name.starts_with("corner")) {
      bars.push_back(&want);
    }
  }
  const int lines = (static_cast<int>(bars.size()) + 1) / 2;
  cv::Mat canvas(kTitle + eye_height + lines * kLine + 2 * kGap, 2 * kEyeWidth + 3 * kGap, CV_8UC3,
                 kPaper);
  const unsigned reached = reached_corners(views, width, height);
  int x = kGap;
  for (const auto& [name, eye, shift] :
       {std::tuple("left", &PairView::left, 0U), std::tuple("right", &PairView::right, 4U)}) {
    write(canvas, printed("%s, %zu views", name, views.size()), x, kTitle - 7);
    draw_eye(canvas, cv::Rect(x, kTitle, kEyeWidth, eye_height), scale, reached >> shift, views,
             eye);
    x += kEyeWidth + kGap;
  }
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const int column = static_cast<int>(i % 2);
    draw_want(canvas, *bars[i], kGap + column * (kEyeWidth + kGap),
              kTitle + eye_height + kGap + static_cast<int>(i / 2) * kLine, kEyeWidth);
  }
  dataset::Image<Rgb> picture(canvas.cols, canvas.rows);
  for (int y = 0; y < canvas.rows; ++y) {
    for (int u = 0; u < canvas.cols; ++u) {
      const auto& bgr = canvas.at<cv::Vec3b>(y, u);
      picture.view().at(u, y) = {.red = bgr[2], .green = bgr[1], .blue = bgr[0]};
    }
  }
  return picture;
}

}  // namespace stof::host
