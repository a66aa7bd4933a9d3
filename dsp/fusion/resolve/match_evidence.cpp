#include "dsp/fusion/resolve/match_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "dsp/base/index.h"
#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/resolve/surrounding_matches.h"

namespace stof::dsp {
namespace {

constexpr int kSupportShare = 24;    // of the parallax
constexpr int kMinSupportStep = 12;  // 1/16 px
constexpr int kEnoughSupport = 12;
constexpr int kEnoughWhereSure = 6;
constexpr int kEnoughOutside = 3;

constexpr int kSupporters = 16;
constexpr int kBeyondDoubt = 18;
constexpr int kOutsideWeight = 9;
constexpr int kRatioWeight = 12;
constexpr int kLeastContrast = 7;  // a grey level for each pixel: noise
constexpr int kBeyondWeight = 2;   // 16ths
constexpr int kBeforeWeight = 8;

constexpr float kChanceShare = 8;         // of the range: agreement by chance is one in four
constexpr float kAgreementShare = 0.05F;  // of the distance
constexpr float kFoldedMargin = 0.01F;    // of the distance, of a match
constexpr float kSurfaceMargin = 0.03F;   // of a surface

// From a distance along the PMD's ray to Z of the left camera.
DepthInterval reading_at(float centre, float reach, float scale) noexcept {
  const float last = static_cast<float>(kMaxQuarterMm);
  return {static_cast<QuarterMm>(std::clamp((centre - reach) * scale, 1.0F, last)),
          static_cast<QuarterMm>(std::clamp(std::ceil((centre + reach) * scale), 1.0F, last))};
}

}  // namespace

int contrast(ImageView<const std::uint8_t> picture, int x, int y) noexcept {
  constexpr int kReach = 3;
  const std::span<const std::uint8_t> row = picture.row(y);
  int along = 0;
  for (int at = std::max(x - kReach, 1); at <= std::min(x + kReach, picture.width() - 2); ++at) {
    along += std::abs(row[index(at + 1)] - row[index(at - 1)]);
  }
  int across = 0;
  for (int at = std::max(y - kReach, 1); at <= std::min(y + kReach, picture.height() - 2); ++at) {
    across += std::abs(picture.at(x, at + 1) - picture.at(x, at - 1));
  }
  return std::max(along, across);
}

MatchEvidence::MatchEvidence(const Calibration& calibration, std::int16_t infinity_raw) noexcept
    : infinity_raw_(infinity_raw) {
  const Pinhole& lens = calibration.pmd.lens;
  if (lens.width > 0) {
    view_ = PmdView(calibration);
    around_ = is_fine(lens) ? 0 : 1;
  }
}

MatchEvidence::Said MatchEvidence::ask(int column, int row, float distance,
                                       float half) const noexcept {
  const std::size_t x = index(column);
  const QuarterMm folded = pmd_->folded.empty() ? kNoDepth : pmd_->folded.row(row)[x];
  if (folded != kNoDepth) {
    const float range = static_cast<float>(pmd_->range);
    const float apart = distance - static_cast<float>(folded);
    const float off = apart - range * std::floor(apart / range + 0.5F);
    const float sigma = static_cast<float>(pmd_->folded_sigma.row(row)[x]);
    const float reach = 2 * sigma + std::min(half, kAgreementShare * distance);
    if (reach > range / kChanceShare) {
      return {};
    }
    const Opinion opinion = std::abs(off) <= reach ? Opinion::kAgrees : Opinion::kDiffers;
    const bool mixed = around_ > 0 && (pmd_->flags.row(row)[x] & kPmdEdge) != 0;
    return {.opinion = opinion, .folded = !mixed, .off = off, .sigma = sigma};
  }
  const QuarterMm low = pmd_->low.row(row)[x];
  const unsigned flags = pmd_->flags.row(row)[x];
  if (low == 0) {  // silent, but for what it sees beyond kMaxQuarterMm
    const bool beyond = (flags & kPmdOutOfRange) != 0 && (flags & kPmdMissing) == 0;
    return {.opinion = beyond ? Opinion::kDiffers : Opinion::kNone};
  }
  const bool differs = distance + half < static_cast<float>(low);
  return {.opinion = differs ? Opinion::kDiffers : Opinion::kAgrees,
          .hidden = distance - half > static_cast<float>(pmd_->high.row(row)[x])};
}

template <typename Hear>
void MatchEvidence::ask_around(const PmdView::Place& place, float half, Hear hear) const noexcept {
  for (int row = std::max(place.row - around_, 0);
       row <= std::min(place.row + around_, pmd_->low.height() - 1); ++row) {
    for (int column = std::max(place.column - around_, 0);
         column <= std::min(place.column + around_, pmd_->low.width() - 1); ++column) {
      hear(ask(column, row, place.distance, half));
    }
  }
}

// Where the picture has all of them.
MatchEvidence::Support MatchEvidence::inner_supporters(
    const Match& match, int most, ImageView<const Disparity> disparity) noexcept {
  const Disparity* const here = &disparity.row(match.y)[index(match.x)];
  const int first = match.disparity.raw - most;
  const auto is_near = [=](const Disparity* other) noexcept {
    return static_cast<unsigned>(other->raw - first) <= static_cast<unsigned>(2 * most) ? 1 : 0;
  };
  Support support{.count = 0, .there = 8 * int{kSupportRings.size()}};
  for (const int step : kSupportRings) {
    const Disparity* const above = here - step * disparity.stride();
    const Disparity* const below = here + step * disparity.stride();
    if (step == kSupportRings.front()) {
      for (const Disparity* const row : {above, here, below}) {
        support.missing += (row[-step].valid() ? 0 : 1) + (row[step].valid() ? 0 : 1);
      }
      support.missing += (above->valid() ? 0 : 1) + (below->valid() ? 0 : 1);
    }
    support.count += is_near(above - step) + is_near(above) + is_near(above + step) +
                     is_near(here - step) + is_near(here + step) + is_near(below - step) +
                     is_near(below) + is_near(below + step);
  }
  return support;
}

int MatchEvidence::most_of(const Match& match) const noexcept {
  return std::max((match.disparity.raw - infinity_raw_) / kSupportShare, kMinSupportStep);
}

MatchEvidence::Support MatchEvidence::supporters(
    const Match& match, ImageView<const Disparity> disparity) const noexcept {
  const int raw = match.disparity.raw;
  const int most = most_of(match);
  constexpr int kFarthest = kSupportRings.back();
  if (match.x >= kFarthest && match.x + kFarthest < disparity.width() && match.y >= kFarthest &&
      match.y + kFarthest < disparity.height()) {
    return inner_supporters(match, most, disparity);
  }
  Support support;
  for (const int step : kSupportRings) {
    const int left = match.x >= step ? match.x - step : match.x;
    const int right = match.x + step < disparity.width() ? match.x + step : match.x;
    for (const int y : {match.y - step, match.y, match.y + step}) {
      if (y < 0 || y >= disparity.height()) {
        continue;
      }
      const std::span<const Disparity> row = disparity.row(y);
      const auto ask_match = [&](int x, bool other) noexcept {
        // None is far from every disparity.
        support.there += other ? 1 : 0;
        support.count += other && std::abs(row[index(x)].raw - raw) <= most ? 1 : 0;
        support.missing += other && step == kSupportRings.front() && !row[index(x)].valid() ? 1 : 0;
      };
      ask_match(left, left != match.x);
      ask_match(right, right != match.x);
      ask_match(match.x, y != match.y);
    }
  }
  return support;
}

// For a match: each that supports it, and a constant; more where the PMD camera does not look, and
// where its surface ends at an edge of the picture. Against it: pixels near it without a match, its
// peak ratio, the logarithm of the contrast, and an edge behind it. The weights are those of a
// regression (docs/DESIGN.md).
bool MatchEvidence::is_beyond_doubt(const Match& match, const MatchedView& view,
                                    const Support& support, bool outside) const noexcept {
  const int supported = support.count * kSupporters / std::max(support.there, 1);
  const int change = view.picture.empty() ? 0 : contrast(view.picture, match.x, match.y);
  const int against =
      support.missing + match.ratio / kRatioWeight + (log2_q4(kLeastContrast + change) * 7) / 32;
  const int balance = supported + (outside ? kOutsideWeight : 0) + kBeyondDoubt - against;
  constexpr int kMost = log2_q4(kFarthestBeyond);  // what edges can say
  if (balance > kMost * kBeyondWeight / 16 || balance <= -kMost * kBeforeWeight / 16) {
    return balance > 0;
  }
  const int beyond = beyond_edge(view, {match.x, match.y, match.disparity.raw, most_of(match)});
  return balance > beyond * (beyond > 0 ? kBeyondWeight : kBeforeWeight) / 16;
}

MatchEvidence::Result MatchEvidence::judge(const Match& match,
                                           const MatchedView& view) const noexcept {
  const Support support = supporters(match, view.disparity);
  if (!support.is_enough(kEnoughOutside)) {
    return {Verdict::kUnsupported, {}};
  }
  const auto [low, high] = match.interval;
  const float depth = static_cast<float>(low + high) / 2;
  const float half = static_cast<float>(high - low) / 2;
  const PmdView::Place place = view_.of(match.x, match.y, depth);
  if (!place.seen()) {
    const bool enough = around_ > 0 || is_beyond_doubt(match, view, support, true);
    return {enough ? Verdict::kKept : Verdict::kDoubtful, {}};
  }
  const Said own = ask(place.column, place.row, place.distance, half);
  bool known = own.opinion != Opinion::kNone;
  bool agrees = own.opinion == Opinion::kAgrees;
  if (around_ > 0 && !agrees) {
    ask_around(place, half, [&](const Said& said) noexcept {
      known = known || said.opinion != Opinion::kNone;
      agrees = agrees || said.opinion == Opinion::kAgrees;
    });
  }
  if (known && !agrees) {
    return {Verdict::kContradicted, {}};
  }
  const bool folded = own.folded && own.opinion == Opinion::kAgrees;
  const bool sure = folded || match.ratio < kSureRatio;
  if (!support.is_enough(sure ? kEnoughWhereSure : kEnoughSupport)) {
    return {Verdict::kUnsupported, {}};
  }
  if (!folded) {
    const bool enough = around_ > 0 || is_beyond_doubt(match, view, support, false);
    return {enough ? Verdict::kKept : Verdict::kDoubtful, {}};
  }
  return {Verdict::kConfirmed,
          reading_at(place.distance - own.off, 2 * own.sigma + kFoldedMargin * place.distance,
                     depth / place.distance)};
}

MatchEvidence::Result MatchEvidence::judge_surface(int x, int y, QuarterMm depth) const noexcept {
  const float z = static_cast<float>(depth);
  const PmdView::Place place = view_.of(x, y, z);
  if (!place.seen()) {
    return {Verdict::kKept, {}};
  }
  const float half = kAgreementShare * place.distance;
  const auto allows = [](const Said& said) noexcept {
    return said.opinion == Opinion::kAgrees && !said.hidden;
  };
  const Said own = ask(place.column, place.row, place.distance, half);
  if (own.folded && own.opinion == Opinion::kAgrees && around_ == 0) {
    return {Verdict::kConfirmed,
            reading_at(place.distance - own.off, 2 * own.sigma + kSurfaceMargin * place.distance,
                       z / place.distance)};
  }
  if (own.opinion == Opinion::kNone) {
    return {Verdict::kKept, {}};
  }
  bool allowed = allows(own);
  if (!allowed && around_ > 0) {
    ask_around(place, half, [&](const Said& said) noexcept { allowed = allowed || allows(said); });
  }
  return {allowed ? Verdict::kAllowed : Verdict::kContradicted, {}};
}

}  // namespace stof::dsp
