#include "host/client/frame/closed_frames.h"

#include <algorithm>

namespace stof::client {

void ClosedFrames::add(const FrameSlot& slot) {
  frames_[count_++ % kFrames] = {.number = slot.number(),
                                 .packets = slot.packets(),
                                 .parity = slot.parity_packets(),
                                 .parity_groups = wire::parity_groups(slot.count()),
                                 .no_parity = slot.told_no_parity(),
                                 .whole = slot.complete()};
}

std::size_t ClosedFrames::find(std::uint32_t number) const noexcept {
  const auto* const end = frames_.begin() + std::min(count_, kFrames);
  const auto* const found = std::find_if(
      frames_.begin(), end, [number](const Closed& frame) { return frame.number == number; });
  return found == end ? kFrames : static_cast<std::size_t>(found - frames_.begin());
}

ClosedFrames::Verdict ClosedFrames::judge_part(const wire::PacketView& packet) const noexcept {
  const std::size_t at = find(packet.header.frame.number);
  if (at == kFrames) {
    return Verdict::kForgotten;
  }
  const PacketSet& packets = frames_[at].packets;
  if (!packets.has(packet.header.index)) {
    return Verdict::kLate;
  }
  return packets.differs(packet.header.index, packet) ? Verdict::kContradicting
                                                      : Verdict::kRepeated;
}

ClosedFrames::Verdict ClosedFrames::judge_parity(const wire::PacketView& packet) {
  const std::size_t at = find(packet.header.frame.number);
  const std::size_t group = packet.header.index;
  if (at == kFrames || group >= frames_[at].parity_groups) {
    return Verdict::kForgotten;
  }
  Closed& frame = frames_[at];
  if (frame.no_parity || (frame.parity.has(group) && frame.parity.differs(group, packet))) {
    return Verdict::kContradicting;
  }
  if (frame.parity.has(group)) {
    return Verdict::kRepeated;
  }
  frame.parity.insert(group, packet);
  return frame.whole ? Verdict::kInOrder : Verdict::kLate;
}

}  // namespace stof::client
