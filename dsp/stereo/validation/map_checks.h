#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/thread_team.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prepared_pair.h"
#include "dsp/stereo/validation/speckle.h"
#include "dsp/stereo/validation/window_sums.h"

namespace stof::dsp {

// Checks of a whole map: drops disparities that disagree with their neighbourhood, then takes the
// median. Holds its buffers, allocates nothing; the result is the same with any team.
class MapChecks {
 public:
  // margins: the search's, for distinctness (validation/winner_margin.h), width x height; else
  // empty. apply() overwrites them.
  MapChecks(const MatchParams& params, int width, int height, ImageView<std::int16_t> margins,
            Arena& arena, const ThreadTeam& team) noexcept;

  // The size of the next map, at most the constructor's.
  void start(int width, int height) noexcept;
  // map: of that size, not empty, searched in `pair`.
  void apply(const PreparedPair& pair, ImageView<Disparity> map) noexcept;

  // The disparities dropped from the last map, where MatchParams ask for `confidence`; else empty.
  ImageView<const Disparity> weak() const noexcept;

 private:
  void drop_by_surroundings(const PreparedPair& pair, ImageView<Disparity> map) noexcept;
  void drop_specks(ImageView<Disparity> map) noexcept;
  void keep_weak(ImageView<const Disparity> map) noexcept;
  template <typename Job>
  void by_rows(Job&& job) const noexcept;

  MatchParams params_;
  ThreadTeam team_;
  int width_ = 0;
  int height_ = 0;
  ImageView<std::int16_t> margins_;
  ImageView<Disparity> spare_;  // the map before a check or the median
  ImageView<Disparity> weak_;
  std::array<WindowSums, ThreadTeam::kMost> windows_{};  // one for each thread
  std::span<std::uint32_t> counts_;
  std::array<SpeckleScratch, 2> speckles_{};  // of the map, and of what it was before
};

}  // namespace stof::dsp
