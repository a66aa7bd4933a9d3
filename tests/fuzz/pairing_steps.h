#pragma once

#include <cstddef>
#include <cstdint>

// The input of the pairing target: a byte that says how many keys the sensor has, then steps. Bits
// 0 to 3 of a step say what happens, 4 and 5 whose it is of four clients, 7 that it comes over the
// cable.
namespace stof::fuzz {

enum class PairingStep : std::uint8_t {
  kBeginDigits,
  kBeginCode,
  kBeginCable,
  kReveal,
  kConfirm,
  kPress,     // the sensor's button
  kHold,      // likewise; with the cable's bit: it began a moment ago
  kWait,      // 1, 2, 4 ... 128 s, by bits 5 to 7
  kKeys,      // clients 0 and 1: the first key goes; 2 and 3: it has signed
  kRenew,     // the client begins to renew the first key; over the cable: with its newest secret
  kOpen,      // the cable's request in the button's place
  kAccept,    // likewise: the digits that the sensor has; client 3: others
  kPoint,     // begin and reveal of a public key that is none: one byte more
  kFlipped,   // a begin, reveal or confirm with one bit changed on its way: two bytes more
  kMixed,     // the client reveals upon the answer to the next one
  kAnything,  // a request of any bytes: 112 more
};

inline constexpr std::uint8_t kCableBit = 0x80;
inline constexpr std::size_t kMostSteps = 64;
inline constexpr std::size_t kAnythingBytes = 112;

constexpr PairingStep step_of(std::uint8_t byte) noexcept {
  return static_cast<PairingStep>(byte & 15U);
}
constexpr std::uint8_t byte_of(PairingStep step, unsigned client, bool cable = false) noexcept {
  return static_cast<std::uint8_t>(static_cast<unsigned>(step) | (client & 3U) << 4U |
                                   (cable ? kCableBit : 0U));
}
// Bytes of the input that follow the step's own.
constexpr std::size_t bytes_after(std::uint8_t byte) noexcept {
  switch (step_of(byte)) {
    case PairingStep::kPoint:
      return 1;
    case PairingStep::kFlipped:
      return 2;
    case PairingStep::kAnything:
      return kAnythingBytes;
    default:
      return 0;
  }
}

}  // namespace stof::fuzz
