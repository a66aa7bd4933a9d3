#pragma once

#include <cstdint>

namespace stof::client {

// Counts of everything that arrived, by cause. Since the receiver was opened. As many members
// as there are causes.
struct Statistics {
  // Every datagram is counted in exactly one of these.
  std::uint64_t packets_ok = 0;   // also parity that was not needed, and an event's repetition
  std::uint64_t truncated = 0;    // cut short
  std::uint64_t bad_magic = 0;    // not a packet of ours
  std::uint64_t bad_version = 0;  // a layout this library does not know: update it
  std::uint64_t bad_length = 0;   // longer than it says
  std::uint64_t bad_crc = 0;      // damaged on the way
  std::uint64_t bad_field = 0;    // undamaged but contradicting itself or its frame: a sender's bug
  std::uint64_t unknown = 0;      // type, stream or codec that this library does not know
  std::uint64_t oversized = 0;    // image larger than ReassemblerOptions::max_pixels
  std::uint64_t foreign = 0;      // of another device, or of a session that has ended
  std::uint64_t duplicate = 0;    // had arrived already
  std::uint64_t late = 0;         // its frame was closed already
  std::uint64_t old = 0;          // part of a frame that lay in this machine's queue for too long
  std::uint64_t implausible = 0;  // ahead of what any sensor can have counted: forged, or a fault
  // Only where signed streams were asked for:
  std::uint64_t not_signed = 0;  // or not with this receiver's key
  std::uint64_t forged = 0;      // signed with another key than it says, or changed on the way

  // Every frame is counted in exactly one of these.
  std::uint64_t frames_complete = 0;    // delivered whole
  std::uint64_t frames_incomplete = 0;  // delivered with missing packets
  std::uint64_t frames_stale = 0;       // freshness did not advance: not delivered
  // Older than ReassemblerOptions::max_age, or later than others by more than that: not delivered.
  std::uint64_t frames_old = 0;
  std::uint64_t frames_lost = 0;     // number skipped: nothing of it arrived in time
  std::uint64_t frames_dropped = 0;  // cut off by a restart of the sender, or nobody took them

  std::uint64_t packets_missing = 0;  // of frames of which something arrived
  // Packets made of parity: they are not missing. One that comes after all is a duplicate.
  std::uint64_t recovered = 0;
  std::uint64_t events_dropped = 0;  // nobody took them, or the sender started again before
  std::uint64_t sessions = 0;        // starts of the sender seen: 1 at the first packet
  // How often the order of frames was found wrong and begun anew, see FrameSequence.
  std::uint64_t resynchronised = 0;
  // Datagrams that found this machine's socket buffer full. They are missing above, too.
  std::uint64_t socket_drops = 0;

  constexpr std::uint64_t packets() const noexcept {
    return packets_ok + truncated + bad_magic + bad_version + bad_length + bad_crc + bad_field +
           unknown + oversized + foreign + duplicate + late + old + implausible + not_signed +
           forged;
  }
  friend bool operator==(const Statistics&, const Statistics&) = default;
};

}  // namespace stof::client
