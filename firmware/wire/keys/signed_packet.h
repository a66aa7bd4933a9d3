#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/messages/signed_fields.h"
#include "firmware/wire/packet.h"

// Packets that a key signs: see "Signed packets" of docs/WIRE.md. The tag is of everything before
// it, the header with the session among it.
namespace stof::wire {

// Room for the payload of the message that is signed.
inline constexpr std::size_t kMaxSignedPayload = kMaxPayload - kSignedFieldsBytes - sizeof(Tag);

struct SignedView {
  SignedFields fields;
  std::span<const std::byte> payload;  // of the message that is signed
  std::span<const std::byte> covered;  // what the tag is of
  std::span<const std::byte> tag;      // sizeof(Tag)
};

// Of a packet of type kSignedRequest or kSignedAnswer and the datagram that it was parsed from.
// Says nothing about the tag. kCorrupt: too short.
Result<SignedView> open_signed(const PacketView& packet,
                               std::span<const std::byte> datagram) noexcept;

// Whether that secret signed it.
bool signed_with(const Secret& secret, const SignedView& view) noexcept;

// Where the payload that is signed belongs before seal_signed().
constexpr std::span<std::byte, kMaxSignedPayload> signed_space(DatagramBuffer& buffer) noexcept {
  return payload_space(buffer).subspan<kSignedFieldsBytes, kMaxSignedPayload>();
}

// As seal_packet(), of `payload_bytes` (at most kMaxSignedPayload) in signed_space(buffer).
// header.origin.session_id: of the sensor, in requests too.
std::span<const std::byte> seal_signed(const Header& header, const SignedFields& fields,
                                       std::size_t payload_bytes, const Secret& secret,
                                       DatagramBuffer& buffer) noexcept;

}  // namespace stof::wire
