#include "host/cli/kept_frame.h"

#include <algorithm>

#include "host/cli/evaluate.h"
#include "host/cli/exit.h"
#include "host/client/point_cloud.h"
#include "host/picture/depth_picture.h"
#include "host/picture/ply.h"

namespace stof::host {
namespace {

template <typename T>
void copy(dsp::ImageView<const T> from, dataset::Image<T>& to) {
  if (to.width != from.width() || to.height != from.height()) {
    to = dataset::Image<T>(from.width(), from.height());
  }
  for (int y = 0; y < to.height; ++y) {
    std::ranges::copy(from.row(y), to.view().row(y).begin());
  }
}

}  // namespace

void KeptFrame::keep(const client::Frame& frame) {
  frame_ = frame;
  copy(frame.depth, depth_);
  copy(frame.width, width_);
  copy(frame.source, source_);
  copy(frame.received, received_);
}

client::Frame KeptFrame::frame() const {
  client::Frame frame = frame_;
  frame.depth = depth_.view();
  frame.width = width_.view();
  frame.source = source_.view();
  frame.received = received_.view();
  return frame;
}

DepthPlanes KeptFrame::planes() const { return to_metres(depth_.view(), width_.view()); }

std::string KeptFrame::write(const std::filesystem::path& folder, const ColourScale& scale) const {
  make_folder(folder);
  value_or_fail(write_png(
      folder / "depth.png", depth_,
      {{"Title", "Depth map"},
       {"Description",
        "16-bit grey: Z in the rectified left camera, unit 0.25 mm (value / 4000 = "
        "metres), 0 = none"},
       {"Source",
        "made from received packets only, frame " + std::to_string(frame_.stamp.number)}}));
  value_or_fail(write_png(folder / "depth_color.png", depth_picture(depth_, scale),
                          {{"Title", "Depth map in colours, near is warm"}}));
  const std::string pictures =
      (folder / "depth.png").string() + ", " + (folder / "depth_color.png").string();
  const std::string what =
      " of frame " + std::to_string(frame_.stamp.number) + ", made from received packets only";
  std::vector<client::Point> points;
  if (client::point_cloud(frame(), points) != Status::kOk) {
    return "wrote " + pictures + what +
           "; no cloud: no calibration packet of this frame's size arrived";
  }
  value_or_fail(write_ply(folder / "cloud.ply", points));
  return "wrote " + pictures + " and " + (folder / "cloud.ply").string() + what;
}

}  // namespace stof::host
