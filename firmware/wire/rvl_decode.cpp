#include <algorithm>
#include <bit>

#include "firmware/wire/bytes.h"
#include "firmware/wire/rvl.h"

namespace stof::wire {
namespace {

constexpr int kNibbleBits = 4;
constexpr int kWordBits = 32;
constexpr std::size_t kWordBytes = 4;

// Nibbles are read from the lowest bits up: the other way round than a word has them.
constexpr std::uint32_t turned(std::uint32_t word) noexcept {
  constexpr std::uint32_t kLowNibbles = 0x0F0F0F0F;
  const std::uint32_t bytes = std::byteswap(word);
  return ((bytes >> kNibbleBits) & kLowNibbles) | ((bytes & kLowNibbles) << kNibbleBits);
}

// The number whose nibbles these are, up to six of them: their lower three bits side by side.
constexpr std::uint32_t joined(std::uint32_t nibbles) noexcept {
  const std::uint32_t pairs = (nibbles & 0x070707U) | ((nibbles & 0x707070U) >> 1);
  return (pairs & 0x3FU) | ((pairs >> 2) & 0xFC0U) | ((pairs >> 4) & 0x3F000U);
}
static_assert(turned(0x12345678) == 0x87654321);
static_assert(joined(0x765432) == 0b111'110'101'100'011'010);

// Reads numbers, and zeros behind the end, which whole() notices.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> in) noexcept : in_(in) {}

  std::uint32_t next() noexcept {
    refill();
    return take(stops());
  }

  // Two numbers; false, and nothing is read, if the second one does not lie in what was loaded.
  bool next_two(std::uint32_t& first, std::uint32_t& second) noexcept {
    refill();
    const std::uint64_t ends = stops();
    const std::uint64_t later = ends & (ends - 1);
    if (std::countr_zero(later) >= bits_) {
      return false;
    }
    const std::uint64_t whole = later ^ (later - 1);  // all bits up to the second one's end
    const std::uint64_t own = ends ^ (ends - 1);
    const int first_bits = std::countr_zero(ends) + 1;
    first = joined(static_cast<std::uint32_t>(pending_ & own));
    second = joined(static_cast<std::uint32_t>((pending_ & whole) >> first_bits));
    const int read = std::countr_zero(later) + 1;
    too_long_ |= first_bits > kNumberBits || read - first_bits > kNumberBits;
    pending_ >>= read;
    bits_ -= read;
    return true;
  }

  // Four numbers of one nibble each, the first one lowest; false, and nothing is read, if they are
  // not that short.
  bool next_four(std::uint32_t& numbers) noexcept {
    refill();
    numbers = static_cast<std::uint32_t>(pending_ & 0xFFFFU);
    if ((numbers & 0x8888U) != 0) {
      return false;
    }
    pending_ >>= 4 * kNibbleBits;
    bits_ -= 4 * kNibbleBits;
    return true;
  }

  // Whether the numbers read were those of the bytes: all of them, and nothing but 0 from there to
  // the end of a word.
  bool whole() const noexcept {
    const auto read = static_cast<std::int64_t>(kBitsPerByte * at_) - bits_;
    const auto all = static_cast<std::int64_t>(kBitsPerByte * in_.size());
    return !too_long_ && read <= all && all - read < kWordBits && pending_ == 0;
  }

 private:
  static constexpr std::size_t kBitsPerByte = 8;
  static constexpr int kNumberBits = kNibbleBits * kRvlNumberNibbles;

  // Every bit 3 that ends a number.
  std::uint64_t stops() const noexcept { return ~pending_ & 0x8888'8888'8888'8888U; }

  std::uint32_t take(std::uint64_t ends) noexcept {
    const std::uint64_t own = ends ^ (ends - 1);
    const int read = std::countr_zero(ends) + 1;
    const std::uint32_t number = joined(static_cast<std::uint32_t>(pending_ & own));
    too_long_ |= read > kNumberBits;
    const int taken = std::min(read, bits_);
    pending_ >>= taken;
    bits_ -= taken;
    return number;
  }

  // At least a word is there then.
  void refill() noexcept {
    if (bits_ >= kWordBits) {
      return;
    }
    if (at_ < in_.size()) {
      const std::uint32_t word = turned(get_u32(in_.subspan(at_).first<kWordBytes>()));
      pending_ |= std::uint64_t{word} << bits_;
    }
    at_ += kWordBytes;
    bits_ += kWordBits;
  }

  std::span<const std::byte> in_;
  std::size_t at_ = 0;         // what was loaded, a multiple of a word; may be behind the end
  std::uint64_t pending_ = 0;  // its lowest bits_ bits were not read yet, the others are 0
  int bits_ = 0;               // < 64
  bool too_long_ = false;
};

template <typename T>
T after(T before, std::uint32_t zigzag) noexcept {
  const std::uint32_t difference = (zigzag >> 1) ^ (0 - (zigzag & 1U));
  return static_cast<T>(before + difference);
}

}  // namespace

template <typename T>
Status rvl_decode(std::span<const std::byte> in, std::span<T> values) noexcept {
  if (in.size() % kWordBytes != 0) {
    return Status::kCorrupt;
  }
  Reader reader(in);
  T before = 0;
  while (!values.empty()) {
    const std::size_t zeros = reader.next();
    if (zeros > values.size()) {
      return Status::kCorrupt;
    }
    std::ranges::fill(values.first(zeros), T{0});
    values = values.subspan(zeros);
    const std::size_t others = reader.next();
    if (others > values.size() || (others == 0 && !values.empty())) {
      return Status::kCorrupt;
    }
    Reader local = reader;  // in registers
    std::size_t i = 0;
    while (i < others) {
      std::uint32_t first = 0;
      std::uint32_t second = 0;
      if (i + 3 < others && local.next_four(first)) {
        for (int k = 0; k < 4; ++k) {
          before = after(before, (first >> (kNibbleBits * k)) & 7U);
          values[i++] = before;
        }
      } else if (i + 1 < others && local.next_two(first, second)) [[likely]] {
        values[i] = after(before, first);
        before = after(values[i], second);
        values[i + 1] = before;
        i += 2;
      } else {
        before = after(before, local.next());
        values[i] = before;
        ++i;
      }
    }
    reader = local;
    values = values.subspan(others);
  }
  return reader.whole() ? Status::kOk : Status::kCorrupt;
}

template Status rvl_decode(std::span<const std::byte>, std::span<std::uint8_t>) noexcept;
template Status rvl_decode(std::span<const std::byte>, std::span<std::uint16_t>) noexcept;

}  // namespace stof::wire
