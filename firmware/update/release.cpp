#include "firmware/update/release.h"

#include <algorithm>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"

namespace stof::update {
namespace {

constexpr std::string_view kMagic{"STOFUPD\0", 8};
constexpr std::uint16_t kVersion = 1;
constexpr std::size_t kSignedBytes = 128;
static_assert(kSignedBytes + sizeof(wire::Signature) == kReleaseBytes);

// Of a record, its second sector.
constexpr std::size_t kBeforeAt = 512;
constexpr std::string_view kBeforeMagic{"STOFWAS\0", 8};
constexpr std::size_t kBeforeBytes = 24;

bool begins_with(std::span<const std::byte> bytes, std::string_view text) noexcept {
  return std::ranges::equal(bytes.first(text.size()), std::as_bytes(std::span(text)));
}

template <std::size_t N>
void take_text(std::span<const std::byte> from, std::array<char, N>& to) noexcept {
  std::ranges::transform(from.first(N), to.begin(),
                         [](std::byte byte) { return std::to_integer<char>(byte); });
}

}  // namespace

std::string_view text_of(std::span<const char> text) noexcept {
  return {text.begin(), std::ranges::find(text, '\0')};
}

std::optional<Release> read_release(std::span<const std::byte, kReleaseBytes> bytes) noexcept {
  if (!begins_with(bytes, kMagic) || wire::get_u16(bytes.subspan<8, 2>()) != kVersion ||
      wire::get_u32(bytes.subspan<12, 4>()) != kChunkBytes) {
    return std::nullopt;
  }
  Release release;
  take_text(bytes.subspan(16), release.board);
  take_text(bytes.subspan(32), release.camera);
  take_text(bytes.subspan(48), release.version);
  release.counter = wire::get_u32(bytes.subspan<80, 4>());
  release.bytes = wire::get_u32(bytes.subspan<84, 4>());
  release.letter_at = wire::get_u32(bytes.subspan<88, 4>());
  std::ranges::copy(bytes.subspan(96, kHashBytes), release.hashes.begin());
  const bool letter_fits = release.letter_at == kNoLetter || release.letter_at < release.bytes;
  return release.bytes > 0 && letter_fits ? std::optional(release) : std::nullopt;
}

bool is_signed(std::span<const std::byte, kReleaseBytes> bytes,
               std::span<const wire::PublicKey> keys) noexcept {
  wire::Signature signature;
  std::ranges::copy(bytes.subspan(kSignedBytes), signature.begin());
  return std::ranges::any_of(keys, [&](const wire::PublicKey& key) {
    return wire::is_signed(key, signature, bytes.first(kSignedBytes));
  });
}

std::uint32_t fingerprint_of(std::span<const std::byte, kReleaseBytes> bytes) noexcept {
  return std::max(wire::crc32c(bytes), std::uint32_t{1});
}

Record read_record(const RecordBytes& bytes) noexcept {
  Record record;
  std::ranges::copy(std::span(bytes).first<kReleaseBytes>(), record.bytes.begin());
  record.release = read_release(record.bytes);
  const auto before = std::span(bytes).subspan<kBeforeAt, kBeforeBytes>();
  if (begins_with(before, kBeforeMagic) &&
      wire::crc32c(before.first<12>()) == wire::get_u32(before.subspan<12, 4>())) {
    record.before = static_cast<Shown>(wire::get_u32(before.subspan<8, 4>()) & kAllShown);
    if (wire::crc32c(before.first<20>()) == wire::get_u32(before.subspan<20, 4>())) {
      record.trial = wire::get_u32(before.subspan<16, 4>());
    }
  }
  return record;
}

RecordBytes write_record(const ReleaseBytes& release, Shown before, std::uint32_t trial) noexcept {
  RecordBytes bytes{};
  std::ranges::copy(release, bytes.begin());
  const auto second = std::span(bytes).subspan<kBeforeAt, kBeforeBytes>();
  std::ranges::copy(std::as_bytes(std::span(kBeforeMagic)), second.begin());
  wire::put_u32(second.subspan<8, 4>(), before);
  wire::put_u32(second.subspan<12, 4>(), wire::crc32c(second.first<12>()));
  wire::put_u32(second.subspan<16, 4>(), trial);
  wire::put_u32(second.subspan<20, 4>(), wire::crc32c(second.first<20>()));
  return bytes;
}

}  // namespace stof::update
