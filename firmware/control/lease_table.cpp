#include "firmware/control/lease_table.h"

#include <algorithm>

#include "firmware/control/source_limiter.h"

namespace stof::firmware {

hal::Duration LeaseTable::granted(std::uint16_t lease_ms) noexcept {
  if (lease_ms == 0) {
    return kLease;
  }
  return std::clamp<hal::Duration>(std::chrono::milliseconds(lease_ms), kShortestLease,
                                   kLongestLease);
}

bool LeaseTable::fix(const hal::Peer& peer) noexcept {
  if (count_ == kMostSubscribers) {
    return false;
  }
  entries_[count_++] = {.peer = peer, .until = {}, .fixed = true};
  return true;
}

bool LeaseTable::subscribe(const hal::Peer& peer, hal::Duration lease, hal::Time now) noexcept {
  const std::size_t at = find(peer);
  if (at < count_) {
    entries_[at].until = std::max(entries_[at].until, now + lease);
    return true;
  }
  if (count_ == kMostSubscribers || count_of_host(peer) >= kMostOfHost) {
    return false;
  }
  entries_[count_++] = {.peer = peer, .until = now + lease, .fixed = false};
  return true;
}

void LeaseTable::unsubscribe(const hal::Peer& peer) noexcept {
  const std::size_t at = find(peer);
  if (at < count_ && !entries_[at].fixed) {
    remove(at);
  }
}

void LeaseTable::refused(const hal::Peer& peer, hal::Time now) noexcept {
  const std::size_t at = find(peer);
  if (at < count_ && entries_[at].fixed) {
    refused_until_ = now + kRefusal;
  }
}

void LeaseTable::expire(hal::Time now) noexcept {
  for (std::size_t at = count_; at-- > 0;) {
    if (!entries_[at].fixed && entries_[at].until <= now) {
      remove(at);
    }
  }
  if (refused_until_ && *refused_until_ <= now) {
    refused_until_.reset();
  }
}

ReceiverList LeaseTable::list() const noexcept {
  ReceiverList list{.count = count_, .refused = refused_until_.has_value()};
  for (std::size_t i = 0; i < count_; ++i) {
    list.peers[i] = entries_[i].peer;
  }
  return list;
}

std::size_t LeaseTable::find(const hal::Peer& peer) const noexcept {
  const auto found = std::find_if(entries_.begin(), entries_.begin() + count_,
                                  [&](const Entry& entry) { return entry.peer == peer; });
  return static_cast<std::size_t>(found - entries_.begin());
}

std::size_t LeaseTable::count_of_host(const hal::Peer& peer) const noexcept {
  const hal::Peer host = host_of(peer);
  return static_cast<std::size_t>(
      std::count_if(entries_.begin(), entries_.begin() + count_,
                    [&](const Entry& entry) { return host_of(entry.peer) == host; }));
}

void LeaseTable::remove(std::size_t index) noexcept {
  std::ranges::move(entries_.begin() + index + 1, entries_.begin() + count_,
                    entries_.begin() + index);
  --count_;
}

}  // namespace stof::firmware
