#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"
#include "lab/pyramid/patch_search.h"
#include "lab/pyramid/patch_sums.h"

namespace stof::lab {

// PatchSearch for derivatives of few values (patch_sums.h) and patches that search few candidates,
// in any choice: several times as fast.
class PatchStrips {
 public:
  static constexpr int kPatchHeight = 32;  // rows; search() takes any number without right winners

  static constexpr int patches(int width) noexcept {
    return (width + kPatchColumns - 1) / kPatchColumns;
  }
  // Whether block and prefilter_cap allow it.
  static bool serves(const MatchParams& params) noexcept;

  // As those of PatchSearch.
  PatchStrips(const MatchParams& params, bool check, int width, int height, Arena& arena) noexcept;
  // Values stay below 2 prefilter_cap + 1.
  void start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) noexcept;

  // Fills `rows` of patch t of out, which searches these candidates only (ascending, at least one).
  // Where right winners are wanted, patches of the same rows follow each other from t = 0 on.
  void search(Rows rows, int t, std::span<const std::int16_t> candidates,
              const PatchWinners& out) noexcept;
  // The same for every second column of every second row: out holds those alone.
  void search_quarter(Rows rows, int t, std::span<const std::int16_t> candidates,
                      ImageView<std::int16_t> out) const noexcept;

 private:
  PatchPlace place_of(int t, std::span<const std::int16_t> candidates) const noexcept;
  PatchLimits limits_of(int t) const noexcept;
  void find_right(int x, int width, std::span<const std::int16_t> candidates,
                  std::span<std::uint16_t> lowest, std::span<std::int16_t> winners) const noexcept;

  int width_;
  int min_disparity_;
  int disparities_;
  int block_width_;
  int block_height_;
  ImageView<std::uint8_t> left_;   // widened
  ImageView<std::uint8_t> right_;  // and by the candidates
  std::span<std::uint16_t> sums_;
  ImageView<std::uint16_t> lowest_;  // of the right pixels of the rows at work
};

}  // namespace stof::lab
