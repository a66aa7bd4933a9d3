#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/cost/candidate_mask.h"
#include "dsp/stereo/cost/cost_source.h"
#include "dsp/stereo/search/edge_penalties.h"

namespace stof::dsp {

template <typename Cost>
struct PathParams {
  int directions = 4;  // 2: along the row; 4: and columns; 5: and downwards diagonals, not upwards;
                       // 8: all
  int lanes = 64;      // a multiple of 16, at most 256
  bool guided = false;  // start() may be given a guide
  EdgePenalties<Cost> penalties;
};

// Semi-global optimisation: for each pixel and candidate the sum, over several directions, of the
// lowest cost of a path that ends there. Source: Hirschmueller 2008, section 2.3.
//
// No volume of costs is kept. The picture is worked on in stripes of kStripe rows; paths that cross
// rows begin kApproach rows outside of a stripe, which is further than a path remembers (measured:
// no pixel in a thousand changes against whole columns). A stripe depends on nothing but the
// picture, so that rows may be asked for in any order, and by several threads, one object each.
template <typename Cost, typename Sum>
class SemiGlobal {
 public:
  static constexpr int kStripe = 32;
  static constexpr int kApproach = 16;

  static constexpr bool valid(int directions) noexcept {
    return directions == 2 || directions == 4 || directions == 5 || directions == 8;
  }
  // Costs plus penalties.large stay below 8192 (u16); costs plus twice that below 255 (u8 costs),
  // and all paths together below 255 (u8 sums).
  SemiGlobal(const PathParams<Cost>& params, int width, Arena& arena) noexcept;

  // A new picture: grey gives edges, size at most the constructor's width. guide: of its size, or
  // empty; paths then run through mask_candidates() of the costs. A path that comes to a pixel
  // whose candidates are none of its own jumps.
  void start(ImageView<const std::uint8_t> grey, CostSource<Cost>& costs,
             Guide guide = {}) noexcept;
  // Row y of sums, width * lanes; valid, and the caller's, until the next call. Consecutive rows
  // are cheapest; a row before the last one, or the same again, costs a stripe. Candidates that the
  // costs mark as outside are kNoCost in u8 sums and mean nothing in others.
  std::span<Sum> sums(int y) noexcept;
  // The costs of the row that was asked for last, not masked.
  std::span<const Cost> costs(int y) const noexcept { return kept(y); }

 private:
  // Costs of a stripe and of the rows its upward paths begin in. The rows its downward paths begin
  // in belong to the stripe before, which takes these paths along.
  static constexpr int kKept = kStripe + kApproach;
  static constexpr int kMostShifts = 3;
  static constexpr std::array<int, kMostShifts> kShifts{0, -1, 1};  // the straight one first
  // Along the row and straight across: both at once, summed in place.
  static constexpr bool kInPlace = std::is_same_v<Cost, Sum>;

  // Paths that come from the row before, of one of the shifts -1, 0, 1.
  struct Front {
    std::span<Cost> paths;
    std::span<Cost> next;  // empty for the straight one, which works in place
  };
  using Fronts = std::array<Front, kMostShifts>;

  static constexpr int shifts_down(int directions) noexcept {
    if (directions == 2) {
      return 0;
    }
    return directions == 4 ? 1 : 3;
  }
  static constexpr int shifts_up(int directions) noexcept {
    return directions == 5 ? 0 : shifts_down(directions);
  }
  // Buffers for one row at a time.
  struct RowBuffers {
    std::span<Cost> from_left;
    std::span<Cost> from_right;
    std::span<Cost> large;   // along the row, width + 1
    std::span<Cost> across;  // across rows
    std::span<Cost> masked;
    std::span<Sum> sums;
  };

  static Fronts take_fronts(int shifts, std::size_t row, Arena& arena) noexcept;
  bool in_place() const noexcept { return kInPlace && params_.directions == 4; }
  int row_size() const noexcept { return grey_.width() * params_.lanes; }
  std::span<Cost> kept(int y) const noexcept;
  std::span<Cost> stored(int shift, int y) const noexcept;
  std::span<const Cost> path_costs(int y) noexcept;
  void keep_costs(Rows rows) noexcept;
  void open_stripe(int stripe) noexcept;
  void climb(Rows rows) noexcept;
  void go_down(int y) noexcept;
  void go_ahead(int y) noexcept;
  void advance(int y, int from, int shifts, Fronts& fronts) noexcept;
  std::span<const Cost> across(int y, int from, int shift) noexcept;
  void sum_axes(int y, int from, bool from_left, Front& front, std::span<const Cost> others,
                std::span<Cost> sums) noexcept;
  std::span<Sum> sum_row(int y) noexcept;

  PathParams<Cost> params_;
  int down_;  // how many shifts downwards, and upwards
  int up_;
  std::span<Cost> costs_;  // kKept rows
  // Upward paths of the stripe, up_ x kStripe rows; with in_place() summed with those from the
  // right, and at last with all others.
  std::span<Cost> upwards_;
  Fronts downward_;
  Fronts ahead_;  // downward paths towards the next stripe; before those, upward ones
  RowBuffers row_;

  ImageView<const std::uint8_t> grey_;
  CostSource<Cost>* source_ = nullptr;
  Guide guide_;
  Rows kept_;  // rows whose costs are in costs_
  int stripe_ = -1;
  int done_ = 0;  // the row whose downward paths are in downward_, the last that was asked for
};

// The appliance's. The others are made of semi_global_body.h where they are needed.
extern template class SemiGlobal<std::uint8_t, std::uint8_t>;

}  // namespace stof::dsp
