#include "dsp/pmd/reading_memory.h"

#include <algorithm>

#include "dsp/base/index.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {
namespace {

constexpr int kChangedPixels = 2;  // one may change by chance

int cells(int size) noexcept { return (size + ReadingMemory::kCell - 1) / ReadingMemory::kCell; }

template <typename T>
void fill(const ImageView<T>& image, T value) noexcept {
  for (int y = 0; y < image.height(); ++y) {
    std::ranges::fill(image.row(y), value);
  }
}

}  // namespace

ReadingMemory::ReadingMemory(int width, int height, std::uint32_t ratio_q16, Arena& arena) noexcept
    : least_ratio_(static_cast<int>(ratio_q16 / 512 * 5 / 8)),
      distance_(arena.take_image<QuarterMm>(width, height)),
      offset_(arena.take_image<std::uint16_t>(width, height)),
      changed_(arena.take<std::uint8_t>(index(width))),
      standing_(arena.take<std::uint8_t>(index(width))),
      admitted_(arena.take<std::uint8_t>(index(width))),
      changes_(arena.take_image<std::uint8_t>(cells(width), cells(height))),
      quiet_(arena.take_image<std::uint8_t>(cells(width), cells(height))) {
  if (!arena.is_measuring()) {
    fill(offset_, std::uint16_t{0});
    forget();
  }
}

void ReadingMemory::forget() noexcept {
  fill(distance_, kNoDepth);
  fill(changes_, std::uint8_t{0});
  fill(quiet_, std::uint8_t{0});
}

void ReadingMemory::begin_frame() noexcept {
  for (int y = 0; y < quiet_.height(); ++y) {
    for (int x = 0; x < quiet_.width(); ++x) {
      quiet_.at(x, y) = static_cast<std::uint8_t>(std::min(quiet_.at(x, y) + 1, kQuietFrames));
    }
  }
  for (int y = 0; y < changes_.height(); ++y) {
    for (int x = 0; x < changes_.width(); ++x) {
      if (changes_.at(x, y) < kChangedPixels) {
        continue;
      }
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, quiet_.height() - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, quiet_.width() - 1); ++u) {
          quiet_.at(u, v) = 0;
        }
      }
    }
  }
  fill(changes_, std::uint8_t{0});
}

// Loops without branches over spans that no store can change: vectors.
void ReadingMemory::admit(int y, std::span<const std::uint8_t> ratio,
                          std::span<const std::uint16_t> offset,
                          std::span<std::uint8_t> flags) noexcept {
  const std::size_t n = flags.size();
  const std::span<const QuarterMm> before = distance_.row(y);
  const std::span<std::uint16_t> offset_before = offset_.row(y);
  const std::span<std::uint8_t> changed = changed_;
  const std::span<std::uint8_t> standing = standing_;
  const std::span<std::uint8_t> admitted = admitted_;
  for (std::size_t x = 0; x < n; ++x) {
    const std::uint16_t now = offset[x];
    const std::uint16_t then = offset_before[x];
    const std::uint16_t apart = static_cast<std::uint16_t>(now > then ? now - then : then - now);
    const std::uint16_t most = static_cast<std::uint16_t>(now / 16 + 3);
    changed[x] = apart > most ? 1 : 0;
    offset_before[x] = now;
  }
  count_changes(y);
  unsigned some = 0;
  const unsigned least = static_cast<unsigned>(least_ratio_);
  for (std::size_t x = 0; x < n; ++x) {
    const unsigned low = flags[x] / unsigned{kPmdLowRatio} % 2;
    const unsigned was = before[x] != kNoDepth ? 1 : 0;
    const unsigned enough = ratio[x] >= least ? 1 : 0;
    const unsigned admits = low & was & enough & standing[x] & (changed[x] ^ 1U);
    admitted[x] = static_cast<std::uint8_t>(admits);
    flags[x] = static_cast<std::uint8_t>(flags[x] ^ (admits * kPmdLowRatio));
    some |= admits;
  }
  admits_ = some != 0;
}

// By cells: adds the row's changes, and tells which pixels of it may stay.
void ReadingMemory::count_changes(int y) noexcept {
  const std::span<const std::uint8_t> quiet = quiet_.row(y / kCell);
  const std::span<std::uint8_t> changes = changes_.row(y / kCell);
  const std::size_t n = changed_.size();
  for (std::size_t cell = 0; cell < changes.size(); ++cell) {
    const std::size_t begin = cell * kCell;
    const std::size_t end = std::min(begin + kCell, n);
    unsigned count = changes[cell];
    const std::uint8_t stands = quiet[cell] >= kQuietFrames ? 1 : 0;
    for (std::size_t x = begin; x < end; ++x) {
      count += changed_[x];
      standing_[x] = stands;
    }
    changes[cell] = static_cast<std::uint8_t>(count);
  }
}

void ReadingMemory::settle(int y, std::span<std::uint8_t> flags, std::span<QuarterMm> distance,
                           std::span<QuarterMm> sigma) noexcept {
  const std::span<QuarterMm> before = distance_.row(y);
  const std::span<const std::uint8_t> admitted = admitted_;
  for (std::size_t x = 0; admits_ && x < flags.size(); ++x) {
    if (admitted[x] != 0 && !is_same_reading(distance[x], sigma[x], before[x])) {
      flags[x] = static_cast<std::uint8_t>(flags[x] | unsigned{kPmdLowRatio});
      distance[x] = kNoDepth;
      sigma[x] = 0;
    }
  }
  std::ranges::copy(distance, before.begin());
}

}  // namespace stof::dsp
