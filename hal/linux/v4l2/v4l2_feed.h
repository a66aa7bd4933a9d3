#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "hal/clock.h"
#include "hal/linux/camera/exposure_matcher.h"
#include "hal/linux/camera/exposures.h"
#include "hal/linux/v4l2/v4l2_device.h"

namespace stof::hal::linux {

// A picture and the exposure behind it.
struct V4l2Arrival {
  V4l2Buffer buffer;
  Exposure exposure;     // both ends are the stamp where it is not matched
  bool matched = false;  // ExposureMatcher is sure of the exposure
};

// The pictures of one device that have come and wait for being handed out, the oldest first, each
// with its exposure. Does not allocate, does not block.
class V4l2Feed {
 public:
  static constexpr int kMostWaiting = 4;

  // `exposures` and `most_delay` as ExposureMatcher's.
  // Stamps that are ages ahead of `clock` are of CLOCK_REALTIME (uvcvideo's module option `clock`),
  // whatever the driver says, and are converted. `clock` outlives the feed.
  V4l2Feed(V4l2Calls& calls, hal::Clock& clock, V4l2Options options, Exposures& exposures,
           Duration most_delay)
      : device_(calls, std::move(options)), clock_(clock), matcher_(exposures, most_delay) {}

  V4l2Device& device() noexcept { return device_; }
  const V4l2Device& device() const noexcept { return device_; }

  // Takes what the driver has, at most as much as it has buffers, and keeps the newest `room`
  // (kMostWaiting at most). kOk; kCorrupt: as kOk, and a damaged picture was among them;
  // kDeviceLost, also: too many pictures in a row that nobody can place.
  Status drain(int room) noexcept;
  // nullptr: nothing waits.
  const V4l2Arrival* oldest() const noexcept { return count_ == 0 ? nullptr : waiting_.data(); }
  // The oldest one, whose buffer is now the caller's to release.
  V4l2Arrival take() noexcept;
  void drop_oldest() noexcept { device_.release(take().buffer); }
  void drop_all() noexcept;
  // The device is about to be opened anew: drops all, and what was learnt of it.
  void forget() noexcept;
  // When light was collected for the last damaged picture.
  const Exposure& damaged() const noexcept { return damaged_; }

 private:
  V4l2Arrival match(V4l2Buffer buffer) noexcept;
  void keep_newest(int room) noexcept;

  V4l2Device device_;
  hal::Clock& clock_;
  ExposureMatcher matcher_;
  std::array<V4l2Arrival, kMostWaiting> waiting_{};
  int count_ = 0;
  Exposure damaged_{};
};

// Until one of the feeds, two at most, has something to tell, or `timeout`. Devices that report an
// error are lost afterwards.
void wait_for_any(V4l2Calls& calls, std::span<V4l2Feed* const> feeds, Duration timeout) noexcept;

}  // namespace stof::hal::linux
