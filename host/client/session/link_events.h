#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/client/session/link_watch.h"

namespace stof::client {

// What LinkState tells, one by one.
enum class LinkCondition : std::uint8_t { kSilent, kRestarted, kForged, kDelayed, kNoKey };
inline constexpr std::size_t kLinkConditions = 5;

struct LinkEvent {
  LinkCondition condition = LinkCondition::kSilent;
  bool active = false;      // it began; else it ended. A restart begins, and that is all
  std::uint32_t count = 0;  // how often it has begun
  Time at{};                // when that was seen
};

// What began and ended since the last look. A restart is told by the count of sessions: two of them
// between two looks are two events. Where nobody takes them the newest ones stay.
class LinkEvents {
 public:
  static constexpr std::size_t kMostKept = 64;

  // sessions: that were begun so far; the first one is no restart.
  void look(const LinkState& state, std::uint64_t sessions, Time now) noexcept;
  std::optional<LinkEvent> take() noexcept;
  std::uint32_t restarts() const noexcept {
    return counts_[static_cast<std::size_t>(LinkCondition::kRestarted)];
  }

 private:
  void note(LinkCondition condition, bool active, Time now) noexcept;

  std::array<bool, kLinkConditions> active_{};
  std::array<std::uint32_t, kLinkConditions> counts_{};
  std::uint64_t sessions_ = 0;
  std::array<LinkEvent, kMostKept> kept_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace stof::client
