#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/keys/key_table.h"
#include "firmware/wire/messages/stream_key.h"
#include "firmware/wire/messages/stream_signature.h"
#include "firmware/wire/packet.h"

// Datagrams that one receiver alone can verify, and the key that it gets for it: see "Signed
// streams" of docs/WIRE.md. No heap.
namespace stof::wire {

struct StreamKey {
  std::uint32_t number = 0;  // of the sensor's session, from 1; 0: none
  Secret secret{};

  friend bool operator==(const StreamKey&, const StreamKey&) = default;
};

// The answer that hands a stream key over: to a request of that key and counter.
struct KeyHandover {
  Origin sensor{};
  const Key& key;
  std::uint64_t counter = 0;
};
StreamKeyFields seal_stream_key(const StreamKey& stream, const KeyHandover& to) noexcept;
StreamKey open_stream_key(const StreamKeyFields& fields, const KeyHandover& to) noexcept;

// Copies a sealed datagram of kHeaderBytes of header, at most kMaxDatagram - kStreamSignatureBytes
// long, into `buffer`, with a signature between header and payload. A counter is used once with a
// key. Returns the datagram, a part of `buffer`.
std::span<const std::byte> sign_datagram(std::span<const std::byte> datagram, const StreamKey& key,
                                         std::uint64_t counter, DatagramBuffer& buffer) noexcept;

// Of a datagram that parse_packet() took. None: it has no signature.
std::optional<StreamSignature> signature_of(std::span<const std::byte> datagram) noexcept;
// Whether that key signed it; `signature` is its own.
bool signed_with(const StreamKey& key, const StreamSignature& signature,
                 std::span<const std::byte> datagram) noexcept;

}  // namespace stof::wire
