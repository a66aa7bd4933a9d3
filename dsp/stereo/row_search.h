#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/stereo/cost/candidate_mask.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prepared_pair.h"

// The searches that a Matcher uses. A new way to search is these two classes; pictures, checks,
// fits and filters stay the Matcher's.
namespace stof::dsp {

// In place of a peak ratio that was not computed: neither distinct nor with rivals.
inline constexpr std::uint8_t kRatioUnknown = 128;

// The results of one row. Those that the MatchParams do not ask for are empty.
struct MatchedRow {
  std::span<Disparity> disparity;
  std::span<std::int16_t> margins;  // distinct (validation/winner_margin.h)
  std::span<std::uint8_t> ratio;    // confidence (validation/peak_ratio.h)
};

// Searches rows of a pair; one for each thread.
class RowSearch {
 public:
  // New pictures, which stay as they are until the last row; they are ready when the first row is
  // asked for. guide: of their size, or empty; only where the params are `guided`.
  virtual void start(const PreparedPair& pair, Guide guide) noexcept = 0;
  // Row y with all checks that look at one row. In order rows are cheapest; any order gives the
  // same.
  virtual void match(int y, const MatchedRow& out) noexcept = 0;

 protected:
  ~RowSearch() = default;  // they live in an Arena
};

class SearchMaker {
 public:
  // A search of pictures up to width x height, in the arena; nullptr from one that measures. One
  // call for each thread.
  virtual RowSearch* make(const MatchParams& params, int width, int height,
                          Arena& arena) noexcept = 0;
  // How many rows in a row a thread should search of a picture of this height.
  virtual int rows_at_once(int height) const noexcept = 0;

 protected:
  ~SearchMaker() = default;
};

}  // namespace stof::dsp
