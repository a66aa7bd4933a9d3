#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/wire/packet.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// Which sensor is listened to, and in which of its sessions: one begins with each start of it.
class SessionTracker {
 public:
  enum class Verdict : std::uint8_t { kForeign, kCurrent, kStarted };

  // Without a device the first one heard.
  explicit SessionTracker(std::optional<std::uint32_t> device_id) : device_id_(device_id) {}

  // A session id that was never heard is a start of the sender. One that has ended comes back only
  // when the current one is silent: then the change was not a start but a stray packet.
  Verdict judge(const wire::Origin& origin, Time now);
  const std::optional<wire::Origin>& current() const noexcept { return current_; }

 private:
  static constexpr std::size_t kRetired = 8;

  std::optional<std::uint32_t> device_id_;
  std::optional<wire::Origin> current_;
  Time last_heard_;
  std::array<std::uint32_t, kRetired> retired_{};
  std::size_t retired_count_ = 0;  // ever; the newest kRetired are kept
};

}  // namespace stof::client
