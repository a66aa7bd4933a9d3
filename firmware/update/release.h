#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/update/shown.h"
#include "firmware/wire/crypto/crypto.h"

// What a maker signs, and how a slot remembers it. The bytes: README.md.
namespace stof::update {

inline constexpr std::size_t kReleaseBytes = 192;
inline constexpr std::size_t kChunkBytes = std::size_t{1} << 16;
inline constexpr std::size_t kHashBytes = sizeof(wire::Digest);
// At the end of each slot, behind its file system: of the release in it.
inline constexpr std::size_t kRecordBytes = 4096;
inline constexpr std::size_t kWrittenBytes = 1024;  // of these
inline constexpr std::uint32_t kNoLetter = 0xFFFF'FFFF;

using ReleaseBytes = std::array<std::byte, kReleaseBytes>;

// One release for one board: the head of an update file.
struct Release {
  std::array<char, 16> board{};   // filled up with 0, as all texts
  std::array<char, 16> camera{};  // kind of the pair, as scripts/image --camera
  std::array<char, 32> version{};
  std::uint32_t counter = 0;            // only rises; a lower one is refused
  std::uint32_t bytes = 0;              // of the slot, at least 1
  std::uint32_t letter_at = kNoLetter;  // where the slot's letter, 'a' or 'b', has its place
  wire::Digest hashes{};                // of the hashes of all chunks, one behind the other

  std::size_t chunks() const noexcept {
    return (std::size_t{bytes} + kChunkBytes - 1) / kChunkBytes;
  }
  // Of the whole update file.
  std::size_t file_bytes() const noexcept { return kReleaseBytes + chunks() * kHashBytes + bytes; }
};

std::string_view text_of(std::span<const char> text) noexcept;

// None: no release, or of another version of this format. Says nothing of who signed it.
std::optional<Release> read_release(std::span<const std::byte, kReleaseBytes> bytes) noexcept;
bool is_signed(std::span<const std::byte, kReleaseBytes> bytes,
               std::span<const wire::PublicKey> keys) noexcept;
// Tells one release from another; 0: there is none.
std::uint32_t fingerprint_of(std::span<const std::byte, kReleaseBytes> bytes) noexcept;

// What a slot's record says. It is written when the slot is whole, and wiped before the slot is
// written: a slot without it is none that may be started.
struct Record {
  ReleaseBytes bytes{};
  std::optional<Release> release;  // none: nothing, or a part of something, is in the slot
  // What the sensor published before it restarted with this slot; none: nobody told.
  std::optional<Shown> before;
  std::uint32_t trial = 0;  // its number on this card; 0: as the card was written
};

using RecordBytes = std::array<std::byte, kWrittenBytes>;
Record read_record(const RecordBytes& bytes) noexcept;
// trial: one more than the running release's. Of two slots the one that runs without a trial was
// confirmed: where the other one has a higher number, that one was tried and left.
RecordBytes write_record(const ReleaseBytes& release, Shown before, std::uint32_t trial) noexcept;

}  // namespace stof::update
