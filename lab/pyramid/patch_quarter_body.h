#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "dsp/base/check.h"
#include "lab/pyramid/patch_quarter_sums_body.h"

// find_quarter() of all variants. Isa: of patch_quarter_boxes_body.h; greater: the larger sums.
namespace stof::dsp::patch_quarter_body {

template <typename Isa, std::size_t kBlock>
class Quarter {
 public:
  Quarter(const PatchPlace& patch, int block_height, Rows rows, const PatchLimits& limits) noexcept
      : sums_(patch, block_height, rows), candidates_(patch.candidates), limits_(limits) {}

  void find(ImageView<std::int16_t> winners) noexcept {
    const bool whole = limits_.begin + candidates_.back() <= 0 &&
                       limits_.end + candidates_.front() >= kPatchColumns;
    for (std::size_t first = 0; first < candidates_.size(); first += AllSums::kGroup) {
      const std::size_t count = std::min(AllSums::kGroup, candidates_.size() - first);
      sums_.start(first, count);
      whole ? follow<false>(winners.height(), first, count)
            : follow<true>(winners.height(), first, count);
    }
    for (int r = 0; r < winners.height(); ++r) {
      write(r, winners.row(r));
    }
  }

 private:
  using AllSums = QuarterSums<Isa, kBlock>;
  using Sums = typename Isa::Sums;
  static constexpr std::size_t kLine = AllSums::kLine;
  static constexpr std::size_t kSums = AllSums::kSums;
  static constexpr auto kNone = static_cast<std::uint16_t>(kNoWinner);

  static Sums nothing() noexcept { return Isa::all(kNoCost<std::uint16_t>); }

  // The lowest and the highest sums of a group.
  struct Best {
    Sums least[AllSums::kOuts];
    Sums most[AllSums::kOuts];
    Best() noexcept {
      std::ranges::fill(least, nothing());
      std::ranges::fill(most, Isa::all(0));
    }
    void add(std::size_t v, Sums low, Sums high) noexcept {
      least[v] = Isa::smaller(least[v], low);
      most[v] = Isa::greater(most[v], high);
    }
  };
  // The best candidates of a row so far.
  struct Row {
    alignas(64) std::uint16_t least[kLine];
    alignas(64) std::uint16_t most[kLine];
    alignas(64) std::uint16_t place[kLine];
  };

  // A group's candidates through all rows of winners.
  template <bool kMasked>
  void follow(int height, std::size_t first, std::size_t count) noexcept {
    for (int r = 0; r < height; ++r) {
      Best best;
      const auto keep = [&](std::size_t i, std::size_t v, Sums sum) noexcept {
        if constexpr (kMasked) {
          const Sums exists = existing(candidates_[first + i], static_cast<int>(v * kSums));
          best.add(v, Isa::select(exists, sum, nothing()), Isa::both(exists, sum));
        } else {
          best.add(v, sum, sum);
        }
      };
      if (r == 0) {
        sums_.tell(count, keep);
      } else {
        sums_.slide(r, first, count, keep);
      }
      offer(best, first, rows_[static_cast<std::size_t>(r)]);
    }
  }

  // To what the groups before left.
  static void offer(const Best& best, std::size_t first, Row& row) noexcept {
    for (std::size_t v = 0; v < AllSums::kOuts; ++v) {
      const std::size_t x = v * kSums;
      const Sums least = best.least[v];
      const Sums here = Isa::add(Isa::low_bits(least), Isa::all(static_cast<std::uint16_t>(first)));
      if (first == 0) {
        Isa::store(row.least + x, least);
        Isa::store(row.most + x, best.most[v]);
        Isa::store(row.place + x, here);
        continue;
      }
      const Sums lowest = Isa::load(row.least + x);
      const Sums better = Isa::less(Isa::eighth(least), Isa::eighth(lowest));
      Isa::store(row.least + x, Isa::select(better, least, lowest));
      Isa::store(row.most + x, Isa::greater(best.most[v], Isa::load(row.most + x)));
      Isa::store(row.place + x, Isa::select(better, here, Isa::load(row.place + x)));
    }
  }

  // In which lanes from x on the candidate exists, for columns twice that.
  Sums existing(int candidate, int x) const noexcept {
    const auto from = [&](int column) noexcept { return ((column + candidate + 1) >> 1) - x; };
    return Isa::between(from(limits_.begin), from(limits_.end));
  }

  void write(int r, std::span<std::int16_t> winners) noexcept {
    Row& row = rows_[static_cast<std::size_t>(r)];
    const int first = candidates_.front();
    const bool gaps = static_cast<int>(candidates_.size()) != candidates_.back() - first + 1;
    for (std::size_t x = 0; x < kLine; x += kSums) {
      const Sums least = Isa::load(row.least + x);
      const Sums most = Isa::load(row.most + x);
      const Sums none = Isa::either(Isa::equal(least, nothing()),
                                    Isa::equal(Isa::eighth(least), Isa::eighth(most)));
      const Sums found = Isa::add(Isa::load(row.place + x),
                                  Isa::all(static_cast<std::uint16_t>(gaps ? 0 : first)));
      Isa::store(row.place + x, Isa::select(none, Isa::all(kNone), found));
    }
    for (std::size_t x = 0; x < winners.size(); ++x) {
      const std::uint16_t place = row.place[x];
      winners[x] = gaps && place != kNone ? candidates_[place] : static_cast<std::int16_t>(place);
    }
  }

  AllSums sums_;
  std::span<const std::int16_t> candidates_;
  PatchLimits limits_;
  Row rows_[kQuarterRows];
};

template <typename Isa>
void find_quarter(const PatchPlace& patch, Rows rows, int block_height, const PatchLimits& limits,
                  ImageView<std::int16_t> winners) noexcept {
  STOF_CHECK(winners.width() <= kQuarterColumns && winners.height() <= kQuarterRows &&
             winners.height() == (rows.count() + 1) / 2);
  patch_sums_body::check_patch(patch);
  if (patch.block_width == 16) {
    Quarter<Isa, 16>(patch, block_height, rows, limits).find(winners);
  } else if (patch.block_width == 15) {
    Quarter<Isa, 15>(patch, block_height, rows, limits).find(winners);
  } else {
    Quarter<Isa, 0>(patch, block_height, rows, limits).find(winners);
  }
}

}  // namespace stof::dsp::patch_quarter_body
