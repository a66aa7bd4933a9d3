#pragma once

#include <cstddef>

namespace stof::hal {

// Bytes of UDP payload that fit an IPv6 packet of the smallest MTU: never a fragment.
inline constexpr std::size_t kMaxDatagram = 1280 - 40 - 8;

}  // namespace stof::hal
