#include "firmware/wire/codec/rvl_decode.h"

#include <algorithm>
#include <array>
#include <bit>

#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/rvl_numbers.h"
#include "firmware/wire/codec/x86_target.h"

namespace stof::wire {
namespace {

constexpr unsigned kByteBits = 8;
constexpr unsigned kLaneBits = 16;
constexpr std::uint64_t kGoesOn = 0x8888'8888'8888'8888;  // bit 3 of each nibble

// The number whose nibbles these are, up to six of them: their lower three bits side by side.
constexpr std::uint32_t joined(std::uint32_t nibbles) noexcept {
  const std::uint32_t pairs = (nibbles & 0x070707U) | ((nibbles & 0x707070U) >> 1);
  return (pairs & 0x3FU) | ((pairs >> 2) & 0xFC0U) | ((pairs >> 4) & 0x3F000U);
}
static_assert(joined(0x765432) == 0b111'110'101'100'011'010);

constexpr std::uint16_t difference_of(std::uint32_t zigzag) noexcept {
  return static_cast<std::uint16_t>((zigzag >> 1) ^ (0 - (zigzag & 1U)));
}

// The same four times, in lanes of 16 bits: the differences that lanes of nibbles begin with.
// Every lane has a nibble that ends a number.
constexpr std::uint64_t kLanes = 0x0001'0001'0001'0001;
constexpr std::uint64_t differences_of(std::uint64_t nibbles) noexcept {
  const std::uint64_t ends = ~nibbles & kGoesOn;
  const std::uint64_t own = nibbles & (ends ^ (ends - kLanes));
  const std::uint64_t pairs = (own & (0x0707 * kLanes)) | ((own & (0x7070 * kLanes)) >> 1);
  const std::uint64_t zigzag = (pairs & (0x3F * kLanes)) | ((pairs >> 2) & (0xFC0 * kLanes));
  return ((zigzag >> 1) & (0x7FFF * kLanes)) ^ ((zigzag & kLanes) * 0xFFFF);
}
static_assert(differences_of(0x7772'7FFF'7771'0029) == 0x0001'F800'FFFF'FFF7);

// The nibbles of a code, the first of them lowest, and zeros behind them.
class Nibbles {
 public:
  explicit Nibbles(std::span<const std::byte> in) noexcept : in_(in) {}

  // Eight bytes from byte `at` on, which never goes back.
  std::uint64_t get(std::size_t at) noexcept {
    if (at + kAhead > end_ && end_ < in_.size()) [[unlikely]] {
      load(at);
    }
    return get_u64(std::span(turned_).subspan(std::min(at, end_) - begin_).first<kAhead>());
  }
  std::size_t bytes() const noexcept { return in_.size(); }

 private:
  static constexpr std::size_t kAhead = sizeof(std::uint64_t);
  static constexpr std::size_t kPiece = 1152;  // a datagram's payload and more

  // Keeps what was not read, which is less than kAhead, and adds what follows.
  void load(std::size_t at) noexcept {
    const std::size_t kept = end_ - at;
    std::copy_n(turned_.begin() + static_cast<std::ptrdiff_t>(end_ - begin_ - kept), kept,
                turned_.begin());
    begin_ = end_ - kept;
    const std::span<const std::byte> piece = in_.subspan(end_, std::min(kPiece, in_.size() - end_));
    const std::span<std::byte> out = std::span(turned_).subspan(kept);
    for (std::size_t i = 0; i < piece.size(); i += kRvlWordBytes) {
      put_u32(out.subspan(i).first<kRvlWordBytes>(),
              rvl_turned(get_u32(piece.subspan(i).first<kRvlWordBytes>())));
    }
    std::ranges::fill(out.subspan(piece.size()).first<kAhead>(), std::byte{});
    end_ += piece.size();
  }

  std::span<const std::byte> in_;
  std::size_t begin_ = 0;  // what lies in turned_
  std::size_t end_ = 0;
  std::array<std::byte, kAhead + kPiece + kAhead> turned_{};
};

// Reads numbers, and zeros behind the end, which whole() notices.
class Reader {
 public:
  explicit Reader(Nibbles& nibbles) noexcept : nibbles_(&nibbles) {}

  std::uint32_t next() noexcept {
    refill();
    const std::uint64_t ends = stops() | kLastStop;
    const auto read = static_cast<unsigned>(std::countr_zero(ends)) + 1;
    const std::uint32_t number = joined(static_cast<std::uint32_t>(pending_ & (ends ^ (ends - 1))));
    too_long_ |= read > kRvlNibbleBits * kRvlNumberNibbles;
    drop(read);
    return number;
  }

  // Four differences of up to four nibbles, the first one lowest; false, and nothing is read, if
  // they are not that short.
  [[gnu::always_inline]] bool next_four(std::uint64_t& differences) noexcept {
    refill();
    const std::uint64_t first = stops();
    const std::uint64_t second = first & (first - 1);
    const std::uint64_t third = second & (second - 1);
    const std::uint64_t fourth = third & (third - 1);
    if (fourth == 0) [[unlikely]] {
      return false;
    }
    const std::uint64_t lanes = lane(0) | (lane(std::countr_zero(first) + 1) << kLaneBits) |
                                (lane(std::countr_zero(second) + 1) << (2 * kLaneBits)) |
                                (lane(std::countr_zero(third) + 1) << (3 * kLaneBits));
    const std::uint64_t ends = ~lanes & kGoesOn;
    if (((ends - kLanes) & ~ends & (kLanes << (kLaneBits - 1))) != 0) [[unlikely]] {
      return false;  // a lane without an end
    }
    differences = differences_of(lanes);
    drop(static_cast<unsigned>(std::countr_zero(fourth)) + 1);
    return true;
  }

  // Whether the numbers read were those of the bytes: all of them, and nothing but 0 from there to
  // the end of a word.
  bool whole() noexcept {
    refill();
    const std::size_t read = kByteBits * at_ - bits_;
    const std::size_t all = kByteBits * nibbles_->bytes();
    return !too_long_ && read <= all && all - read < kRvlWordBits && pending_ == 0;
  }

 private:
  // refill() makes sure of so many bits.
  static constexpr unsigned kLeastBits = 56;
  static constexpr std::uint64_t kLastStop = std::uint64_t{1} << (kLeastBits - 1);

  // Every bit 3 that ends a number.
  std::uint64_t stops() const noexcept { return ~pending_ & (kGoesOn >> kByteBits); }

  std::uint64_t lane(int bit) const noexcept { return (pending_ >> bit) & 0xFFFF; }

  void drop(unsigned bits) noexcept {
    pending_ >>= bits;
    bits_ -= bits;
  }

  // What lies above bits_ in pending_ is what follows there, and comes again.
  void refill() noexcept {
    pending_ |= nibbles_->get(at_) << bits_;
    at_ += (63 - bits_) / kByteBits;
    bits_ |= kLeastBits;
  }

  Nibbles* nibbles_;
  std::size_t at_ = 0;         // bytes of it that were loaded whole; may be behind the end
  std::uint64_t pending_ = 0;  // its lowest bits_ bits were loaded and not read
  unsigned bits_ = 0;          // < 64
  bool too_long_ = false;
};

template <typename T>
void read_values(Reader& reader, std::span<T> values, T& last) noexcept {
  Reader local = reader;  // in registers
  T before = last;
  std::size_t i = 0;
  while (i < values.size()) {
    std::uint64_t differences = 0;
    if (i + 4 <= values.size() && local.next_four(differences)) [[likely]] {
      for (unsigned k = 0; k < 4; ++k) {
        before = static_cast<T>(before + (differences >> (kLaneBits * k)));
        values[i + k] = before;
      }
      i += 4;
    } else {
      before = static_cast<T>(before + difference_of(local.next()));
      values[i++] = before;
    }
  }
  reader = local;
  last = before;
}

template <typename T>
Status decode(std::span<const std::byte> in, std::span<T> values) noexcept {
  if (in.size() % kRvlWordBytes != 0) {
    return Status::kCorrupt;
  }
  Nibbles nibbles(in);
  Reader reader(nibbles);
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
    read_values(reader, values.first(others), before);
    values = values.subspan(others);
  }
  return reader.whole() ? Status::kOk : Status::kCorrupt;
}

template <typename T>
STOF_WIRE_AVX2 Status decode_avx2(std::span<const std::byte> in, std::span<T> values) noexcept {
  return decode(in, values);
}

}  // namespace

template <typename T>
Status rvl_decode(std::span<const std::byte> in, std::span<T> values) noexcept {
  return uses_avx2() ? decode_avx2(in, values) : decode(in, values);
}

template Status rvl_decode(std::span<const std::byte>, std::span<std::uint8_t>) noexcept;
template Status rvl_decode(std::span<const std::byte>, std::span<std::uint16_t>) noexcept;

}  // namespace stof::wire
