#include "firmware/loop/repeat_detector.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace stof::firmware {
namespace {

constexpr int kComparedRowStep = 16;
// One in so many pixels must have noise.
constexpr std::ptrdiff_t kPixelsForEachNoisy = 64;
// Four sums run side by side, each with its own odd factor.
constexpr std::size_t kLanes = 4;
constexpr std::uint64_t kFactor = 0x9E37'79B9'7F4A'7C15;

std::uint64_t word_at(const std::byte* bytes, std::size_t size) noexcept {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, std::min(size, sizeof word));
  return word;
}

// Each step can be undone: two rows that differ in one word never have the same digest.
constexpr std::uint64_t mix(std::uint64_t digest, std::uint64_t word) noexcept {
  digest = (digest ^ word) * kFactor;
  return digest ^ (digest >> 29U);
}

std::uint64_t digest_row(std::span<const std::byte> row, std::uint64_t seed) noexcept {
  std::uint64_t lanes[kLanes] = {seed, seed + 1, seed + 2, seed + 3};
  std::size_t at = 0;
  for (; at + kLanes * sizeof(std::uint64_t) <= row.size(); at += kLanes * sizeof(std::uint64_t)) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      lanes[lane] = mix(lanes[lane], word_at(&row[at + lane * sizeof(std::uint64_t)], row.size()));
    }
  }
  for (; at < row.size(); at += sizeof(std::uint64_t)) {
    lanes[0] = mix(lanes[0], word_at(&row[at], row.size() - at));
  }
  return mix(mix(mix(lanes[0], lanes[1]), lanes[2]), lanes[3]);
}

}  // namespace

template <typename Pixel>
bool RepeatDetector<Pixel>::repeats(std::span<const dsp::ImageView<const Pixel>> images) noexcept {
  std::uint64_t digest = 0;
  for (const dsp::ImageView<const Pixel>& image : images) {
    for (int y = 0; y < image.height(); y += kComparedRowStep) {
      digest = digest_row(std::as_bytes(image.row(y)), digest);
    }
  }
  const bool same = digest_ == digest;
  digest_ = digest;
  return same && proves(images);
}

template <typename Pixel>
bool RepeatDetector<Pixel>::proves(
    std::span<const dsp::ImageView<const Pixel>> images) const noexcept {
  std::ptrdiff_t noisy = 0;
  std::ptrdiff_t all = 0;
  for (const dsp::ImageView<const Pixel>& image : images) {
    for (int y = 0; y < image.height(); y += kComparedRowStep) {
      noisy += std::ranges::count_if(
          image.row(y), [this](Pixel value) { return value > dark_ && value < bright_; });
      all += image.width();
    }
  }
  return noisy * kPixelsForEachNoisy >= all && noisy > 0;
}

template class RepeatDetector<std::uint8_t>;
template class RepeatDetector<std::uint16_t>;

}  // namespace stof::firmware
