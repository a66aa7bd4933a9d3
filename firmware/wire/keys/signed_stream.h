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

// How tags are made here: StreamKeyFields::tags.
inline constexpr std::uint8_t kStreamTags = 1;

// The answer that hands a stream key over: to a request of that key and counter.
struct KeyHandover {
  Origin sensor{};
  const Key& key;
  std::uint64_t counter = 0;
};
StreamKeyFields seal_stream_key(const StreamKey& stream, const KeyHandover& to) noexcept;
// Number 0 where the tags of that key are made in a way that is not known here.
StreamKey open_stream_key(const StreamKeyFields& fields, const KeyHandover& to) noexcept;

// A stream key, and the one-time keys of a block of its counters: one of many costs little.
class StreamTagger {
 public:
  static constexpr std::size_t kInBlock = 16;

  StreamTagger() noexcept = default;
  explicit StreamTagger(const StreamKey& key) noexcept : key_(key) {}
  const StreamKey& key() const noexcept { return key_; }

  // What tags the datagram with that counter: of the block that is kept, else computed for it.
  OneTimeKey key_of(std::uint64_t counter) const noexcept;
  // Keeps the block of that counter where it is newer than the one that is kept.
  void keep(std::uint64_t counter) noexcept;

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  StreamKey key_;
  std::uint64_t block_ = kNone;
  std::array<OneTimeKey, kInBlock> keys_{};
};

// Copies a sealed datagram of kHeaderBytes of header, at most kMaxDatagram - kStreamSignatureBytes
// long, into `buffer`, with a signature between header and payload. A counter is used once with a
// key. Returns the datagram, a part of `buffer`.
std::span<const std::byte> sign_datagram(std::span<const std::byte> datagram, StreamTagger& tagger,
                                         std::uint64_t counter, DatagramBuffer& buffer) noexcept;

// Of a datagram that parse_packet() took. None: it has no signature.
std::optional<StreamSignature> signature_of(std::span<const std::byte> datagram) noexcept;
// Whether that key signed it; `signature` is its own. Keeps nothing: whoever cannot sign makes
// nobody compute a block.
bool signed_with(const StreamTagger& tagger, const StreamSignature& signature,
                 std::span<const std::byte> datagram) noexcept;

}  // namespace stof::wire
