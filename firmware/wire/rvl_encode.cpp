#include <algorithm>
#include <array>
#include <bit>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/rvl.h"

namespace stof::wire {
namespace {

constexpr unsigned kNibbleBits = 4;
constexpr unsigned kWordNibbles = 8;
constexpr unsigned kWordBits = 32;
constexpr std::size_t kWordBytes = 4;

// The nibbles of a number, the first of them in the most significant bits.
struct Pattern {
  std::uint32_t bits = 0;
  std::uint32_t nibbles = 0;
};

// The number in `nibbles` nibbles, which hold it.
constexpr Pattern spread(std::uint32_t number, std::uint32_t nibbles) noexcept {
  constexpr std::uint32_t kGoesOn = 8;
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < nibbles; ++i) {
    const std::uint32_t goes_on = i + 1 < nibbles ? kGoesOn : 0;
    const std::uint32_t nibble = ((number >> (3 * i)) & 7U) | goes_on;
    bits |= nibble << (kNibbleBits * (kWordNibbles - 1 - i));
  }
  return {.bits = bits, .nibbles = nibbles};
}

constexpr Pattern spread(std::uint32_t number) noexcept {
  return spread(number, (static_cast<std::uint32_t>(std::bit_width(number | 1U)) + 2) / 3);
}

// Without a branch: the first three nibbles by the low 9 bits of a number and whether there are
// others, the rest by those others, which are none for 0.
constexpr unsigned kLowBits = 9;
constexpr std::uint32_t kLow = 1U << kLowBits;
constexpr std::array<Pattern, std::size_t{2} * kLow> kFirst = [] {
  std::array<Pattern, std::size_t{2} * kLow> patterns{};
  for (std::uint32_t i = 0; i < kLow; ++i) {
    patterns[i] = spread(i);
    patterns[kLow + i] = spread(i | kLow, 4);
    patterns[kLow + i].bits &= 0xFFF0'0000;
    patterns[kLow + i].nibbles = 3;
  }
  return patterns;
}();
constexpr std::array<Pattern, (kMostRvlValues >> kLowBits) + 1> kRest = [] {
  std::array<Pattern, (kMostRvlValues >> kLowBits) + 1> patterns{};
  for (std::uint32_t i = 1; i < patterns.size(); ++i) {
    patterns[i] = spread(i);
    patterns[i].bits >>= 3 * kNibbleBits;
  }
  return patterns;
}();

// number <= kMostRvlValues.
Pattern pattern_of(std::uint32_t number) noexcept {
  const std::uint32_t more = number >= kLow ? kLow : 0;
  const Pattern first = kFirst[more + number % kLow];
  const Pattern rest = kRest[number >> kLowBits];
  return {.bits = first.bits | rest.bits, .nibbles = first.nibbles + rest.nibbles};
}

// Differences by size, signs in turn: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
template <typename T>
std::uint32_t zigzag(T value, T before) noexcept {
  constexpr int kTop = 8 * sizeof(T) - 1;
  const auto difference = static_cast<T>(value - before);
  const auto sign = static_cast<T>(-(difference >> kTop));
  return static_cast<T>(static_cast<T>(difference << 1) ^ sign);
}

// Writes nibbles; the caller has seen that they fit.
class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept
      : out_(out), capacity_(static_cast<std::uint32_t>(out.size() / kWordBytes) * kWordNibbles) {}

  std::uint32_t left() const noexcept { return capacity_ - nibbles_; }
  std::uint32_t nibbles() const noexcept { return nibbles_; }

  void add(Pattern pattern) noexcept {
    pending_ |= (std::uint64_t{pattern.bits} << kWordBits) >> bits_;
    store();
    nibbles_ += pattern.nibbles;
    bits_ += kNibbleBits * pattern.nibbles;
    // Without a branch: either a whole word is done, or nothing moves.
    const unsigned whole = bits_ / kWordBits;
    at_ += kWordBytes * whole;
    pending_ <<= kWordBits * whole;
    bits_ %= kWordBits;
  }

  void flush() noexcept {
    if (bits_ > 0) {
      store();
    }
  }

 private:
  void store() noexcept {
    put_u32(out_.subspan(at_).first<kWordBytes>(),
            static_cast<std::uint32_t>(pending_ >> kWordBits));
  }

  std::span<std::byte> out_;
  std::uint32_t capacity_;
  std::uint32_t nibbles_ = 0;
  std::uint64_t pending_ = 0;  // its first bits_ bits belong to the word at at_
  unsigned bits_ = 0;          // < kWordBits
  std::size_t at_ = 0;
};

// Codes one sequence.
template <typename T>
class Encoder {
 public:
  Encoder(std::span<const T> values, std::size_t first_row, std::size_t row,
          std::span<std::byte> out) noexcept
      : values_(values), row_end_(first_row), row_(row), writer_(out) {}

  RvlFit run() noexcept {
    while (at_ < values_.size() && add_zeros() && add_others()) {
    }
    writer_.flush();
    return fit_;
  }

 private:
  // Each adds one run; false: not all of it fits.
  bool add_zeros() noexcept {
    const auto rest = values_.subspan(at_);
    const auto other = std::ranges::find_if(rest, [](T value) { return value != 0; });
    const auto count = static_cast<std::uint32_t>(other - rest.begin());
    const Pattern length = pattern_of(count);
    if (length.nibbles + 1 > writer_.left()) {
      return false;
    }
    run_ = {.count_at = writer_.nibbles(), .count_nibbles = length.nibbles, .zeros = true};
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

  bool add_others() noexcept {
    const std::size_t most = std::min<std::size_t>(values_.size() - at_, writer_.left());
    const auto rest = values_.subspan(at_, most);
    const auto count = static_cast<std::size_t>(std::ranges::find(rest, T{0}) - rest.begin());
    const Pattern length = pattern_of(static_cast<std::uint32_t>(count));
    if (count == 0) {
      // The values end, or `out` does: what is already said by the cut after the zeros.
      return false;
    }
    if (length.nibbles >= writer_.left()) {
      return false;
    }
    run_ = {.count_at = writer_.nibbles(), .count_nibbles = length.nibbles};
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
  std::size_t add_differences(std::size_t end) noexcept {
    Writer writer = writer_;
    T before = before_;
    std::size_t at = at_;
    while (at < end) {
      // Two at once, where they fit one word.
      if (at + 1 < end) {
        const Pattern first = pattern_of(zigzag(values_[at], before));
        const Pattern second = pattern_of(zigzag(values_[at + 1], values_[at]));
        const std::uint32_t nibbles = first.nibbles + second.nibbles;
        if (nibbles <= std::min(kWordNibbles, writer.left())) [[likely]] {
          writer.add({.bits = first.bits | (second.bits >> (kNibbleBits * first.nibbles)),
                      .nibbles = nibbles});
          before = values_[at + 1];
          at += 2;
          continue;
        }
      }
      const Pattern pattern = pattern_of(zigzag(values_[at], before));
      if (pattern.nibbles > writer.left()) {
        break;
      }
      writer.add(pattern);
      before = values_[at];
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

// Sums of 16 bits, without a branch: compilers make vectors of them.
template <typename T>
std::uint32_t sum_of_least(std::span<const T> values) noexcept {
  constexpr std::array<std::uint16_t, 5> kLongerFrom{8, 64, 512, 4096, 32'768};
  std::uint16_t sum = values[0] != 0 ? 1 : 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const T value = values[i];
    const T before = values[i - 1];
    const auto number = static_cast<std::uint16_t>(zigzag(value, before));
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
RvlFit rvl_fit(std::span<const T> values, std::size_t first_row, std::size_t row,
               std::span<std::byte> out) noexcept {
  STOF_CHECK(first_row > 0 && row > 0);
  const std::size_t most = std::min(values.size(), kMostRvlValues);
  return Encoder<T>(values.first(most), first_row, row, out).run();
}

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
  return (cut.nibbles + kWordNibbles - 1) / kWordNibbles * kWordBytes;
}

std::size_t rvl_finish(const RvlCut& cut, std::span<std::byte> out) noexcept {
  const auto word = [out](std::uint32_t nibble) {
    return out.subspan(nibble / kWordNibbles * kWordBytes).first<kWordBytes>();
  };
  const auto shift = [](std::uint32_t nibble) {
    return kNibbleBits * (kWordNibbles - 1 - nibble % kWordNibbles);
  };
  if (cut.values == 0) {
    return 0;
  }
  // The run may have been announced longer than it is now: the same nibbles, another number.
  const Pattern length = spread(cut.count, cut.count_nibbles);
  for (std::uint32_t i = 0; i < cut.count_nibbles; ++i) {
    const std::uint32_t nibble = (length.bits >> shift(i)) & 15U;
    const std::uint32_t at = cut.count_at + i;
    put_u32(word(at), (get_u32(word(at)) & ~(15U << shift(at))) | (nibble << shift(at)));
  }
  // Behind the end, and where an empty run of other values ends it, is 0.
  const std::uint32_t end = cut.nibbles - (cut.zeros ? 1 : 0);
  const std::size_t bytes = rvl_bytes(cut);
  std::uint32_t first_whole = end / kWordNibbles;
  if (end % kWordNibbles != 0) {
    put_u32(word(end), get_u32(word(end)) & ~((std::uint32_t{16} << shift(end)) - 1));
    ++first_whole;
  }
  std::ranges::fill(out.first(bytes).subspan(std::min(bytes, first_whole * kWordBytes)),
                    std::byte{});
  return bytes;
}

template <typename T>
RvlCoded rvl_encode(std::span<const T> values, std::span<std::byte> out) noexcept {
  const RvlFit fit = rvl_fit(values, kMostRvlValues, 1, out);
  return {.values = fit.all.values, .bytes = rvl_finish(fit.all, out)};
}

template RvlFit rvl_fit(std::span<const std::uint8_t>, std::size_t, std::size_t,
                        std::span<std::byte>) noexcept;
template RvlFit rvl_fit(std::span<const std::uint16_t>, std::size_t, std::size_t,
                        std::span<std::byte>) noexcept;
template std::uint32_t rvl_least_nibbles(std::span<const std::uint8_t>) noexcept;
template std::uint32_t rvl_least_nibbles(std::span<const std::uint16_t>) noexcept;
template RvlCoded rvl_encode(std::span<const std::uint8_t>, std::span<std::byte>) noexcept;
template RvlCoded rvl_encode(std::span<const std::uint16_t>, std::span<std::byte>) noexcept;

}  // namespace stof::wire
