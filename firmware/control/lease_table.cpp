#include "firmware/control/lease_table.h"

#include <algorithm>
#include <span>

#include "firmware/control/source_limiter.h"
#include "firmware/wire/frame/raw_packets.h"

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
    Entry& entry = entries_[at];
    if (entry.key_id == 0 && !entry.fixed && count_open(at) >= open_places_) {
      return false;
    }
    renew(entry, peer, now + lease);
    return true;
  }
  if (count_ == kMostSubscribers || count_open(count_) >= open_places_ ||
      count_of_host(peer) >= kMostOfHost) {
    return false;
  }
  entries_[count_++] = {.peer = peer, .until = now + lease};
  return true;
}

const wire::StreamKey* LeaseTable::subscribe_signed(const hal::Peer& peer, const SignedTerms& terms,
                                                    hal::Duration lease, hal::Time now) noexcept {
  const std::size_t at = find(peer);
  if (at == kMostSubscribers) {
    return nullptr;
  }
  if (at == count_) {
    entries_[count_++] = {.peer = peer};
  }
  Entry& entry = entries_[at];
  renew(entry, peer, now + lease);
  if (entry.stream.number == 0 || entry.key_id != terms.key_id ||
      entry.stream.number != terms.has) {
    entry.stream.number = ++stream_keys_;
    wire::fill_random(entry.stream.secret);
  }
  entry.key_id = terms.key_id;
  return &entry.stream;
}

wire::SubscribeResult LeaseTable::ask_raw(const hal::Peer& peer, const wire::RawRequest& raw,
                                          const RawAsker& by) noexcept {
  const std::size_t at = find(peer);
  const bool wanted = (raw.pictures & wire::kRawPictures) != 0;
  const bool permitted =
      raw_for_admins_ ? by.role == wire::Role::kAdmin : by.role.has_value() || by.unpaired;
  const bool kept = at == count_ || (entries_[at].key_id != 0 && !by.role);
  bool given = true;
  if (!kept) {
    entries_[at].raw = {};
    given = !wanted || !permitted || give_raw(entries_[at], raw, by.role.has_value());
  }
  if (wanted && !permitted) {
    return wire::SubscribeResult::kRawDenied;
  }
  return given ? wire::SubscribeResult::kOk : wire::SubscribeResult::kRawTaken;
}

bool LeaseTable::give_raw(Entry& entry, const wire::RawRequest& raw, bool with_key) noexcept {
  for (Entry& other : std::span(entries_).first(count_)) {
    if (other.raw.pictures == 0) {
      continue;
    }
    if (!with_key || other.key_id != 0) {
      return false;
    }
    other.raw = {};
  }
  entry.raw = raw;
  entry.raw.pictures &= wire::kRawPictures | wire::kRawWhole | wire::kRawAnew;
  return true;
}

void LeaseTable::unsubscribe(const hal::Peer& peer, bool with_key) noexcept {
  const std::size_t at = find(peer);
  if (at < count_ && !entries_[at].fixed && (with_key || entries_[at].key_id == 0)) {
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

void LeaseTable::drop_ended_keys(const wire::KeyTable& keys) noexcept {
  for (std::size_t at = count_; at-- > 0;) {
    Entry& entry = entries_[at];
    if (entry.key_id == 0 || keys.find(entry.key_id) != nullptr) {
      continue;
    }
    if (entry.fixed) {
      wire::wipe(entry.stream.secret);
      entry.stream.number = 0;
      entry.key_id = 0;
      entry.raw = {};
    } else {
      remove(at);
    }
  }
}

ReceiverList LeaseTable::list() const noexcept {
  ReceiverList list{.count = count_, .refused = refused_until_.has_value()};
  for (std::size_t i = 0; i < count_; ++i) {
    list.peers[i] = entries_[i].peer;
    list.keys[i] = entries_[i].stream;
    if (entries_[i].raw.pictures != 0) {
      list.raw_receiver = i;
      list.raw = entries_[i].raw;
    }
  }
  return list;
}

void LeaseTable::renew(Entry& entry, const hal::Peer& peer, hal::Time until) noexcept {
  entry.until = std::max(entry.until, until);
  if (!entry.fixed) {
    entry.peer = peer;  // it may ask at another address of ours
  }
}

std::size_t LeaseTable::find(const hal::Peer& peer) const noexcept {
  const auto found = std::find_if(entries_.begin(), entries_.begin() + count_,
                                  [&](const Entry& entry) { return entry.peer == peer; });
  return static_cast<std::size_t>(found - entries_.begin());
}

std::size_t LeaseTable::count_of_host(const hal::Peer& peer) const noexcept {
  const hal::Peer host = host_of(peer);
  return static_cast<std::size_t>(std::count_if(
      entries_.begin(), entries_.begin() + count_,
      [&](const Entry& entry) { return entry.key_id == 0 && host_of(entry.peer) == host; }));
}

std::size_t LeaseTable::count_open(std::size_t end) const noexcept {
  return static_cast<std::size_t>(
      std::count_if(entries_.begin(), entries_.begin() + end,
                    [](const Entry& entry) { return entry.key_id == 0; }));
}

void LeaseTable::remove(std::size_t index) noexcept {
  std::ranges::move(entries_.begin() + index + 1, entries_.begin() + count_,
                    entries_.begin() + index);
  --count_;
  wire::wipe(entries_[count_].stream.secret);
}

}  // namespace stof::firmware
