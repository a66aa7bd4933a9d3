#include "host/client/session/link_events.h"

#include <algorithm>

namespace stof::client {

void LinkEvents::look(const LinkState& state, std::uint64_t sessions, Time now) noexcept {
  const std::uint64_t before = std::max<std::uint64_t>(sessions_, 1);
  const std::uint64_t restarts = sessions > before ? sessions - before : 0;
  sessions_ = sessions;
  for (std::uint64_t i = 0; i < std::min<std::uint64_t>(restarts, kMostKept); ++i) {
    note(LinkCondition::kRestarted, true, now);
  }
  const std::array<bool, kLinkConditions> now_active{state.silent, false, state.forged_traffic,
                                                     state.delayed, state.no_key};
  for (std::size_t i = 0; i < kLinkConditions; ++i) {
    if (now_active[i] != active_[i]) {
      active_[i] = now_active[i];
      note(static_cast<LinkCondition>(i), active_[i], now);
    }
  }
}

void LinkEvents::note(LinkCondition condition, bool active, Time now) noexcept {
  std::uint32_t& count = counts_[static_cast<std::size_t>(condition)];
  count += active ? 1U : 0U;
  if (size_ == kMostKept) {
    first_ = (first_ + 1) % kMostKept;
    --size_;
  }
  kept_[(first_ + size_) % kMostKept] = {
      .condition = condition, .active = active, .count = count, .at = now};
  ++size_;
}

std::optional<LinkEvent> LinkEvents::take() noexcept {
  if (size_ == 0) {
    return std::nullopt;
  }
  const LinkEvent event = kept_[first_];
  first_ = (first_ + 1) % kMostKept;
  --size_;
  return event;
}

}  // namespace stof::client
