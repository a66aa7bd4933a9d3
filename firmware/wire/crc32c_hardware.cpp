#include "firmware/wire/crc32c_hardware.h"

#include <array>
#include <cstring>

#if defined(__aarch64__)
#include <sys/auxv.h>
#endif

// Three sequences at once: the instruction takes three cycles, and one begins in every cycle. Each
// sequence's CRC is then moved by the length of what follows it, and they are added.
namespace stof::wire::hardware {
namespace {

constexpr std::uint32_t kPolynomial = 0x82F63B78;
constexpr std::size_t kStep = 8;
constexpr std::size_t kNibbles = 8;
constexpr std::size_t kLong = 336;  // three of them and little more are a full datagram
constexpr std::size_t kShort = 64;

// shift[k][n]: what nibble k of a CRC becomes behind so many zeros.
using Shift = std::array<std::array<std::uint32_t, 16>, kNibbles>;

constexpr Shift make_shift(std::size_t bytes) noexcept {
  std::array<std::uint32_t, 32> single{};  // of one bit
  for (std::size_t bit = 0; bit < single.size(); ++bit) {
    std::uint32_t crc = std::uint32_t{1} << bit;
    for (std::size_t i = 0; i < 8 * bytes; ++i) {
      crc = (crc >> 1) ^ ((crc & 1) != 0 ? kPolynomial : 0);
    }
    single[bit] = crc;
  }
  Shift shift{};
  for (std::size_t k = 0; k < kNibbles; ++k) {
    for (std::size_t n = 0; n < 16; ++n) {
      for (std::size_t bit = 0; bit < 4; ++bit) {
        shift[k][n] ^= ((n >> bit) & 1) != 0 ? single[4 * k + bit] : 0;
      }
    }
  }
  return shift;
}
constexpr Shift kLongShift = make_shift(kLong);
constexpr Shift kShortShift = make_shift(kShort);

std::uint32_t moved(const Shift& shift, std::uint32_t crc) noexcept {
  std::uint32_t sum = 0;
  for (std::size_t k = 0; k < kNibbles; ++k) {
    sum ^= shift[k][(crc >> (4 * k)) & 15U];
  }
  return sum;
}

// One instruction, by its name: this file is compiled for processors without it.
std::uint32_t add8(std::uint32_t crc, const std::byte* at) noexcept {
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, at, sizeof bytes);
#if defined(__x86_64__)
  std::uint64_t wide = crc;  // NOLINT(misc-const-correctness): the instruction writes it
  asm("crc32q %1, %0" : "+r"(wide) : "r"(bytes));
  return static_cast<std::uint32_t>(wide);
#elif defined(__aarch64__)
  asm(".arch_extension crc\n\tcrc32cx %w0, %w0, %x1" : "+r"(crc) : "r"(bytes));
  return crc;
#else
  return crc;
#endif
}
std::uint32_t add1(std::uint32_t crc, std::byte byte) noexcept {
  const auto value = std::to_integer<std::uint32_t>(byte);
#if defined(__x86_64__)
  asm("crc32b %b1, %0" : "+r"(crc) : "q"(value));
#elif defined(__aarch64__)
  asm(".arch_extension crc\n\tcrc32cb %w0, %w0, %w1" : "+r"(crc) : "r"(value));
#else
  static_cast<void>(value);
#endif
  return crc;
}

// All thirds of `third` bytes each; `bytes` becomes what is left.
std::uint32_t add_thirds(std::uint32_t crc, std::size_t third, const Shift& shift,
                         std::span<const std::byte>& bytes) noexcept {
  while (bytes.size() >= 3 * third) {
    const std::byte* const at = bytes.data();
    std::uint32_t second = 0;
    std::uint32_t last = 0;
    for (std::size_t i = 0; i < third; i += kStep) {
      crc = add8(crc, at + i);
      second = add8(second, at + third + i);
      last = add8(last, at + 2 * third + i);
    }
    crc = moved(shift, moved(shift, crc) ^ second) ^ last;
    bytes = bytes.subspan(3 * third);
  }
  return crc;
}

}  // namespace

bool available() noexcept {
#if defined(__x86_64__)
  return __builtin_cpu_supports("sse4.2") != 0;
#elif defined(__aarch64__)
  constexpr unsigned long kCrc32 = 1UL << 7;  // HWCAP_CRC32 of Linux
  return (getauxval(AT_HWCAP) & kCrc32) != 0;
#else
  return false;
#endif
}

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) noexcept {
  std::uint32_t crc = ~before;
  crc = add_thirds(crc, kLong, kLongShift, bytes);
  crc = add_thirds(crc, kShort, kShortShift, bytes);
  while (bytes.size() >= kStep) {
    crc = add8(crc, bytes.data());
    bytes = bytes.subspan(kStep);
  }
  for (const std::byte byte : bytes) {
    crc = add1(crc, byte);
  }
  return ~crc;
}

}  // namespace stof::wire::hardware
