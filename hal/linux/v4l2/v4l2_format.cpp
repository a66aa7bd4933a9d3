#include "hal/linux/v4l2/v4l2_format.h"

#include <cerrno>
#include <cstdint>

#include <linux/videodev2.h>

namespace stof::hal::linux {
namespace {

std::string size_text(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

v4l2_format wanted_format(int width, int height, FourCc pixels) noexcept {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<std::uint32_t>(width);
  format.fmt.pix.height = static_cast<std::uint32_t>(height);
  format.fmt.pix.pixelformat = pixels;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  return format;
}

// The formats of the driver, each with the size that it takes for the asked one.
std::string offers(V4l2Calls& calls, int fd, int width, int height) {
  constexpr std::uint32_t kMost = 16;
  std::string list;
  for (std::uint32_t index = 0; index < kMost; ++index) {
    v4l2_fmtdesc about{};
    about.index = index;
    about.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (ask_driver(calls, fd, VIDIOC_ENUM_FMT, &about) != 0) {
      break;
    }
    v4l2_format format = wanted_format(width, height, about.pixelformat);
    list += (list.empty() ? "" : ", ") + to_string(about.pixelformat);
    if (ask_driver(calls, fd, VIDIOC_TRY_FMT, &format) == 0) {
      list += " " + size_text(format.fmt.pix.width, format.fmt.pix.height);
    }
  }
  return list.empty() ? "nothing" : list;
}

}  // namespace

std::expected<V4l2Format, std::string> set_v4l2_format(V4l2Calls& calls, int fd, int width,
                                                       int height,
                                                       std::span<const FourCc> formats) {
  std::string asked;
  for (const FourCc pixels : formats) {
    v4l2_format format = wanted_format(width, height, pixels);
    const v4l2_pix_format wanted = format.fmt.pix;
    const int error = ask_driver(calls, fd, VIDIOC_S_FMT, &format);
    if (error != 0 && error != EINVAL) {  // a camera that hangs takes seconds for each answer
      return std::unexpected(with_advice("takes no format", error));
    }
    const v4l2_pix_format& got = format.fmt.pix;
    const std::size_t row = row_bytes(pixels, width);
    const std::size_t stride = got.bytesperline == 0 ? row : got.bytesperline;
    if (error == 0 && got.pixelformat == pixels && got.width == wanted.width &&
        got.height == wanted.height && row != 0 && stride >= row) {
      return V4l2Format{.pixels = pixels, .stride = stride};
    }
    asked += (asked.empty() ? "" : ", ") + to_string(pixels);
  }
  return std::unexpected("does not give " + std::to_string(width) + "x" + std::to_string(height) +
                         " in " + asked + ", it offers " + offers(calls, fd, width, height) +
                         "; set the size to one of these, or use another one");
}

}  // namespace stof::hal::linux
