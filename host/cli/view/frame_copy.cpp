#include "host/cli/view/frame_copy.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>
#include <utility>

#include "host/cli/evaluate/evaluate.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/cli/view/ply.h"
#include "host/client/frame/point_cloud.h"
#include "host/picture/depth_picture.h"
#include "host/picture/disparity_picture.h"
#include "host/picture/legend.h"
#include "host/picture/source_colours.h"
#include "host/text/printed.h"

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

// The views of what was not received are empty ones.
template <typename T>
dsp::ImageView<const T> view(const dataset::Image<T>& image) {
  return image.pixels.empty() ? dsp::ImageView<const T>{} : image.view();
}

// With a legend. A newer sensor's sources are white.
dataset::Image<Rgb> source_picture(const dataset::Image<dsp::Source>& source) {
  constexpr Rgb kNewer{255, 255, 255};
  dataset::Image<Rgb> picture(source.width, source.height);
  std::ranges::transform(source.pixels, picture.pixels.begin(), [&](dsp::Source one) {
    const auto index = static_cast<std::size_t>(one);
    return index < kSourceColours.size() ? kSourceColours[index] : kNewer;
  });
  std::array<std::pair<Rgb, std::string_view>, kSourceColours.size()> legend;
  for (std::size_t i = 0; i < legend.size(); ++i) {
    legend[i] = {kSourceColours[i], kSourceWords[i]};
  }
  return with_swatches(picture, legend);
}

dataset::Image<float> in_pixels(const dataset::Image<dsp::Disparity>& disparity) {
  dataset::Image<float> result(disparity.width, disparity.height);
  std::ranges::transform(disparity.pixels, result.pixels.begin(), [](dsp::Disparity one) {
    return one.valid() ? one.pixels() : std::numeric_limits<float>::infinity();
  });
  return result;
}

// Of what was sent beside the depth: the names of the pictures written.
std::string write_others(const std::filesystem::path& folder,
                         const dataset::Image<dsp::Source>& source,
                         const dataset::Image<dsp::Disparity>& disparity,
                         const dataset::Image<std::uint8_t>& left,
                         const dataset::Image<std::uint8_t>& right) {
  std::string names;
  const auto write = [&](const char* name, const dataset::Image<Rgb>& picture,
                         const PngTexts& texts) {
    value_or_end(write_png(folder / name, picture, texts));
    names += ", " + (folder / name).string();
  };
  if (!source.pixels.empty()) {
    write("source.png", source_picture(source),
          {{"Title", "Sources of the depth"}, {"Description", kSourceColoursInWords}});
  }
  if (!disparity.pixels.empty()) {
    write("disparity.png", disparity_picture(in_pixels(disparity), {}),
          {{"Title", "Disparity, 0 to 64 px"}});
  }
  if (!left.pixels.empty()) {
    write("left.png", as_colour(left, false), {{"Title", "Left picture"}});
  }
  if (!right.pixels.empty()) {
    write("right.png", as_colour(right, false), {{"Title", "Right picture"}});
  }
  return names.empty() ? names : names.substr(2);
}

// Their names end with `end`.
void write_depth_pictures(const std::filesystem::path& folder, const std::string& end,
                          const dataset::Image<dsp::QuarterMm>& depth, std::uint32_t number,
                          const ColourScale& scale) {
  value_or_end(
      write_png(folder / ("depth" + end + ".png"), depth,
                {{"Title", "Depth map"},
                 {"Description",
                  "16-bit grey: Z in the rectified left camera, unit 0.25 mm (value / 4000 = "
                  "metres), 0 = none"},
                 {"Source", "made from received packets only, frame " + std::to_string(number)}}));
  value_or_end(write_png(folder / ("depth_color" + end + ".png"), depth_picture(depth, scale),
                         {{"Title", "Depth map in colours, near is warm"}}));
}

}  // namespace

void FrameCopy::keep(const client::Frame& frame) {
  copy(frame.depth, depth_);
  copy(frame.interval_width, width_);
  copy(frame.source, source_);
  copy(frame.received, received_);
  copy(frame.disparity, disparity_);
  copy(frame.left, left_);
  copy(frame.right, right_);
  frame_ = {.origin = frame.origin,
            .stamp = frame.stamp,
            .missing = frame.missing,
            .packets = frame.packets,
            .missing_packets = frame.missing_packets,
            .recovered_packets = frame.recovered_packets,
            .info = frame.info,
            .calibration = frame.calibration,
            .first_packet = frame.first_packet,
            .last_packet = frame.last_packet};
}

client::Frame FrameCopy::frame() const {
  client::Frame frame = frame_;
  frame.depth = view(depth_);
  frame.interval_width = view(width_);
  frame.source = view(source_);
  frame.received = view(received_);
  frame.disparity = view(disparity_);
  frame.left = view(left_);
  frame.right = view(right_);
  return frame;
}

DepthPlanes FrameCopy::planes() const {
  if (width_.pixels.empty()) {
    const dataset::Image<dsp::QuarterMm> exact(depth_.width, depth_.height);
    return to_metres(depth_.view(), exact.view());
  }
  return to_metres(depth_.view(), width_.view());
}

void FrameCopy::write_depth(const std::filesystem::path& folder, const ColourScale& scale) const {
  make_folder(folder);
  write_depth_pictures(folder, printed("_%010u", frame_.stamp.number), depth_, frame_.stamp.number,
                       scale);
}

std::string FrameCopy::write(const std::filesystem::path& folder, const ColourScale& scale) const {
  make_folder(folder);
  const std::string what =
      " of frame " + std::to_string(frame_.stamp.number) + ", made from received packets only";
  const std::string others = write_others(folder, source_, disparity_, left_, right_);
  const std::string after = others.empty() ? "" : ", " + others;
  if (!has_depth()) {
    return (others.empty() ? "wrote nothing" : "wrote " + others) + what + "; no depth arrived";
  }
  write_depth_pictures(folder, "", depth_, frame_.stamp.number, scale);
  const std::string pictures =
      (folder / "depth.png").string() + ", " + (folder / "depth_color.png").string();
  std::vector<client::Point> points;
  if (client::point_cloud(frame(), points) != Status::kOk) {
    return "wrote " + pictures + after + what +
           "; no cloud: no calibration packet of this frame's size arrived";
  }
  value_or_end(write_ply(folder / "cloud.ply", points));
  return "wrote " + pictures + " and " + (folder / "cloud.ply").string() + after + what;
}

}  // namespace stof::host
