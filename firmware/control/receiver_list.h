#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "firmware/spsc_ring.h"
#include "firmware/wire/keys/signed_stream.h"
#include "firmware/wire/messages/structs.h"
#include "hal/datagram_port.h"

namespace stof::firmware {

inline constexpr std::size_t kMostSubscribers = 4;
// Of one host without a key, which may run a viewer, a recorder and a bridge: it never has all
// places.
inline constexpr std::size_t kMostOfHost = 3;

// The receivers of all streams, from the control thread to the loop. Each list replaces the one
// before; nothing in it expires: a lease that ends makes a new list.
struct ReceiverList {
  std::array<hal::Peer, kMostSubscribers> peers{};
  // What each one's datagrams are signed with; number 0: they are not. A number has one secret, and
  // one peer, for as long as the program runs.
  std::array<wire::StreamKey, kMostSubscribers> keys{};
  std::size_t count = 0;
  // Who gets raw pictures, one of `count`, and which; kMostSubscribers: nobody.
  std::size_t raw_receiver = kMostSubscribers;
  wire::RawRequest raw{};
  // A fixed destination says that nobody listens there; it stays in the list.
  bool refused = false;

  std::span<const hal::Peer> all() const noexcept { return std::span(peers).first(count); }
  friend bool operator==(const ReceiverList& a, const ReceiverList& b) noexcept {
    return std::ranges::equal(a.all(), b.all(),
                              [](const hal::Peer& one, const hal::Peer& other) {
                                return one == other && one.own == other.own;
                              }) &&
           a.keys == b.keys && a.raw_receiver == b.raw_receiver && a.raw == b.raw &&
           a.refused == b.refused;
  }
};

// The control thread pushes a list whenever it changes, and again later where the ring was full;
// the loop takes all that wait before each frame and keeps the last.
using ReceiverRing = SpscRing<ReceiverList, 8>;

}  // namespace stof::firmware
