#include <algorithm>
#include <array>

#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/rvl.h"
#include "firmware/wire/codec/rvl_numbers.h"
#include "firmware/wire/codec/wide.h"

namespace stof::wire {
namespace {

// Numbers from there on have a nibble more; with their signs turned, as vectors compare signed
// ones.
constexpr std::array<std::int32_t, 5> kLongerFrom{8, 64, 512, 4096, 32'768};
constexpr std::uint16_t kTop = 0x8000;

// Sums of 16 bits, without a branch: compilers make vectors of them.
template <typename T>
std::uint32_t sum_of_least(std::span<const T> values) noexcept {
  constexpr std::size_t kLevels = sizeof(T) == 1 ? 2 : kLongerFrom.size();
  const auto count = values.size();
  const T* const at = values.data();
  std::uint16_t sum = at[0] != 0 ? 1 : 0;
  for (std::size_t i = 1; i < count; ++i) {
    const T value = at[i];
    const T before = at[i - 1];
    const auto number =
        static_cast<std::int16_t>(static_cast<std::uint16_t>(rvl_zigzag(value, before)) ^ kTop);
    std::int16_t longer = 0;
    for (std::size_t level = 0; level < kLevels; ++level) {
      const auto below = static_cast<std::int16_t>(kLongerFrom[level] - 1 - kTop);
      longer = static_cast<std::int16_t>(longer + (number > below ? 1 : 0));
    }
    const auto nibbles = static_cast<std::int16_t>(1 + (before == 0 ? 0 : longer));
    sum = static_cast<std::uint16_t>(sum + (value == 0 ? 0 : nibbles));
  }
  return sum;
}

template <typename T>
STOF_WIRE_WIDE std::uint32_t sum_wide(std::span<const T> values) noexcept {
  return sum_of_least(values);
}

}  // namespace

template <typename T>
std::uint32_t rvl_least_nibbles(std::span<const T> values) noexcept {
  constexpr std::size_t kPiece = 8192;  // its sum stays below 2^16
  std::uint32_t nibbles = 0;
  for (std::size_t begin = 0; begin < values.size(); begin += kPiece) {
    const auto piece = values.subspan(begin, std::min(kPiece, values.size() - begin));
    nibbles += wide() ? sum_wide(piece) : sum_of_least(piece);
  }
  return nibbles;
}

std::size_t rvl_bytes(const RvlCut& cut) noexcept {
  return (cut.nibbles + kRvlWordNibbles - 1) / kRvlWordNibbles * kRvlWordBytes;
}

std::size_t rvl_finish(const RvlCut& cut, std::span<std::byte> out) noexcept {
  if (cut.values == 0) {
    return 0;
  }
  const auto put = [out](std::uint32_t nibble, std::uint32_t value) {
    const unsigned shift = kRvlNibbleBits * (nibble % 2);
    const auto others = static_cast<std::byte>(0xF0U >> shift);
    out[nibble / 2] = (out[nibble / 2] & others) | static_cast<std::byte>(value << shift);
  };
  // The run may have been announced longer than it is now: the same nibbles, another number.
  const RvlPattern length = rvl_spread(cut.count, cut.count_nibbles);
  for (std::uint32_t i = 0; i < cut.count_nibbles; ++i) {
    put(cut.count_at + i, (length.bits >> (kRvlNibbleBits * i)) & 15U);
  }
  // Behind the end, and where an empty run of other values ends it, is 0.
  const std::uint32_t end = cut.nibbles - (cut.zeros ? 1 : 0);
  const std::size_t bytes = rvl_bytes(cut);
  if (end % 2 != 0) {
    put(end, 0);
  }
  std::ranges::fill(out.first(bytes).subspan((end + 1) / 2), std::byte{});
  for (std::size_t at = 0; at < bytes; at += kRvlWordBytes) {
    const std::span<std::byte, kRvlWordBytes> word = out.subspan(at).first<kRvlWordBytes>();
    put_u32(word, rvl_turned(get_u32(word)));
  }
  return bytes;
}

template std::uint32_t rvl_least_nibbles(std::span<const std::uint8_t>) noexcept;
template std::uint32_t rvl_least_nibbles(std::span<const std::uint16_t>) noexcept;

}  // namespace stof::wire
