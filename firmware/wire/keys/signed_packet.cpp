#include "firmware/wire/keys/signed_packet.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"

namespace stof::wire {

Result<SignedView> open_signed(const PacketView& packet,
                               std::span<const std::byte> datagram) noexcept {
  const std::span<const std::byte> payload = packet.payload;
  if (payload.size() < kSignedFieldsBytes + sizeof(Tag)) {
    return fail(Status::kCorrupt);
  }
  const Result<SignedFields> fields = decode_signed_fields(payload);
  if (!fields) {
    return fail(fields.error());
  }
  const std::size_t header_bytes = datagram.size() - payload.size() - kCrcBytes;
  return SignedView{.fields = *fields,
                    .payload = payload.subspan(kSignedFieldsBytes,
                                               payload.size() - kSignedFieldsBytes - sizeof(Tag)),
                    .covered = datagram.first(header_bytes + payload.size() - sizeof(Tag)),
                    .tag = payload.last(sizeof(Tag))};
}

bool signed_with(const Secret& secret, const SignedView& view) noexcept {
  return equal_secrets(tag_of(secret, {view.covered}), view.tag);
}

std::span<const std::byte> seal_signed(const Header& header, const SignedFields& fields,
                                       std::size_t payload_bytes, const Secret& secret,
                                       DatagramBuffer& buffer) noexcept {
  STOF_CHECK(payload_bytes <= kMaxSignedPayload);
  const std::span<std::byte, kMaxPayload> payload = payload_space(buffer);
  encode_signed_fields(fields, payload.first<kSignedFieldsBytes>());
  const std::size_t bytes = kSignedFieldsBytes + payload_bytes + sizeof(Tag);
  // The header as it will be: the tag is of it, and the check sum of the tag.
  const std::span<const std::byte> sealed = seal_packet(header, bytes, buffer);
  const std::size_t covered = sealed.size() - kCrcBytes - sizeof(Tag);
  std::ranges::copy(tag_of(secret, {sealed.first(covered)}), buffer.begin() + covered);
  const std::size_t at = sealed.size() - kCrcBytes;
  put_u32(std::span(buffer).subspan(at).first<kCrcBytes>(), crc32c(sealed.first(at)));
  return sealed;
}

}  // namespace stof::wire
