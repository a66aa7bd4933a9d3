#include "dsp/fusion/settle.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {
namespace {

DepthInterval interval_at(const DisparityTable& table, std::size_t /*x*/, int raw,
                          int half) noexcept {
  return table.at(raw, half);
}
DepthInterval interval_at(const ColumnTables& tables, std::size_t x, int raw, int half) noexcept {
  return ref::column_interval_at(x, raw, half, tables);
}

struct Range {
  int low = 1;
  int high = 0;
  bool empty() const noexcept { return low > high; }
};

Range common(const Range& a, const Range& b) noexcept {
  return {std::max(a.low, b.low), std::min(a.high, b.high)};
}

// Whether a pixel has yet to be settled.
bool open_at(const FusedRow& out, std::size_t x) noexcept {
  return out.source[x] == Source::kPmd ||
         (out.source[x] == Source::kConflict && out.cause[x] == Cause::kMixedPixel);
}

// The nearest matches of a pixel in its row. Asked for ascending pixels.
class Neighbours {
 public:
  // with_weak: weak matches that the PMD confirmed are neighbours too.
  Neighbours(const SettleRow& row, const FusedRow& out, bool with_weak) noexcept
      : row_(row), out_(out), with_weak_(with_weak) {}

  // x is no place to settle: it may be a neighbour of those behind it.
  void pass(std::size_t x) noexcept {
    if (const Disparity match = match_at(x); match.valid()) {
      left_ = match;
      left_at_ = x;
    }
  }
  void stand_at(std::size_t x) noexcept {
    if (right_at_ > x) {
      return;
    }
    right_ = Disparity::none();
    for (right_at_ = x + 1; right_at_ < row_.disparity.size(); ++right_at_) {
      right_ = match_at(right_at_);
      if (right_.valid()) {
        return;
      }
    }
  }
  Disparity left() const noexcept { return left_; }
  Disparity right() const noexcept { return right_; }
  int to_left(std::size_t x) const noexcept { return static_cast<int>(x - left_at_); }
  int to_right(std::size_t x) const noexcept { return static_cast<int>(right_at_ - x); }

 private:
  Disparity match_at(std::size_t x) const noexcept {
    const Source source = out_.source[x];
    if (row_.disparity[x].valid()) {
      const bool published = source == Source::kStereo || source == Source::kBoth ||
                             (source == Source::kResolved && out_.cause[x] == Cause::kMixedPixel);
      return published && row_.support.ratio[x] < kSureRatio ? row_.disparity[x]
                                                             : Disparity::none();
    }
    return with_weak_ && source == Source::kBoth ? row_.weak[x] : Disparity::none();
  }

  const SettleRow& row_;
  const FusedRow& out_;
  bool with_weak_;
  Disparity left_;
  Disparity right_;
  std::size_t left_at_ = 0;
  std::size_t right_at_ = 0;
};

template <typename Table>
class Settler {
 public:
  Settler(const SettleRow& row, const SettleParams& params, const Table& table,
          const FusedRow& out) noexcept
      : row_(row), params_(params), table_(table), out_(out) {}

  void run() noexcept {
    each_open(false, [this](std::size_t x, const Neighbours& near) noexcept {
      if (!in_shadow(x, near)) {
        confirm_weak(x);
      }
    });
    each_open(true, [this](std::size_t x, const Neighbours& near) noexcept {
      if (!between(x, near)) {
        either_side(x, near);
      }
    });
    for (std::size_t x = 0; params_.pmd_range != 0 && x < row_.disparity.size(); ++x) {
      if (out_.source[x] == Source::kConflict && differs_by_a_range(x)) {
        out_.cause[x] = Cause::kRangeAmbiguous;
      }
    }
  }

 private:
  Range pmd(std::size_t x) const noexcept {
    return {std::max<int>(row_.pmd.low[x], 1), std::min<int>(row_.pmd.high[x], params_.max_range)};
  }

  bool publish(std::size_t x, int raw, Source source, Cause cause) noexcept {
    const int half =
        std::clamp((raw - params_.infinity_raw) / kSettledShare, int{Disparity::kOne}, kMostSpread);
    const DepthInterval surface = interval_at(table_, x, raw, half);
    const Range both = common({std::max<int>(surface.low, 1), surface.high}, pmd(x));
    if (both.empty()) {
      return false;
    }
    out_.depth[x] = middle_of(both.low, both.high);
    out_.width[x] = width_of(both.low, both.high);
    out_.source[x] = source;
    out_.cause[x] = cause;
    return true;
  }

  template <typename Settle>
  void each_open(bool with_weak, Settle settle) noexcept {
    Neighbours near(row_, out_, with_weak);
    for (std::size_t x = 0; x < row_.disparity.size(); ++x) {
      if (open_at(out_, x)) {
        near.stand_at(x);
        settle(x, near);
      } else {
        near.pass(x);
      }
    }
  }

  bool in_shadow(std::size_t x, const Neighbours& near) noexcept {
    if (!near.right().valid()) {
      return false;
    }
    const int margin = kShadowMargin * Disparity::kOne;
    if (!near.left().valid()) {
      return static_cast<int>(std::min<std::size_t>(x, kMaxImageWidth)) * Disparity::kOne <=
                 near.right().raw + margin &&
             publish(x, near.right().raw, Source::kResolved, Cause::kOccluded);
    }
    const int step = near.right().raw - near.left().raw;
    return step >= kSurfaceStep && near.to_right(x) * Disparity::kOne <= step + margin &&
           publish(x, near.left().raw, Source::kResolved, Cause::kOccluded);
  }

  void confirm_weak(std::size_t x) noexcept {
    if (!row_.weak.empty() && row_.weak[x].valid() && !row_.disparity[x].valid()) {
      publish(x, row_.weak[x].raw, Source::kBoth, Cause::kNone);
    }
  }

  bool between(std::size_t x, const Neighbours& near) noexcept {
    const int step = near.right().raw - near.left().raw;
    if (!near.left().valid() || !near.right().valid() || std::abs(step) >= kSurfaceStep) {
      return false;
    }
    const int raw = near.left().raw + step * near.to_left(x) / (near.to_left(x) + near.to_right(x));
    return publish(x, raw, Source::kResolved, Cause::kStereoAmbiguous);
  }

  bool one_side(std::size_t x, Disparity match, int away) noexcept {
    return match.valid() && away <= params_.reach_px &&
           publish(x, match.raw, Source::kResolved, Cause::kMixedPixel);
  }

  void either_side(std::size_t x, const Neighbours& near) noexcept {
    if ((row_.support.pmd_flags[x] & kPmdEdge) == 0) {
      return;
    }
    const int left = near.to_left(x);
    const int right = near.to_right(x);
    const bool left_first = near.left().valid() && (!near.right().valid() || left <= right);
    if (left_first) {
      if (!one_side(x, near.left(), left)) {
        one_side(x, near.right(), right);
      }
    } else if (!one_side(x, near.right(), right)) {
      one_side(x, near.left(), left);
    }
  }

  bool differs_by_a_range(std::size_t x) const noexcept {
    const int range = params_.pmd_range;
    if (range == 0) {
      return false;
    }
    const Range stereo{std::max<int>(row_.stereo.low[x], 1),
                       std::min<int>(row_.stereo.high[x], params_.max_range)};
    const Range here = pmd(x);
    const int less = range - range / 16;
    return !common(stereo, {here.low + less, here.high + range}).empty() ||
           !common(stereo, {here.low - range, here.high - less}).empty();
  }

  const SettleRow& row_;
  const SettleParams& params_;
  const Table& table_;
  const FusedRow& out_;
};

template <typename Table>
void settle(const SettleRow& row, const SettleParams& params, const Table& table,
            const FusedRow& out) noexcept {
  const std::size_t n = row.disparity.size();
  STOF_CHECK(row.weak.empty() || row.weak.size() == n);
  STOF_CHECK(row.stereo.low.size() == n && row.stereo.high.size() == n);
  STOF_CHECK(row.pmd.low.size() == n && row.pmd.high.size() == n);
  STOF_CHECK(row.support.ratio.size() == n && row.support.pmd_flags.size() == n);
  STOF_CHECK(out.depth.size() == n && out.width.size() == n && out.source.size() == n &&
             out.cause.size() == n);
  Settler(row, params, table, out).run();
}

}  // namespace

void settle_row(const SettleRow& row, const SettleParams& params, const DisparityTable& table,
                const FusedRow& out) noexcept {
  settle(row, params, table, out);
}

void settle_row(const SettleRow& row, const SettleParams& params, const ColumnTables& tables,
                const FusedRow& out) noexcept {
  settle(row, params, tables, out);
}

}  // namespace stof::dsp
