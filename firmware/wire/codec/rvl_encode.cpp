#include "firmware/wire/codec/rvl_encode.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/x86_target.h"

namespace stof::wire {
namespace {

// Differences from -kNear to kNear - 1 have at most four nibbles: the number of bits below, so that
// entries are shifts and sums of them are, too; the nibbles above.
constexpr std::uint32_t kNear = 2048;
constexpr unsigned kBitsAt = 16;
constexpr std::array<std::uint32_t, std::size_t{2} * kNear> kNearNumbers = [] {
  std::array<std::uint32_t, std::size_t{2} * kNear> numbers{};
  for (std::uint32_t i = 0; i < numbers.size(); ++i) {
    const std::uint32_t number = i < kNear ? 2 * (kNear - i) - 1 : 2 * (i - kNear);
    const RvlPattern pattern = rvl_spread(number);
    numbers[i] = pattern.bits << kBitsAt | kRvlNibbleBits * pattern.nibbles;
  }
  return numbers;
}();
// Place of a difference in it; outside of it where it is not near.
template <typename T>
std::uint32_t near(T value, T before) noexcept {
  if constexpr (sizeof(T) > 1) {  // those that wrap to near ones are as well not in the table
    return value + kNear - before;
  } else {
    const auto difference = static_cast<std::make_signed_t<T>>(static_cast<T>(value - before));
    return static_cast<std::uint32_t>(difference + static_cast<std::int32_t>(kNear));
  }
}

// Whole or part of a word or two: nibbles, the first ones lowest.
struct Nibbles {
  std::uint64_t bits = 0;
  unsigned count = 0;  // bits, not nibbles
};
constexpr Nibbles of_near(std::uint32_t entry) noexcept {
  return {.bits = entry >> kBitsAt, .count = entry % (1U << kBitsAt)};
}
// Four numbers of the table. Shifts take the lowest six bits, for which processors need nothing.
constexpr Nibbles of_near(std::uint32_t first, std::uint32_t second, std::uint32_t third,
                          std::uint32_t fourth) noexcept {
  constexpr std::uint32_t kShift = 64;
  const std::uint32_t two = first + second;
  const std::uint32_t three = two + third;
  const auto nibbles = [](std::uint32_t entry) noexcept { return std::uint64_t{entry >> kBitsAt}; };
  return {.bits = nibbles(first) | nibbles(second) << first % kShift |
                  nibbles(third) << two % kShift | nibbles(fourth) << three % kShift,
          .count = (three + fourth) % (1U << kBitsAt)};
}
constexpr Nibbles of_pattern(RvlPattern pattern) noexcept {
  return {.bits = pattern.bits, .count = kRvlNibbleBits * pattern.nibbles};
}
// A number; the length of a run mostly is in the table.
constexpr Nibbles of_number(std::uint32_t number) noexcept {
  const std::uint32_t sign = 0 - number % 2;  // all ones where it stands for one below 0
  return number < kNearNumbers.size() ? of_near(kNearNumbers[kNear + ((number / 2) ^ sign)])
                                      : of_pattern(rvl_spread(number));
}
template <typename T>
Nibbles of_difference(T value, T before) noexcept {
  const std::uint32_t place = near(value, before);
  return place < kNearNumbers.size() ? of_near(kNearNumbers[place])
                                     : of_pattern(rvl_spread(rvl_zigzag(value, before)));
}

// Vectors that compilers make of what each processor has; a true mask is all ones.
using U8x8 [[gnu::vector_size(8)]] = std::uint8_t;
using I8x8 [[gnu::vector_size(8)]] = std::int8_t;
using U16x8 [[gnu::vector_size(16)]] = std::uint16_t;
using I16x8 [[gnu::vector_size(16)]] = std::int16_t;

template <typename V, typename T>
[[gnu::always_inline]] inline V load_eight(const T* from) noexcept {
  V v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
[[gnu::always_inline]] inline U16x8 wide(U16x8 v) noexcept { return v; }
[[gnu::always_inline]] inline U16x8 wide(U8x8 v) noexcept {
  return __builtin_convertvector(v, U16x8);
}

// Eight values and the ones before them. from[-1] is one, too.
template <typename T>
struct Eight {
  using V = std::conditional_t<sizeof(T) == 1, U8x8, U16x8>;
  using Signed = std::conditional_t<sizeof(T) == 1, I8x8, I16x8>;

  [[gnu::always_inline]] explicit Eight(const T* from) noexcept
      : value(load_eight<V>(from)), before(load_eight<V>(from - 1)) {}

  // rvl_zigzag() of each.
  [[gnu::always_inline]] U16x8 numbers() const noexcept {
    constexpr int kTop = 8 * sizeof(T) - 1;
    const V difference = value - before;
    const V sign = std::bit_cast<V>(std::bit_cast<Signed>(difference) >> kTop);
    return wide(V((difference << 1) ^ sign));
  }

  V value;
  V before;
};

[[gnu::always_inline]] inline U16x8 mask_above(U16x8 v, std::uint16_t bound) noexcept {
  return std::bit_cast<U16x8>(v > bound);
}

// Writes nibbles, in the order of rvl_numbers.h.
class Writer {
 public:
  // Most that add_many() takes.
  static constexpr unsigned kMostBits = 56;

  explicit Writer(std::span<std::byte> out) noexcept
      : out_(out.first(out.size() / kRvlWordBytes * kRvlWordBytes)) {}

  std::uint32_t left() const noexcept {
    return static_cast<std::uint32_t>(2 * out_.size()) - nibbles();
  }
  std::uint32_t nibbles() const noexcept {
    return static_cast<std::uint32_t>(2 * at_) + bits_ / kRvlNibbleBits;
  }

  // Of one number; false: there is no room for it.
  bool add(Nibbles number) noexcept {
    if (takes_many()) [[likely]] {
      add_many(number);
      return true;
    }
    if (number.count > kRvlNibbleBits * left()) {
      return false;
    }
    pending_ |= number.bits << bits_;
    for (bits_ += number.count; bits_ >= kByteBits; bits_ -= kByteBits) {
      out_[at_++] = static_cast<std::byte>(pending_ & 0xFFU);
      pending_ >>= kByteBits;
    }
    return true;
  }

  // Whether there is room for kMostBits, with two words of its own.
  bool takes_many() const noexcept { return at_ + sizeof(pending_) <= out_.size(); }
  // If so.
  void add_many(Nibbles nibbles) noexcept {
    pending_ |= nibbles.bits << bits_;
    put_u64(out_.subspan(at_).first<sizeof(pending_)>(), pending_);
    bits_ += nibbles.count;
    at_ += bits_ / kByteBits;
    pending_ >>= bits_ / kByteBits * kByteBits;
    bits_ %= kByteBits;
  }

  void flush() noexcept {
    if (bits_ > 0) {
      out_[at_] = static_cast<std::byte>(pending_);
    }
  }

 private:
  static constexpr unsigned kByteBits = 8;

  std::span<std::byte> out_;
  std::uint64_t pending_ = 0;  // its lowest bits_ bits belong to the byte at at_; the others are 0
  unsigned bits_ = 0;          // < kByteBits
  std::size_t at_ = 0;
};

// How many values are 0, or are not, from the first on: eight bytes at a time.
template <bool kZeros, typename T>
std::size_t run_of(std::span<const T> values) noexcept {
  constexpr std::size_t kStep = sizeof(std::uint64_t) / sizeof(T);
  constexpr std::uint64_t kOnes = ~std::uint64_t{0} / std::numeric_limits<T>::max();
  constexpr std::uint64_t kTops = kOnes << (8 * sizeof(T) - 1);
  std::size_t at = 0;
  for (; at + kStep <= values.size(); at += kStep) {
    std::uint64_t some = 0;
    std::memcpy(&some, values.data() + at, sizeof some);
    // The lowest top bit that is set is that of the first 0.
    const std::uint64_t ends = kZeros ? some : (some - kOnes) & ~some & kTops;
    if (ends != 0) {
      return at + static_cast<std::size_t>(std::countr_zero(ends)) / (8 * sizeof(T));
    }
  }
  while (at < values.size() && (values[at] == 0) == kZeros) {
    ++at;
  }
  return at;
}
static_assert(std::endian::native == std::endian::little);

// Codes one sequence.
template <typename T>
class Encoder {
 public:
  Encoder(std::span<const T> values, std::size_t first_row, std::size_t row,
          std::span<std::byte> out) noexcept
      : values_(values), row_end_(first_row), row_(row), writer_(out) {}

  // All of it is compiled for the processor of who calls it.
  [[gnu::always_inline]] RvlFit run() noexcept {
    while (at_ < values_.size() && add_zeros() && add_others()) {
    }
    writer_.flush();
    return fit_;
  }

 private:
  // Each adds one run; false: not all of it fits.
  [[gnu::always_inline]] bool add_zeros() noexcept {
    const auto rest = values_.subspan(at_);
    const auto count = static_cast<std::uint32_t>(run_of<true>(rest));
    const Nibbles length = of_number(count);
    const std::uint32_t nibbles = length.count / kRvlNibbleBits;
    if (nibbles + 1 > writer_.left()) {
      return false;
    }
    run_ = {.count_at = writer_.nibbles(), .count_nibbles = nibbles, .zeros = true};
    writer_.add(length);
    const std::size_t begin = at_;
    at_ += count;
    fit_.all = cut(at_, begin);
    if (at_ >= row_end_) {
      const std::size_t last = row_end_ + (at_ - row_end_) / row_ * row_;
      fit_.rows = cut(last, begin);
      row_end_ = last + row_;
    }
    return true;
  }

  [[gnu::always_inline]] bool add_others() noexcept {
    const std::size_t most = std::min<std::size_t>(values_.size() - at_, writer_.left());
    const auto rest = values_.subspan(at_, most);
    const std::size_t count = run_of<false>(rest);
    const Nibbles length = of_number(static_cast<std::uint32_t>(count));
    const std::uint32_t nibbles = length.count / kRvlNibbleBits;
    if (count == 0) {
      // The values end, or `out` does: what is already said by the cut after the zeros.
      return false;
    }
    if (nibbles >= writer_.left()) {
      return false;
    }
    run_ = {.count_at = writer_.nibbles(), .count_nibbles = nibbles};
    writer_.add(length);
    const std::size_t begin = at_;
    const std::size_t end = at_ + count;
    while (at_ < end) {
      const std::size_t wanted = std::min(end, row_end_);
      at_ = add_differences(wanted);
      if (at_ > begin) {
        fit_.all = cut(at_, begin);
      }
      if (at_ < wanted) {
        return false;
      }
      if (at_ == row_end_) {
        fit_.rows = fit_.all;
        row_end_ += row_;
      }
    }
    return true;
  }

  // The differences of values up to `end`, as many as fit; returns where that is.
  [[gnu::always_inline]] std::size_t add_differences(std::size_t end) noexcept {
    Writer writer = writer_;
    T before = before_;
    std::size_t at = at_;
    const T* const values = values_.data();
    while (at < end) {
      if (at + 4 <= end && writer.takes_many()) [[likely]] {
        const std::uint32_t first = near(values[at], before);
        const std::uint32_t second = near(values[at + 1], values[at]);
        const std::uint32_t third = near(values[at + 2], values[at + 1]);
        const std::uint32_t fourth = near(values[at + 3], values[at + 2]);
        if ((first | second | third | fourth) < kNearNumbers.size()) [[likely]] {
          const Nibbles all = of_near(kNearNumbers[first], kNearNumbers[second],
                                      kNearNumbers[third], kNearNumbers[fourth]);
          if (all.count <= Writer::kMostBits) [[likely]] {
            writer.add_many(all);
            before = values[at + 3];
            at += 4;
            continue;
          }
        }
      }
      if (!writer.add(of_difference(values[at], before))) {
        break;
      }
      before = values[at];
      ++at;
    }
    before_ = before;
    writer_ = writer;
    return at;
  }

  RvlCut cut(std::size_t end, std::size_t begin) const noexcept {
    RvlCut cut = run_;
    cut.values = end;
    cut.nibbles = writer_.nibbles() + (run_.zeros ? 1 : 0);
    cut.count = static_cast<std::uint32_t>(end - begin);
    return cut;
  }

  std::span<const T> values_;
  std::size_t row_end_;
  std::size_t row_;
  Writer writer_;
  std::size_t at_ = 0;
  T before_ = 0;  // the last value that was not zero
  RvlCut run_;    // the run that is being written
  RvlFit fit_;
};

template <typename T>
STOF_WIRE_AVX2 RvlFit fit_avx2(std::span<const T> values, std::size_t first_row, std::size_t row,
                               std::span<std::byte> out) noexcept {
  return Encoder<T>(values, first_row, row, out).run();
}

// The largest numbers of one nibble, of two and so on.
constexpr std::array<std::uint16_t, 5> kLargest{7, 63, 511, 4095, 32'767};

// What each value behind the first one takes at least: its difference, and where a run begins with
// it, a nibble of that run's length.
template <typename T>
[[gnu::always_inline]] inline U16x8 least_of(const Eight<T>& eight) noexcept {
  constexpr std::size_t kLevels = sizeof(T) == 1 ? 2 : kLargest.size();
  const U16x8 numbers = eight.numbers();
  U16x8 longer{};  // what is added to one nibble, negative
  for (std::size_t level = 0; level < kLevels; ++level) {
    longer += mask_above(numbers, kLargest[level]);
  }
  const U16x8 zero = std::bit_cast<U16x8>(wide(eight.value) == 0);
  const U16x8 behind_zero = std::bit_cast<U16x8>(wide(eight.before) == 0);
  return ((1 - (longer & ~behind_zero)) & ~zero) - (zero ^ behind_zero);
}
template <typename T>
std::uint32_t least_of(T value, T before) noexcept {
  const std::uint32_t nibbles = before == 0 ? 1 : rvl_spread(rvl_zigzag(value, before)).nibbles;
  return (value == 0 ? 0 : nibbles) + ((value == 0) != (before == 0) ? 1 : 0);
}

template <typename T>
[[gnu::always_inline]] inline std::uint32_t sum_of_least(std::span<const T> values) noexcept {
  U16x8 sums{};
  std::size_t i = 1;
  for (; i + 8 <= values.size(); i += 8) {
    sums += least_of(Eight<T>(values.data() + i));
  }
  std::uint32_t sum = values.front() != 0 ? 1 : 0;
  for (int lane = 0; lane < 8; ++lane) {
    sum += sums[lane];
  }
  for (; i < values.size(); ++i) {
    sum += least_of(values[i], values[i - 1]);
  }
  return sum;
}

template <typename T>
STOF_WIRE_AVX2 std::uint32_t sum_avx2(std::span<const T> values) noexcept {
  return sum_of_least(values);
}

}  // namespace

template <typename T>
RvlFit rvl_fit(std::span<const T> values, std::size_t first_row, std::size_t row,
               std::span<std::byte> out) noexcept {
  STOF_CHECK(first_row > 0 && row > 0);
  const std::size_t most = std::min(values.size(), kMostRvlValues);
  return uses_avx2() ? fit_avx2(values.first(most), first_row, row, out)
                     : Encoder<T>(values.first(most), first_row, row, out).run();
}

template <typename T>
RvlCoded rvl_encode(std::span<const T> values, std::span<std::byte> out) noexcept {
  const RvlFit fit = rvl_fit(values, kMostRvlValues, 1, out);
  return {.values = fit.all.values, .bytes = rvl_finish(fit.all, out)};
}

template <typename T>
std::uint32_t rvl_least_nibbles(std::span<const T> values) noexcept {
  constexpr std::size_t kPiece = 8192;  // sums of an eighth of it stay below 2^16
  std::uint32_t nibbles = 0;
  for (std::size_t begin = 0; begin < values.size(); begin += kPiece) {
    const auto piece = values.subspan(begin, std::min(kPiece, values.size() - begin));
    nibbles += uses_avx2() ? sum_avx2(piece) : sum_of_least(piece);
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
template RvlFit rvl_fit(std::span<const std::uint8_t>, std::size_t, std::size_t,
                        std::span<std::byte>) noexcept;
template RvlFit rvl_fit(std::span<const std::uint16_t>, std::size_t, std::size_t,
                        std::span<std::byte>) noexcept;
template RvlCoded rvl_encode(std::span<const std::uint8_t>, std::span<std::byte>) noexcept;
template RvlCoded rvl_encode(std::span<const std::uint16_t>, std::span<std::byte>) noexcept;

}  // namespace stof::wire
