#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/control/receiver_list.h"
#include "firmware/wire/keys/key_table.h"
#include "firmware/wire/messages/structs.h"
#include "hal/datagram_port.h"
#include "hal/time.h"

namespace stof::firmware {

// Whose key signed a request to subscribe, and which stream key it has.
struct SignedTerms {
  std::uint32_t key_id = 0;  // not 0
  std::uint32_t has = 0;
};

// Who asks for raw pictures.
struct RawAsker {
  std::optional<wire::Role> role{};  // of the key that signed; none: nobody signed
  bool unpaired = false;             // nobody can sign: then everybody may have them
};

// The receivers of the streams, each with the end of its lease. The control thread owns it and
// hands the loop a list of peers whenever that changes: there is one table and one set of rules. No
// clock: `now` is the caller's, and must not go back.
class LeaseTable {
 public:
  static constexpr hal::Duration kLease = std::chrono::seconds(3);  // where none is asked for
  static constexpr hal::Duration kShortestLease = std::chrono::milliseconds(500);
  static constexpr hal::Duration kLongestLease = std::chrono::seconds(10);
  // So long after its last refusal a fixed destination counts as silent.
  static constexpr hal::Duration kRefusal = std::chrono::milliseconds(3500);

  // The lease that a request for `lease_ms` gets.
  static hal::Duration granted(std::uint16_t lease_ms) noexcept;

  // A destination without a lease, which takes one of the places; before the first subscription.
  // False: all places are taken.
  bool fix(const hal::Peer& peer) noexcept;
  // Adds a peer, or lengthens its lease to now + lease; never shortens what it had. False: full, or
  // its host has kMostOfHost, or the place that is left is kept. One that was signed stays so.
  bool subscribe(const hal::Peer& peer, hal::Duration lease, hal::Time now) noexcept;
  // The same of whoever signed with that key: its streams are signed too. A host may have all
  // places so, and one is kept. The stream key that it has had here goes on where `has` is its
  // number, else it is a new one. nullptr: full.
  const wire::StreamKey* subscribe_signed(const hal::Peer& peer, const SignedTerms& terms,
                                          hal::Duration lease, hal::Time now) noexcept;
  // What a subscriber wants of raw pictures, for as long as its lease lasts; without any: no more
  // of them. One at a time has them, whoever asked first; one that signed takes them from one that
  // did not. Of a lease that was signed nothing changes without a key. kOk; kRawTaken: another one
  // has them; kRawDenied: this one may have none.
  wire::SubscribeResult ask_raw(const hal::Peer& peer, const wire::RawRequest& raw,
                                const RawAsker& by) noexcept;
  // Raw pictures are for admins alone: the installer fixed what is sent.
  void keep_raw_for_admins(bool keep) noexcept { raw_for_admins_ = keep; }
  // Fixed ones stay, and signed ones, unless this is signed as well.
  void unsubscribe(const hal::Peer& peer, bool with_key = false) noexcept;
  // Whether one place is for those who sign alone: there are keys. Who has it without one keeps it
  // until the end of its lease.
  void keep_place(bool keep) noexcept { open_places_ = kMostSubscribers - (keep ? 1 : 0); }
  // Somebody says that nobody listens there (ICMP, which anybody can send): of a fixed destination
  // it is noted, and nothing changes; a lease ends by its time alone.
  void refused(const hal::Peer& peer, hal::Time now) noexcept;
  // Removes those whose lease has ended at `now`.
  void expire(hal::Time now) noexcept;
  // Removes those that signed with a key that is none any more: nothing is signed for it, and it
  // keeps no place. A fixed destination stays, unsigned.
  void drop_ended_keys(const wire::KeyTable& keys) noexcept;

  std::size_t count() const noexcept { return count_; }
  // As the loop is to have it. In order of arrival.
  ReceiverList list() const noexcept;

 private:
  struct Entry {
    hal::Peer peer{};
    hal::Time until{};
    bool fixed = false;
    std::uint32_t key_id = 0;  // that signed; 0: none
    wire::StreamKey stream{};
    wire::RawRequest raw{};
  };
  // False: another one has them.
  bool give_raw(Entry& entry, const wire::RawRequest& raw, bool with_key) noexcept;
  std::size_t find(const hal::Peer& peer) const noexcept;  // count_: not here
  std::size_t count_of_host(const hal::Peer& peer) const noexcept;
  // Without a key, of the first `end`.
  std::size_t count_open(std::size_t end) const noexcept;
  static void renew(Entry& entry, const hal::Peer& peer, hal::Time until) noexcept;
  void remove(std::size_t index) noexcept;

  std::array<Entry, kMostSubscribers> entries_{};
  std::size_t count_ = 0;
  std::size_t open_places_ = kMostSubscribers;  // of whoever has no key
  std::uint32_t stream_keys_ = 0;               // that were drawn
  bool raw_for_admins_ = false;
  std::optional<hal::Time> refused_until_;  // a fixed destination's
};

}  // namespace stof::firmware
