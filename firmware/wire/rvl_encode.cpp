#include <algorithm>
#include <array>
#include <bit>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/rvl.h"
#include "firmware/wire/rvl_numbers.h"

namespace stof::wire {
namespace {

// Without a branch: the first three nibbles by the low 9 bits of a number and whether there are
// others, the rest by those others, which are none for 0.
constexpr unsigned kLowBits = 9;
constexpr std::uint32_t kLow = 1U << kLowBits;
constexpr std::array<RvlPattern, std::size_t{2} * kLow> kFirst = [] {
  std::array<RvlPattern, std::size_t{2} * kLow> patterns{};
  for (std::uint32_t i = 0; i < kLow; ++i) {
    patterns[i] = rvl_spread(i);
    patterns[kLow + i] = rvl_spread(i | kLow, 4);
    patterns[kLow + i].bits &= 0xFFF0'0000;
    patterns[kLow + i].nibbles = 3;
  }
  return patterns;
}();
constexpr std::array<RvlPattern, (kMostRvlValues >> kLowBits) + 1> kRest = [] {
  std::array<RvlPattern, (kMostRvlValues >> kLowBits) + 1> patterns{};
  for (std::uint32_t i = 1; i < patterns.size(); ++i) {
    patterns[i] = rvl_spread(i);
    patterns[i].bits >>= 3 * kRvlNibbleBits;
  }
  return patterns;
}();

// number <= kMostRvlValues.
RvlPattern pattern_of(std::uint32_t number) noexcept {
  const std::uint32_t more = number >= kLow ? kLow : 0;
  const RvlPattern first = kFirst[more + number % kLow];
  const RvlPattern rest = kRest[number >> kLowBits];
  return {.bits = first.bits | rest.bits, .nibbles = first.nibbles + rest.nibbles};
}

// Writes nibbles; the caller has seen that they fit.
class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept
      : out_(out),
        capacity_(static_cast<std::uint32_t>(out.size() / kRvlWordBytes) * kRvlWordNibbles) {}

  std::uint32_t left() const noexcept { return capacity_ - nibbles_; }
  std::uint32_t nibbles() const noexcept { return nibbles_; }

  void add(RvlPattern pattern) noexcept {
    pending_ |= (std::uint64_t{pattern.bits} << kRvlWordBits) >> bits_;
    store();
    nibbles_ += pattern.nibbles;
    bits_ += kRvlNibbleBits * pattern.nibbles;
    // Without a branch: either a whole word is done, or nothing moves.
    const unsigned whole = bits_ / kRvlWordBits;
    at_ += kRvlWordBytes * whole;
    pending_ <<= kRvlWordBits * whole;
    bits_ %= kRvlWordBits;
  }

  void flush() noexcept {
    if (bits_ > 0) {
      store();
    }
  }

 private:
  void store() noexcept {
    put_u32(out_.subspan(at_).first<kRvlWordBytes>(),
            static_cast<std::uint32_t>(pending_ >> kRvlWordBits));
  }

  std::span<std::byte> out_;
  std::uint32_t capacity_;
  std::uint32_t nibbles_ = 0;
  std::uint64_t pending_ = 0;  // its first bits_ bits belong to the word at at_
  unsigned bits_ = 0;          // < kRvlWordBits
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
    const RvlPattern length = pattern_of(count);
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
    const RvlPattern length = pattern_of(static_cast<std::uint32_t>(count));
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
        const RvlPattern first = pattern_of(rvl_zigzag(values_[at], before));
        const RvlPattern second = pattern_of(rvl_zigzag(values_[at + 1], values_[at]));
        const std::uint32_t nibbles = first.nibbles + second.nibbles;
        if (nibbles <= std::min(kRvlWordNibbles, writer.left())) [[likely]] {
          writer.add({.bits = first.bits | (second.bits >> (kRvlNibbleBits * first.nibbles)),
                      .nibbles = nibbles});
          before = values_[at + 1];
          at += 2;
          continue;
        }
      }
      const RvlPattern pattern = pattern_of(rvl_zigzag(values_[at], before));
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

}  // namespace

template <typename T>
RvlFit rvl_fit(std::span<const T> values, std::size_t first_row, std::size_t row,
               std::span<std::byte> out) noexcept {
  STOF_CHECK(first_row > 0 && row > 0);
  const std::size_t most = std::min(values.size(), kMostRvlValues);
  return Encoder<T>(values.first(most), first_row, row, out).run();
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
template RvlCoded rvl_encode(std::span<const std::uint8_t>, std::span<std::byte>) noexcept;
template RvlCoded rvl_encode(std::span<const std::uint16_t>, std::span<std::byte>) noexcept;

}  // namespace stof::wire
