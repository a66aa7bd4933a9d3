#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/wire/packet.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// Which sensor is listened to, and in which of its sessions: one begins with each start of it.
// Anybody can send packets of a session that never was. So another one is believed
//  - where the sensor said so in an answer to a request of ours: then that one alone;
//  - else, where nobody is asked, when nothing came of the one before for 1.2 seconds: a sensor
//    that runs says something once a second, and whoever starts again says nothing of before.
// No clock: times are the caller's.
class SessionTracker {
 public:
  enum class Verdict : std::uint8_t { kForeign, kCurrent, kStarted };

  // More than between two of health, which a sensor sends at any period.
  static constexpr Duration kSilence = std::chrono::milliseconds(1200);

  // Without a device the first one heard.
  explicit SessionTracker(std::optional<std::uint32_t> device_id) : device_id_(device_id) {}

  // An answer to a request came from this one.
  void expect(const wire::Origin& origin) noexcept { expected_ = origin; }
  // tells: tells_of_sensor(); what does not begins no session that the sensor did not name, and
  // keeps none. proven: the packet is signed for us, and with it its session.
  Verdict judge(const wire::Origin& origin, bool tells, bool proven, Time now);

  const std::optional<wire::Origin>& current() const noexcept { return current_; }
  // The sensor itself told the current one and the one before: what was learned of it then holds.
  bool outlasts() const noexcept { return outlasts_; }
  // How often the current session went on for half a second after a packet of another one of this
  // device, which had not just ended: one of the two is somebody else's.
  std::uint64_t contests() const noexcept { return contests_; }

 private:
  void refuse(const wire::Origin& origin, Time now);

  std::optional<std::uint32_t> device_id_;
  std::optional<wire::Origin> expected_;
  std::optional<wire::Origin> current_;
  bool told_ = false;  // the current one, by the sensor itself
  bool outlasts_ = false;
  Time last_heard_;
  std::optional<std::uint32_t> ended_;  // the session before
  Time began_;                          // the current one
  std::optional<Time> contested_at_;    // since the last one that counted
  std::uint64_t contests_ = 0;
};

}  // namespace stof::client
