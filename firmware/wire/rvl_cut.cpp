#include <algorithm>
#include <array>

#include "firmware/wire/bytes.h"
#include "firmware/wire/rvl.h"
#include "firmware/wire/rvl_numbers.h"

namespace stof::wire {
namespace {

// Sums of 16 bits, without a branch: compilers make vectors of them.
template <typename T>
std::uint32_t sum_of_least(std::span<const T> values) noexcept {
  constexpr std::array<std::uint16_t, 5> kLongerFrom{8, 64, 512, 4096, 32'768};
  std::uint16_t sum = values[0] != 0 ? 1 : 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const T value = values[i];
    const T before = values[i - 1];
    const auto number = static_cast<std::uint16_t>(rvl_zigzag(value, before));
    std::uint16_t longer = 0;
    for (const std::uint16_t from : kLongerFrom) {
      longer = static_cast<std::uint16_t>(longer + (number >= from ? 1 : 0));
    }
    const std::uint16_t mask = before == 0 ? 0 : 0xFFFF;
    const std::uint16_t nibbles = static_cast<std::uint16_t>(1 + (longer & mask));
    sum = static_cast<std::uint16_t>(sum + (value == 0 ? 0 : nibbles));
  }
  return sum;
}

}  // namespace

template <typename T>
std::uint32_t rvl_least_nibbles(std::span<const T> values) noexcept {
  constexpr std::size_t kPiece = 8192;  // its sum stays below 2^16
  std::uint32_t nibbles = 0;
  for (std::size_t begin = 0; begin < values.size(); begin += kPiece) {
    const auto piece = values.subspan(begin, std::min(kPiece, values.size() - begin));
    nibbles += sum_of_least(piece);
  }
  return nibbles;
}

std::size_t rvl_bytes(const RvlCut& cut) noexcept {
  return (cut.nibbles + kRvlWordNibbles - 1) / kRvlWordNibbles * kRvlWordBytes;
}

std::size_t rvl_finish(const RvlCut& cut, std::span<std::byte> out) noexcept {
  const auto word = [out](std::uint32_t nibble) {
    return out.subspan(nibble / kRvlWordNibbles * kRvlWordBytes).first<kRvlWordBytes>();
  };
  const auto shift = [](std::uint32_t nibble) {
    return kRvlNibbleBits * (kRvlWordNibbles - 1 - nibble % kRvlWordNibbles);
  };
  if (cut.values == 0) {
    return 0;
  }
  // The run may have been announced longer than it is now: the same nibbles, another number.
  const RvlPattern length = rvl_spread(cut.count, cut.count_nibbles);
  for (std::uint32_t i = 0; i < cut.count_nibbles; ++i) {
    const std::uint32_t nibble = (length.bits >> shift(i)) & 15U;
    const std::uint32_t at = cut.count_at + i;
    put_u32(word(at), (get_u32(word(at)) & ~(15U << shift(at))) | (nibble << shift(at)));
  }
  // Behind the end, and where an empty run of other values ends it, is 0.
  const std::uint32_t end = cut.nibbles - (cut.zeros ? 1 : 0);
  const std::size_t bytes = rvl_bytes(cut);
  std::uint32_t first_whole = end / kRvlWordNibbles;
  if (end % kRvlWordNibbles != 0) {
    put_u32(word(end), get_u32(word(end)) & ~((std::uint32_t{16} << shift(end)) - 1));
    ++first_whole;
  }
  std::ranges::fill(out.first(bytes).subspan(std::min(bytes, first_whole * kRvlWordBytes)),
                    std::byte{});
  return bytes;
}

template std::uint32_t rvl_least_nibbles(std::span<const std::uint8_t>) noexcept;
template std::uint32_t rvl_least_nibbles(std::span<const std::uint16_t>) noexcept;

}  // namespace stof::wire
