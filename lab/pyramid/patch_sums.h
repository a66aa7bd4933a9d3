#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/image.h"
#include "dsp/base/kernel.h"
#include "dsp/stereo/search/winner.h"

// Winner takes all in a patch of a picture that searches few candidates: the pixels of a row lie
// side by side in a vector, one candidate after the other, so that a patch pays for the candidates
// it has, in any choice, and not for whole vectors of them.
//
// Sums of a patch are laid out [candidate][kPatchColumns]: kPatchSumScale times the sum of absolute
// differences over the block, and in the low three bits the place of the candidate modulo 8: of a
// group of eight the minimum itself tells which one it is, of a tie the first one.
namespace stof::dsp {

inline constexpr int kPatchColumns = 48;
inline constexpr int kPatchSumScale = 8;
// The largest pixel: four differences of differences fit a byte with a sign.
inline constexpr int kLargestPatchPixel = 31;
inline constexpr int kLargestPatchSum = 8190;  // of a block; kPatchSumScale times it fits u16

constexpr bool patch_sums_serve(int block_width, int block_height, int largest_pixel) noexcept {
  return largest_pixel <= kLargestPatchPixel &&
         block_width * block_height * largest_pixel <= kLargestPatchSum;
}
static_assert(patch_sums_serve(16, 16, 30));

// Columns of a row that kernels look at from the first one of a patch on.
constexpr int patch_reach(int block_width) noexcept {
  constexpr int kVector = 64;
  return (kPatchColumns + block_width - 1 + kVector - 1) / kVector * kVector;
}

// Where a patch lies in pictures that were widened, so that all columns it looks at exist: block
// column k of candidate c compares left column left_x + k with right column right_x + k - c.
// Pixels are at most kLargestPatchPixel.
struct PatchPlace {
  ImageView<const std::uint8_t> left;
  ImageView<const std::uint8_t> right;
  int left_x = 0;
  int right_x = 0;
  int block_width = 1;                       // 1..64
  std::span<const std::int16_t> candidates;  // ascending
};

// sums: of the block that these rows of the pictures make; rows beyond the pictures replicate.
using StartPatch = void(const PatchPlace& patch, Rows rows, std::span<std::uint16_t> sums) noexcept;
// Row `entering` enters the block, row `leaving` leaves it.
using SlidePatch = void(const PatchPlace& patch, int entering, int leaving,
                        std::span<std::uint16_t> sums) noexcept;

// Candidate c exists for columns begin + c .. end + c - 1 of the patch.
struct PatchLimits {
  int begin = 0;
  int end = 0;
};
// winners[x] as winners() of winner.h has them, among `candidates`, for at most kPatchColumns.
using FindInPatch = void(std::span<const std::uint16_t> sums,
                         std::span<const std::int16_t> candidates, const PatchLimits& limits,
                         std::span<std::int16_t> winners) noexcept;

// The sums of one candidate, at right columns that ascend with the left ones: where its cost
// (without the scale) is less than `lowest` it becomes the winner. Equal lengths; no overlap.
using OfferToRight = void(std::span<const std::uint16_t> sums, std::int16_t candidate,
                          std::span<std::uint16_t> lowest,
                          std::span<std::int16_t> winners) noexcept;

// Searches every second column of every second row: winners(k, r) is what find_in_patch() would
// have for column 2 k from the sums around row rows.begin + 2 r, of the block rows from
// block_height / 2 above it on. winners: at most kQuarterColumns x kQuarterRows, as high as half of
// `rows`, rounded up.
inline constexpr int kQuarterColumns = kPatchColumns / 2;
inline constexpr int kQuarterRows = 16;
using FindQuarter = void(const PatchPlace& patch, Rows rows, int block_height,
                         const PatchLimits& limits, ImageView<std::int16_t> winners) noexcept;

STOF_KERNEL(StartPatch, start_patch, kAvx2)
STOF_KERNEL(SlidePatch, slide_patch, kAvx2)
STOF_KERNEL(FindInPatch, find_in_patch, kAvx2)
STOF_KERNEL(OfferToRight, offer_to_right, kAvx2)
STOF_KERNEL(FindQuarter, find_quarter, kAvx512)

}  // namespace stof::dsp
