#include "firmware/records/layout.h"

#include <algorithm>
#include <string_view>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"

namespace stof::records {
namespace {

constexpr std::string_view kRecordMagic{"STOFDOC\0", 8};
constexpr std::string_view kDirectoryMagic{"STOFDIR\0", 8};
constexpr std::uint16_t kVersion = 1;
constexpr std::uint32_t kAbsent = 1;
constexpr std::uint32_t kListed = 2;

constexpr std::size_t kNewestAt = 20;
// A later version may have more documents; those that this one knows come first.
constexpr std::size_t kMostListed = (kHeadBytes - kNewestAt - 4) / 4;

bool begins_with(std::span<const std::byte> bytes, std::string_view magic) noexcept {
  return std::ranges::equal(bytes.first(magic.size()), std::as_bytes(std::span(magic)));
}

}  // namespace

Sector write_head(const RecordHead& head) noexcept {
  Sector sector{};
  const std::span<std::byte, kHeadUsed> used = std::span(sector).first<kHeadUsed>();
  std::ranges::copy(std::as_bytes(std::span(kRecordMagic)), used.begin());
  wire::put_u16(used.subspan<8, 2>(), kVersion);
  wire::put_u16(used.subspan<10, 2>(), static_cast<std::uint16_t>(number(head.document)));
  wire::put_u32(used.subspan<12, 4>(), head.generation);
  wire::put_u32(used.subspan<16, 4>(), head.bytes);
  wire::put_u32(used.subspan<20, 4>(), head.crc);
  wire::put_u32(used.subspan<24, 4>(), (head.absent ? kAbsent : 0) | (head.listed ? kListed : 0));
  wire::put_u32(used.last<4>(), wire::crc32c(used.first<kHeadUsed - 4>()));
  return sector;
}

std::optional<RecordHead> read_head(std::span<const std::byte, kHeadUsed> bytes) noexcept {
  const std::uint16_t document = wire::get_u16(bytes.subspan<10, 2>());
  if (!begins_with(bytes, kRecordMagic) || wire::get_u16(bytes.subspan<8, 2>()) != kVersion ||
      wire::crc32c(bytes.first<kHeadUsed - 4>()) != wire::get_u32(bytes.last<4>()) ||
      document >= kDocuments) {
    return std::nullopt;
  }
  const std::uint32_t flags = wire::get_u32(bytes.subspan<24, 4>());
  const RecordHead head{.document = static_cast<Document>(document),
                        .generation = wire::get_u32(bytes.subspan<12, 4>()),
                        .bytes = wire::get_u32(bytes.subspan<16, 4>()),
                        .crc = wire::get_u32(bytes.subspan<20, 4>()),
                        .absent = (flags & kAbsent) != 0,
                        .listed = (flags & kListed) != 0};
  return head.bytes <= most_bytes(head.document) ? std::optional(head) : std::nullopt;
}

Sector write_directory(const Directory& directory) noexcept {
  Sector sector{};
  const std::span<std::byte, kHeadBytes> bytes(sector);
  std::ranges::copy(std::as_bytes(std::span(kDirectoryMagic)), bytes.begin());
  wire::put_u16(bytes.subspan<8, 2>(), kVersion);
  wire::put_u16(bytes.subspan<10, 2>(), directory.area);
  wire::put_u32(bytes.subspan<12, 4>(), directory.generation);
  wire::put_u32(bytes.subspan<16, 4>(), kDocuments);
  for (std::size_t i = 0; i < kDocuments; ++i) {
    wire::put_u32(bytes.subspan(kNewestAt + 4 * i).first<4>(), directory.newest[i]);
  }
  wire::put_u32(bytes.last<4>(), wire::crc32c(bytes.first<kHeadBytes - 4>()));
  return sector;
}

std::optional<Directory> read_directory(const Sector& sector) noexcept {
  const std::span<const std::byte, kHeadBytes> bytes(sector);
  const std::uint32_t count = wire::get_u32(bytes.subspan<16, 4>());
  if (!begins_with(bytes, kDirectoryMagic) || wire::get_u16(bytes.subspan<8, 2>()) != kVersion ||
      wire::crc32c(bytes.first<kHeadBytes - 4>()) != wire::get_u32(bytes.last<4>()) ||
      count < kDocuments || count > kMostListed) {
    return std::nullopt;
  }
  Directory directory{.area = wire::get_u16(bytes.subspan<10, 2>()),
                      .generation = wire::get_u32(bytes.subspan<12, 4>())};
  for (std::size_t i = 0; i < kDocuments; ++i) {
    directory.newest[i] = wire::get_u32(bytes.subspan(kNewestAt + 4 * i).first<4>());
  }
  return directory.area < kAreas ? std::optional(directory) : std::nullopt;
}

bool is_blank(const Sector& bytes) noexcept {
  const auto is_all = [&bytes](std::byte value) {
    return std::ranges::all_of(bytes, [value](std::byte byte) { return byte == value; });
  };
  return is_all(std::byte{0}) || is_all(std::byte{0xFF});
}

}  // namespace stof::records
