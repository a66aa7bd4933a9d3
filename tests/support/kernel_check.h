#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "dsp/base/image.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

// Every program of label `kernel` runs all of its tests once at each level of dsp/base/target.h
// that the processor has, the reference included (kernel_check.cpp holds its main): a test calls
// best:: and names no level. check_kernel() compares all levels with the reference at once.
//   STOF_KERNEL_TIMES=1 build/emu/tests/phase_test     ends with the time of each kernel at each
//   level
namespace stof::test {

// Around every width of vector, and one that is none of them.
inline constexpr std::array<std::size_t, 20> kHostileLengths{
    0, 1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 32, 33, 47, 63, 64, 65, 67, 71, 130};

// What one call reads and writes: arrays that end at an unreadable page, with the same contents
// at every level.
class KernelCase {
 public:
  // How random numbers are drawn: of a whole range, or of its ends.
  enum class Draw : std::uint8_t { kAny, kEnds, kLowest, kHighest };

  KernelCase(std::size_t length, std::uint64_t seed, Draw draw, bool timed)
      : length_(length), draw_(draw), timed_(timed), random_(seed) {}

  std::size_t length() const { return length_; }
  Random& random() { return random_; }

  // n elements; any bytes, or values of a range.
  template <typename T>
  std::span<T> array(std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    GuardedBuffer<std::byte>& bytes = buffers_.emplace_back(n * sizeof(T));
    random_.fill(std::span(reinterpret_cast<std::uint8_t*>(bytes.span().data()), bytes.size()));
    return {reinterpret_cast<T*>(bytes.span().data()), n};
  }
  template <typename T>
  std::span<T> array(std::size_t n, int low, int high) {
    const std::span<T> out = array<T>(n);
    fill(out, low, high);
    return out;
  }
  // Rows with gaps of some length between them, which are compared too.
  template <typename T>
  dsp::ImageView<T> image(int width, int height) {
    const int stride = width + random_.between(0, 3);
    const int elements = height == 0 ? 0 : (height - 1) * stride + width;
    return {array<T>(static_cast<std::size_t>(elements)).data(), width, height, stride};
  }
  template <typename T>
  void fill(std::span<T> out, int low, int high) {
    for (T& value : out) {
      value = static_cast<T>(draw(low, high));
    }
  }
  int draw(int low, int high) {
    const bool end = draw_ == Draw::kHighest || (draw_ == Draw::kEnds && (random_.next() & 1) != 0);
    if (draw_ == Draw::kAny) {
      return random_.between(low, high);
    }
    return end ? high : low;
  }

  // Calls the kernel. Only what happens here is timed.
  void run(const std::function<void()>& kernel);

  // For check_kernel().
  std::size_t arrays() const { return buffers_.size(); }
  std::span<const std::byte> bytes(std::size_t k) const { return buffers_[k].span(); }
  bool changed(std::size_t k) const;
  double nanoseconds() const { return nanoseconds_; }

 private:
  std::size_t length_;
  Draw draw_;
  bool timed_;
  Random random_;
  std::vector<GuardedBuffer<std::byte>> buffers_;
  std::vector<std::vector<std::byte>> before_;  // the first run
  double nanoseconds_ = 0;
};

// Runs `body` with the reference and with each other level, on the same contents: every length,
// every way to draw. Expects the same bytes in every array. Does so, and returns true, in the first
// of the program's runs that is not the reference's. The longest length is timed in all of them.
using KernelBody = std::function<void(KernelCase&)>;
bool check_kernel(std::span<const std::size_t> lengths, const KernelBody& body);
inline bool check_kernel(const KernelBody& body) { return check_kernel(kHostileLengths, body); }
// Where the body chooses its own sizes from random(): `rounds` of them.
bool check_kernel_rounds(std::size_t rounds, const KernelBody& body);

}  // namespace stof::test
