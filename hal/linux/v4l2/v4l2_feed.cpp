#include "hal/linux/v4l2/v4l2_feed.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <ctime>

#include "dsp/base/check.h"
#include "hal/linux/system/clock_offset.h"

namespace stof::hal::linux {
namespace {

constexpr Duration kAges = std::chrono::hours(24);

}  // namespace

Status V4l2Feed::drain(int room) noexcept {
  STOF_CHECK(room >= 0 && room <= kMostWaiting);
  Status result = Status::kOk;
  keep_newest(room);
  // Bounded: a driver that always has one more must not keep us here.
  for (std::uint32_t i = 0; i < V4l2Device::kBuffers; ++i) {
    V4l2Buffer buffer;
    const Status status = device_.dequeue(buffer);
    if (status == Status::kDeviceLost) {
      return status;
    }
    if (status == Status::kWouldBlock) {
      break;
    }
    if (status == Status::kCorrupt) {
      damaged_ = match(buffer).exposure;
      result = status;
    } else if (room == 0) {
      device_.release(buffer);
    } else {
      keep_newest(room - 1);
      waiting_[static_cast<std::size_t>(count_++)] = match(buffer);
    }
  }
  if (matcher_.hopeless()) {
    device_.lose();
    return Status::kDeviceLost;
  }
  return result;
}

V4l2Arrival V4l2Feed::take() noexcept {
  STOF_CHECK(count_ > 0);
  const V4l2Arrival first = waiting_[0];
  std::copy(waiting_.begin() + 1, waiting_.begin() + count_, waiting_.begin());
  --count_;
  return first;
}

void V4l2Feed::drop_all() noexcept { keep_newest(0); }

void V4l2Feed::forget() noexcept {
  drop_all();
  matcher_.forget();
}

void V4l2Feed::keep_newest(int room) noexcept {
  while (count_ > room) {
    drop_oldest();
  }
}

V4l2Arrival V4l2Feed::match(V4l2Buffer buffer) noexcept {
  if (buffer.stamp - clock_.now() > kAges) {
    buffer.stamp = ClockOffset(CLOCK_REALTIME).to_monotonic(buffer.stamp.time_since_epoch());
  }
  const MatchedExposure matched = matcher_.match(buffer.stamp, buffer.sequence);
  return {.buffer = buffer, .exposure = matched.exposure, .matched = matched.sure};
}

void wait_for_any(V4l2Calls& calls, std::span<V4l2Feed* const> feeds, Duration timeout) noexcept {
  std::array<pollfd, 2> entries{};
  STOF_CHECK(feeds.size() <= entries.size());
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    entries[i] = {.fd = feeds[i]->device().fd(), .events = POLLIN, .revents = 0};
  }
  const int ready = calls.poll(std::span(entries).first(feeds.size()), timeout);
  const bool failed = ready < 0 && errno != EINTR;
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    if (failed || (ready > 0 && (entries[i].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0)) {
      feeds[i]->device().lose();
    }
  }
}

}  // namespace stof::hal::linux
