#include "hal/linux/v4l2/v4l2_controls.h"

#include <algorithm>
#include <chrono>
#include <cstring>

#include <linux/videodev2.h>

namespace stof::hal::linux {
namespace {

constexpr Duration kExposureUnit = std::chrono::microseconds(100);

std::string in_microseconds(Duration time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(time).count()) +
         " us";
}

std::optional<v4l2_queryctrl> find_control(V4l2Calls& calls, int fd, std::uint32_t id) {
  v4l2_queryctrl about{};
  about.id = id;
  const bool there = ask_driver(calls, fd, VIDIOC_QUERYCTRL, &about) == 0 &&
                     (about.flags & V4L2_CTRL_FLAG_DISABLED) == 0;
  return there ? std::optional(about) : std::nullopt;
}

// What the driver made of it, or the error.
std::expected<std::int32_t, int> set_control(V4l2Calls& calls, int fd, std::uint32_t id,
                                             std::int32_t value) {
  v4l2_control control{.id = id, .value = value};
  int error = ask_driver(calls, fd, VIDIOC_S_CTRL, &control);
  if (error == 0) {
    error = ask_driver(calls, fd, VIDIOC_G_CTRL, &control);
  }
  if (error != 0) {
    return std::unexpected(error);
  }
  return control.value;
}

}  // namespace

std::expected<std::optional<Duration>, std::string> set_v4l2_exposure(V4l2Calls& calls, int fd,
                                                                      Duration exposure) {
  if (find_control(calls, fd, V4L2_CID_EXPOSURE_AUTO)) {
    const auto mode = set_control(calls, fd, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
    if (mode.value_or(V4L2_EXPOSURE_AUTO) != V4L2_EXPOSURE_MANUAL) {
      return std::unexpected("does not expose by hand; use a camera that does");
    }
  }
  if (find_control(calls, fd, V4L2_CID_EXPOSURE_AUTO_PRIORITY)) {
    // Some cameras have it for the automatic mode alone.
    static_cast<void>(set_control(calls, fd, V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0));
  }
  const auto about = find_control(calls, fd, V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!about) {
    return std::nullopt;
  }
  const auto wanted = (exposure + kExposureUnit / 2) / kExposureUnit;
  if (wanted < about->minimum || wanted > about->maximum) {
    return std::unexpected("does not expose for " + in_microseconds(exposure) + "; give " +
                           in_microseconds(about->minimum * kExposureUnit) + " to " +
                           in_microseconds(about->maximum * kExposureUnit));
  }
  const auto made =
      set_control(calls, fd, V4L2_CID_EXPOSURE_ABSOLUTE, static_cast<std::int32_t>(wanted));
  if (!made) {
    return std::unexpected("does not let its exposure be set (" +
                           std::string(std::strerror(made.error())) + "); connect it anew");
  }
  const Duration result = *made * kExposureUnit;
  const Duration step = std::max(about->step, 1) * kExposureUnit;
  if (result > exposure + step || result < exposure - step) {
    return std::unexpected("exposes for " + in_microseconds(result) + " where " +
                           in_microseconds(exposure) + " were asked; ask for that");
  }
  return result;
}

std::expected<void, std::string> set_v4l2_gain(V4l2Calls& calls, int fd, std::int32_t gain) {
  const auto about = find_control(calls, fd, V4L2_CID_GAIN);
  if (!about) {
    return {};
  }
  const bool fits = gain >= about->minimum && gain <= about->maximum;
  if (!fits || !set_control(calls, fd, V4L2_CID_GAIN, gain)) {
    return std::unexpected("does not take gain " + std::to_string(gain) + "; give " +
                           std::to_string(about->minimum) + " to " +
                           std::to_string(about->maximum));
  }
  return {};
}

}  // namespace stof::hal::linux
