#include "firmware/wire/keys/signed_stream.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"

namespace stof::wire {
namespace {

constexpr std::size_t kHeaderLengthAt = 6;
constexpr std::size_t kSignedHeaderBytes = kHeaderBytes + kStreamSignatureBytes;
constexpr std::size_t kTagAt = kSignedHeaderBytes - sizeof(Tag);
static_assert(kTagAt % sizeof(Tag) == 0);  // whole blocks of the tag before it

// What hides the key in one answer, and in no other.
Digest pad_of(const KeyHandover& to) noexcept {
  constexpr std::string_view kText = "stof stream key 1";
  std::array<std::byte, 20> numbers;
  const std::span<std::byte, 20> bytes(numbers);
  put_u32(bytes.subspan<0, 4>(), to.sensor.device_id);
  put_u32(bytes.subspan<4, 4>(), to.sensor.session_id);
  put_u32(bytes.subspan<8, 4>(), to.key.id);
  put_u64(bytes.subspan<12, 8>(), to.counter);
  return digest_of(to.key.secret, {std::as_bytes(std::span(kText)), numbers});
}

Tag tag_of_datagram(const OneTimeKey& key, std::span<const std::byte> datagram) noexcept {
  const std::span<const std::byte> covered = datagram.first(datagram.size() - kCrcBytes);
  return one_time_tag(key, {covered.first(kTagAt), covered.subspan(kSignedHeaderBytes)});
}

}  // namespace

StreamKeyFields seal_stream_key(const StreamKey& stream, const KeyHandover& to) noexcept {
  StreamKeyFields fields{.number = stream.number, .tags = kStreamTags};
  Digest pad = pad_of(to);
  std::ranges::transform(stream.secret, pad, fields.sealed.begin(), [](std::byte a, std::byte b) {
    return std::to_integer<std::uint8_t>(a ^ b);
  });
  wipe(pad);
  return fields;
}

StreamKey open_stream_key(const StreamKeyFields& fields, const KeyHandover& to) noexcept {
  if (fields.tags != kStreamTags) {
    return {};
  }
  StreamKey stream{.number = fields.number};
  Digest pad = pad_of(to);
  std::ranges::transform(fields.sealed, pad, stream.secret.begin(),
                         [](std::uint8_t a, std::byte b) { return std::byte{a} ^ b; });
  wipe(pad);
  return stream;
}

OneTimeKey StreamTagger::key_of(std::uint64_t counter) const noexcept {
  const std::uint64_t block = counter / kInBlock;
  const auto place = static_cast<std::uint32_t>(counter % kInBlock);
  return block == block_ ? keys_[place] : one_time_key(key_.secret, key_.number, block, place);
}

void StreamTagger::keep(std::uint64_t counter) noexcept {
  const std::uint64_t block = counter / kInBlock;
  if (block_ == kNone || block > block_) {
    block_ = block;
    derive_one_time_keys(key_.secret, key_.number, block, keys_);
  }
}

std::span<const std::byte> sign_datagram(std::span<const std::byte> datagram, StreamTagger& tagger,
                                         std::uint64_t counter, DatagramBuffer& buffer) noexcept {
  STOF_CHECK(datagram.size() >= kHeaderBytes + kCrcBytes &&
             datagram.size() + kStreamSignatureBytes <= buffer.size());
  const std::size_t bytes = datagram.size() + kStreamSignatureBytes;
  const std::span<std::byte> out = std::span(buffer).first(bytes);
  std::ranges::copy(datagram.first<kHeaderBytes>(), out.begin());
  std::ranges::copy(datagram.subspan(kHeaderBytes), out.begin() + kSignedHeaderBytes);
  put_u8(out.subspan<kHeaderLengthAt, 1>(), kSignedHeaderBytes);
  encode_stream_signature({.number = tagger.key().number, .counter = counter},
                          out.subspan<kHeaderBytes, kStreamSignatureBytes>());
  tagger.keep(counter);
  std::ranges::copy(tag_of_datagram(tagger.key_of(counter), out), out.begin() + kTagAt);
  put_u32(out.last<kCrcBytes>(), crc32c(out.first(bytes - kCrcBytes)));
  return out;
}

std::optional<StreamSignature> signature_of(std::span<const std::byte> datagram) noexcept {
  if (get_u8(datagram.subspan<kHeaderLengthAt, 1>()) < kSignedHeaderBytes) {
    return std::nullopt;
  }
  const Result<StreamSignature> signature =
      decode_stream_signature(datagram.subspan<kHeaderBytes>());
  return signature && signature->number != 0 ? std::optional(*signature) : std::nullopt;
}

bool signed_with(const StreamTagger& tagger, const StreamSignature& signature,
                 std::span<const std::byte> datagram) noexcept {
  return equal_secrets(tag_of_datagram(tagger.key_of(signature.counter), datagram),
                       std::as_bytes(std::span(signature.tag)));
}

}  // namespace stof::wire
