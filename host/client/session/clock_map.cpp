#include "host/client/session/clock_map.h"

#include <algorithm>

namespace stof::client {

void ClockMap::add(const Frame& frame) noexcept {
  if (frame.origin.session_id != session_) {
    *this = {};
    session_ = frame.origin.session_id;
  }
  unmappable_ = frame.stamp.clock != wire::ClockState::kMonotonic;
  if (unmappable_ || !frame.info) {
    return;
  }
  // Wraps like the bytes that it comes from: no stamp is trusted to be a time.
  const std::uint64_t sent = static_cast<std::uint64_t>(frame.stamp.exposure_middle_ns) +
                             static_cast<std::uint64_t>(frame.info->latency_ns);
  const auto arrived =
      std::chrono::duration_cast<std::chrono::nanoseconds>(frame.first_packet.time_since_epoch());
  const auto offset = static_cast<std::int64_t>(static_cast<std::uint64_t>(arrived.count()) - sent);
  turn(frame.first_packet);
  Window& window = windows_.front();
  window.least_ns = window.used ? std::min(window.least_ns, offset) : offset;
  window.most_ns = window.used ? std::max(window.most_ns, offset) : offset;
  window.used = true;
  newest_ = frame.first_packet;
}

void ClockMap::turn(Time now) noexcept {
  if (!windows_.front().used) {
    begun_ = now;
  } else if (now - begun_ >= kWindow) {
    const bool adjoining = now - begun_ < 2 * kWindow;
    windows_ = {Window{}, adjoining ? windows_.front() : Window{}};
    begun_ = now;
  }
}

std::optional<ClockMapping> ClockMap::mapping() const noexcept {
  const Window& newer = windows_[0];
  const Window& older = windows_[1];
  if (!newer.used) {
    return std::nullopt;
  }
  ClockMapping out{.offset_ns = newer.least_ns, .spread_ns = 0, .newest = newest_};
  std::int64_t most = newer.most_ns;
  if (older.used) {
    out.offset_ns = std::min(newer.least_ns, older.least_ns);
    most = std::max(newer.most_ns, older.most_ns);
  }
  out.spread_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(most) -
                                            static_cast<std::uint64_t>(out.offset_ns));
  return out;
}

}  // namespace stof::client
