#include "lab/pyramid/patch_candidates.h"

#include <algorithm>

#include "lab/pyramid/patch_sums.h"

namespace stof::lab {
namespace {

// Around twice what the coarser size found: the halves that it rounded.
constexpr int kMargin = 1;
// The surroundings of a patch, in pixels of the coarser size: what a block of 16 px around its last
// pixels still meets.
constexpr int kReach = 4;
// A candidate that, with its two neighbours, fewer of the surroundings found is an error.
constexpr int kShare = 24;

// Which candidates the surroundings of a patch of the finer size found; none: no information.
class Surroundings {
 public:
  Surroundings(const CoarseWinners& coarse, int x, Rows rows) noexcept
      : disparities_(coarse.disparities) {
    const ImageView<const std::int16_t> map = coarse.winners;
    const auto at = [&](int pixel) noexcept {
      return (std::max(pixel, 0) + coarse.step - 1) / coarse.step;
    };
    const int first_x = at(x / 2 - kReach);
    const int end_x = std::min(at((x + kPatchColumns - 1) / 2 + kReach + 1), map.width());
    const int first_y = at(rows.begin / 2 - kReach);
    const int end_y = std::min(at((rows.end - 1) / 2 + kReach + 1), map.height());
    for (int y = first_y; y < end_y; ++y) {
      count(map.row(y).subspan(static_cast<std::size_t>(first_x),
                               static_cast<std::size_t>(end_x - first_x)));
    }
    for (std::size_t k = 1; k < kCounters; ++k) {
      for (std::size_t i = 0; i <= static_cast<std::size_t>(disparities_); ++i) {
        counts_[0][i] = static_cast<std::uint16_t>(counts_[0][i] + counts_[k][i]);
      }
    }
    const int pixels = (end_x - first_x) * (end_y - first_y) - counts_[0][0];
    counts_[0][0] = 0;
    needed_ = std::max(pixels / kShare, 1);
  }

  bool hold(int candidate) const noexcept {
    const std::size_t at = static_cast<std::size_t>(candidate) + 1;
    const auto& found = counts_[0];
    return found[at] > 0 && found[at - 1] + found[at] + found[at + 1] >= needed_;
  }

 private:
  // Equal neighbours count in different places: none waits for the one before.
  static constexpr std::size_t kCounters = 4;

  void count(std::span<const std::int16_t> winners) noexcept {
    for (std::size_t x = 0; x < winners.size(); ++x) {
      ++counts_[x % kCounters][static_cast<std::size_t>(winners[x] + 1)];
    }
  }

  int disparities_;
  int needed_ = 1;
  std::array<std::array<std::uint16_t, kMaxDisparities + 2>, kCounters>
      counts_{};  // [candidate + 1]
};

}  // namespace

void CandidateList::append(int first, int last) noexcept {
  if (count > 0) {
    first = std::max(first, numbers[count - 1] + 1);
  }
  for (int i = first; i <= last; ++i) {
    numbers[count++] = static_cast<std::int16_t>(i);
  }
}

CandidateRange range_around(const CoarseWinners& coarse, const MatchParams& fine, int x,
                            Rows rows) noexcept {
  const Surroundings around(coarse, x, rows);
  int lowest = kMaxDisparities;
  int highest = -1;
  for (int i = 0; i < coarse.disparities; ++i) {
    if (around.hold(i)) {
      lowest = std::min(lowest, i);
      highest = i;
    }
  }
  const int all = lanes_of(fine);
  if (highest < 0) {
    return {0, all};
  }
  const int offset = 2 * coarse.min_disparity - fine.min_disparity;
  const int first = std::clamp(2 * lowest + offset - kMargin, 0, fine.disparities - 1);
  const int last = std::clamp(2 * highest + offset + kMargin, first, fine.disparities - 1);
  // Whole vectors search more for the same price: to either side.
  const int lanes = (last - first + kCostLanes) / kCostLanes * kCostLanes;
  return {std::clamp(first - (lanes - 1 - (last - first)) / 2, 0, all - lanes), lanes};
}

CandidateList list_around(const CoarseWinners& coarse, const MatchParams& fine, int x,
                          Rows rows) noexcept {
  const Surroundings around(coarse, x, rows);
  const int offset = 2 * coarse.min_disparity - fine.min_disparity;
  CandidateList list;
  for (int i = 0; i < coarse.disparities; ++i) {
    if (around.hold(i)) {
      list.append(std::max(2 * i + offset - kMargin, 0),
                  std::min(2 * i + offset + kMargin, fine.disparities - 1));
    }
  }
  if (list.count == 0) {
    list.append(0, fine.disparities - 1);
  }
  return list;
}

}  // namespace stof::lab
