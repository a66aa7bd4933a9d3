#include "host/client/frame/packet_checks.h"

#include "firmware/wire/frame_info.h"

namespace stof::client {

bool contradicts_itself(const wire::PacketView& packet) {
  const wire::Header& header = packet.header;
  if (header.type == wire::PacketType::kTile) {
    return wire::pixel_bytes(header.stream, header.codec) != 0 && !wire::consistent_tile(packet);
  }
  return header.type == wire::PacketType::kFrameInfo && !wire::read_frame_info(packet.payload);
}

bool tells_of_sensor(wire::PacketType type) noexcept {
  switch (type) {
    case wire::PacketType::kTile:
    case wire::PacketType::kFrameInfo:
    case wire::PacketType::kParity:
    case wire::PacketType::kCalibration:
    case wire::PacketType::kHealth:
    case wire::PacketType::kEvent:
      return true;
    default:
      return false;
  }
}

}  // namespace stof::client
