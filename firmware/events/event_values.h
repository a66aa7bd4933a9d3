#pragma once

#include <cstdint>

// Values of events and of their conditions.
namespace stof::firmware {

// Of pairing at the sensor: kPairingTold and above: that and the six digits.
inline constexpr std::uint32_t kPairingClosed = 0;
inline constexpr std::uint32_t kPairingOpen = 1;
inline constexpr std::uint32_t kPairingDone = 2;  // a key came of it
inline constexpr std::uint32_t kPairingTold = 1'000'000;
// And `former`, with a state: why it has ended, or that it stays as it is.
inline constexpr std::uint32_t kPairingPressed = 1;     // somebody pressed the button meanwhile
inline constexpr std::uint32_t kPairingHeldInVain = 2;  // held, with no digits told before

// What came of the newest trial of a release: the value of the condition.
inline constexpr std::uint32_t kNoRelease = 0;
inline constexpr std::uint32_t kReleaseOnTrial = 1;
inline constexpr std::uint32_t kReleaseConfirmed = 2;
inline constexpr std::uint32_t kReleaseLeft = 3;

// Of a change of the settings, `former`: what it is to the network, which is on trial until an
// admin saves it.
inline constexpr std::uint32_t kNotOfNetwork = 0;
inline constexpr std::uint32_t kNetworkOnTrial = 1;
inline constexpr std::uint32_t kNetworkTakenBack = 2;  // nobody saved it in time

}  // namespace stof::firmware
