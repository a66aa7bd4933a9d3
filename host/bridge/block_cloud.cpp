#include "host/bridge/block_cloud.h"

#include <algorithm>
#include <optional>

namespace stof::bridge {
namespace {

constexpr double kPixelScale = 65536;
constexpr double kMicrometres = 1e-6;

struct Nearest {
  int x = 0;
  int y = 0;
  int twice_near = 0;  // 2 * depth - width
};

bool has_width(const client::Frame& frame, int x, int y) {
  return !frame.interval_width.empty() && !frame.received.empty() &&
         (frame.received.at(x, y) & client::kHasWidth) != 0;
}

std::optional<Nearest> nearest_of_block(const client::Frame& frame, int left, int top, int step) {
  std::optional<Nearest> nearest;
  const int right = std::min(left + step, frame.depth.width());
  const int bottom = std::min(top + step, frame.depth.height());
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const int depth = frame.depth.at(x, y);
      if (depth == dsp::kNoDepth) {
        continue;
      }
      const int near = 2 * depth - (has_width(frame, x, y) ? frame.interval_width.at(x, y) : 0);
      if (!nearest || near < nearest->twice_near) {
        nearest = {.x = x, .y = y, .twice_near = near};
      }
    }
  }
  return nearest;
}

}  // namespace

Status block_cloud(const client::Frame& frame, int step, std::vector<client::Point>& points) {
  points.clear();
  if (!frame.calibration) {
    return Status::kUnsupported;
  }
  const wire::CalibrationPacket& lens = *frame.calibration;
  if (frame.depth.width() != lens.image_width || frame.depth.height() != lens.image_height) {
    return Status::kInvalidArgument;
  }
  const double unit = lens.depth_unit_um * kMicrometres;
  const double cx = lens.cx / kPixelScale;
  const double cy = lens.cy / kPixelScale;
  const double fx = lens.fx / kPixelScale;
  const double fy = lens.fy / kPixelScale;
  for (int top = 0; top < frame.depth.height(); top += step) {
    for (int left = 0; left < frame.depth.width(); left += step) {
      const std::optional<Nearest> pixel = nearest_of_block(frame, left, top, step);
      if (!pixel) {
        continue;
      }
      const double z = frame.depth.at(pixel->x, pixel->y) * unit;
      const float width =
          has_width(frame, pixel->x, pixel->y)
              ? static_cast<float>(frame.interval_width.at(pixel->x, pixel->y) * unit)
              : client::kUnknownWidth;
      points.push_back({.x = static_cast<float>((pixel->x - cx) / fx * z),
                        .y = static_cast<float>((pixel->y - cy) / fy * z),
                        .z = static_cast<float>(z),
                        .z_width = width});
    }
  }
  return Status::kOk;
}

}  // namespace stof::bridge
