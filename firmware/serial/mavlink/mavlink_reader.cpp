#include "firmware/serial/mavlink/mavlink_reader.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::firmware::mavlink {
namespace {

constexpr unsigned kMagic1 = 0xFE;
constexpr unsigned kMagic2 = 0xFD;
constexpr std::size_t kHeader1 = 6;
constexpr std::size_t kHeader2 = 10;
constexpr std::size_t kCrcBytes = 2;
constexpr std::size_t kSignatureBytes = 13;
constexpr unsigned kSignedFlag = 1;  // of the flags that a reader has to understand

constexpr unsigned kNoAutopilot = 8;  // MAV_AUTOPILOT_INVALID

constexpr std::array kKnown{kHeartbeatKind, kPingKind};

const MessageKind* find(std::uint32_t id) noexcept {
  for (const MessageKind& kind : kKnown) {
    if (kind.id == id) {
      return &kind;
    }
  }
  return nullptr;
}

}  // namespace

std::optional<Message> Reader::take(std::span<const std::byte>& bytes) noexcept {
  drop(used_);
  used_ = 0;
  for (;;) {
    const Candidate candidate = look();
    if (size_ > 0 && candidate.need == 0) {
      ++counters_.skipped;
      drop(1);
    } else if (size_ < candidate.need || size_ == 0) {
      if (bytes.empty()) {
        return std::nullopt;
      }
      buffer_[size_++] = bytes.front();
      bytes = bytes.subspan(1);
    } else if (intact(candidate)) {
      ++counters_.messages;
      used_ = candidate.need;
      return open(candidate);
    } else {
      ++counters_.damaged;
      drop(1);
    }
  }
}

Reader::Candidate Reader::look() const noexcept {
  const std::span<const std::byte> bytes = std::span(buffer_).first(size_);
  if (bytes.empty()) {
    return {};
  }
  const unsigned magic = std::to_integer<unsigned>(bytes[0]);
  if (magic != kMagic1 && magic != kMagic2) {
    return {};
  }
  const bool second = magic == kMagic2;
  const std::size_t header = second ? kHeader2 : kHeader1;
  if (bytes.size() < header) {
    return {.need = header};
  }
  const std::size_t length = std::to_integer<std::size_t>(bytes[1]);
  const std::uint32_t id = second ? wire::get_u16(bytes.subspan<7, 2>()) |
                                        (std::to_integer<std::uint32_t>(bytes[9]) << 16)
                                  : std::to_integer<std::uint32_t>(bytes[5]);
  const MessageKind* const kind = find(id);
  if (kind == nullptr) {
    return {};
  }
  if (!second) {
    return length == kind->length_v1 ? Candidate{.need = header + length + kCrcBytes, .kind = kind}
                                     : Candidate{};
  }
  const unsigned flags = std::to_integer<unsigned>(bytes[2]);
  if (length == 0 || length > kind->length || (flags & ~kSignedFlag) != 0) {
    return {};
  }
  const std::size_t signature = flags == kSignedFlag ? kSignatureBytes : 0;
  return {.need = header + length + kCrcBytes + signature, .kind = kind};
}

bool Reader::intact(const Candidate& candidate) const noexcept {
  const std::span<const std::byte> bytes(buffer_);
  const bool second = std::to_integer<unsigned>(bytes[0]) == kMagic2;
  const std::size_t end = (second ? kHeader2 : kHeader1) + std::to_integer<std::size_t>(bytes[1]);
  const std::array extra{std::byte{candidate.kind->crc_extra}};
  return crc16(extra, crc16(bytes.subspan(1, end - 1))) ==
         wire::get_u16(bytes.subspan(end).first<kCrcBytes>());
}

Message Reader::open(const Candidate& candidate) noexcept {
  const std::span<const std::byte> bytes(buffer_);
  const bool second = std::to_integer<unsigned>(bytes[0]) == kMagic2;
  const std::size_t header = second ? kHeader2 : kHeader1;
  const std::span<const std::byte> sent =
      bytes.subspan(header, std::to_integer<std::size_t>(bytes[1]));
  std::ranges::fill(payload_, std::byte{0});
  std::ranges::copy(sent, payload_.begin());
  const std::size_t sequence_at = second ? 4 : 2;
  return {.version = static_cast<std::uint8_t>(second ? 2 : 1),
          .sequence = std::to_integer<std::uint8_t>(bytes[sequence_at]),
          .system = std::to_integer<std::uint8_t>(bytes[sequence_at + 1]),
          .component = std::to_integer<std::uint8_t>(bytes[sequence_at + 2]),
          .has_signature = second && bytes[2] != std::byte{0},
          .id = candidate.kind->id,
          .payload = std::span<const std::byte>(payload_).first(candidate.kind->length)};
}

void Reader::drop(std::size_t count) noexcept {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(count),
            buffer_.begin() + static_cast<std::ptrdiff_t>(size_), buffer_.begin());
  size_ -= count;
}

void note_message(const Message& message, hal::Time now, Autopilot& autopilot) noexcept {
  if (message.id == kHeartbeatKind.id &&
      std::to_integer<unsigned>(message.payload[5]) != kNoAutopilot) {
    autopilot = {.system = message.system, .last_heard = now};
  }
}

}  // namespace stof::firmware::mavlink
