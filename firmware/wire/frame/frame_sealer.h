#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/wire/datagram_sink.h"
#include "firmware/wire/frame/parity.h"
#include "firmware/wire/frame/part_store.h"
#include "firmware/wire/packet.h"

namespace stof::wire {

// Where a FrameSealer puts what it makes: a datagram for each buffer of the store, and the parity
// groups that are open at a time: one for seal_all(), else all of a frame.
struct SealingMemory {
  std::span<std::span<const std::byte>> datagrams;
  std::span<ParityGroup> groups;
};

// Makes datagrams of the counted parts of one frame: headers, checks, parity.
class FrameSealer {
 public:
  FrameSealer(const Origin& origin, const FrameStamp& stamp, PartStore& store, bool parity,
              const SealingMemory& memory) noexcept
      : origin_(origin),
        stamp_(stamp),
        store_(store),
        memory_(memory),
        parts_(static_cast<std::uint16_t>(store.size())),
        groups_(parity ? parity_groups(parts_) : std::uint16_t{0}) {}

  // Datagrams of the frame.
  std::size_t all() const noexcept { return std::size_t{parts_} + groups_; }

  // All of them. The store has a buffer for each.
  Datagrams seal_all() noexcept;

  // Some of them, valid until the next call: first every part once in their order, then parity. For
  // a frame that is coded again; `begin_parity` comes before the first part.
  void begin_parity() const noexcept;
  Datagrams seal_parts(std::size_t begin, std::size_t end) noexcept;
  Datagrams seal_parity(std::size_t begin, std::size_t end) noexcept;
  std::size_t groups() const noexcept { return groups_; }
  std::size_t most_at_once() const noexcept { return store_.buffers(); }

 private:
  Header header_of(std::size_t index) const noexcept;
  std::span<const std::byte> sealed(std::size_t index) noexcept;
  std::span<const std::byte> sealed(ParityGroup& group, std::size_t index,
                                    DatagramBuffer& buffer) noexcept;
  void gather(ParityGroup& group, std::size_t index) noexcept;

  Origin origin_;
  FrameStamp stamp_;
  PartStore& store_;
  SealingMemory memory_;
  std::uint16_t parts_;
  std::uint16_t groups_;
};

}  // namespace stof::wire
