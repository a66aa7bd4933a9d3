#pragma once

#include "firmware/wire/packet.h"

namespace stof::client {

// Whether a frame's part of a known kind is not what it says. What is unknown cannot be judged.
bool contradicts_itself(const wire::PacketView& packet);
// Whether a packet of this type says that a sensor runs, and in which session: what frames are made
// of and what is said beside them. Raw pictures and what is not known, of a newer sensor, do not.
bool tells_of_sensor(wire::PacketType type) noexcept;

}  // namespace stof::client
