#include "dsp/fusion/resolve/hole_filler.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/resolve/ambiguity_resolver.h"
#include "dsp/fusion/resolve/hole_masks.h"
#include "dsp/fusion/resolve/pixel_set.h"
#include "dsp/fusion/resolve/surrounding_matches.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {
namespace {

constexpr int kCell = 8;  // px
constexpr int kQuarter = kCell / 2;
constexpr int kSurfaceShare = 6;  // width of a surface, of its depth
constexpr int kOneSurface = 14;   // of the depth, what lies within a cell
constexpr std::size_t kRank = 3;
constexpr int kBeside = 2;          // cells
constexpr int kNearerReadings = 2;  // of 16 around a guess
constexpr std::size_t kFewest = 3;  // surfaces that may be meant, of a guess without a reading
constexpr int kGuessPercent = 25;
constexpr int kFarthestGuess = 4 * kMaxGuess;
constexpr int kSameShare = 32;  // of the depth: surfaces this near each other have one verdict

struct Step {
  int x;
  int y;
};
constexpr std::array<Step, 8> kDirections{
    {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};

// An element for each column of a row of cells.
using Columns = std::array<QuarterMm, kMaxImageWidth>;

constexpr bool is_one_surface(QuarterMm near, QuarterMm far) noexcept {
  return near * kOneSurface > far * (kOneSurface - 1);
}

// A bit for each pixel of a cell: of the first row the lowest eight, the first pixel lowest.
using CellBits = std::uint64_t;
constexpr CellBits kUpperLeft = 0x0F0F'0F0F;

// Calls visit(column, row) for each bit, within the cell.
template <typename Visit>
void each_bit(CellBits bits, Visit visit) noexcept {
  for (; bits != 0; bits &= bits - 1) {
    const auto bit = static_cast<std::size_t>(std::countr_zero(bits));
    visit(bit % kCell, bit / kCell);
  }
}

// Whether the PMD sees something beside the pixel that is nearer than a depth by over a metre.
bool is_beside_nearer(ImageView<const QuarterMm> high, int x, int y, int depth) noexcept {
  int found = 0;
  for (const int step : kSupportRings) {
    for (const int row : {y - step, y, y + step}) {
      if (row < 0 || row >= high.height()) {
        continue;
      }
      const std::span<const QuarterMm> ends = high.row(row);
      for (const int column : {x - step, x, x + step}) {
        if (column >= 0 && column < high.width()) {
          const int end = ends[index(column)];
          found += end > 0 && end < depth - kMaxGuess ? 1 : 0;
        }
      }
    }
  }
  return found >= kNearerReadings;
}

}  // namespace

// A row of the map, for whoever fills it.
class HoleFiller::OpenRow {
 public:
  OpenRow() noexcept = default;
  OpenRow(const DepthMap& map, const HoleView& view, int y) noexcept
      : depth_(map.depth.row(y)),
        width_(map.width.row(y)),
        source_(map.source.row(y)),
        cause_(map.cause.row(y)),
        low_(view.pmd_low.row(y)),
        high_(view.pmd_high.row(y)) {}

  // A guess, nearer to what the PMD alone tells.
  QuarterMm pulled(std::size_t x, int guess, QuarterMm max_range) const noexcept {
    if (source_[x] != Source::kPmd) {
      return static_cast<QuarterMm>(guess);
    }
    const int pull = guess / kPullShare;
    return static_cast<QuarterMm>(
        std::clamp<int>(std::clamp<int>(depth_[x], guess - pull, guess + pull), low_[x],
                        std::min(high_[x], max_range)));
  }

  bool is_mixed(std::size_t x) const noexcept { return cause_[x] == Cause::kMixedPixel; }
  bool is_allowed(std::size_t x, int depth, QuarterMm max_range) const noexcept {
    return depth >= low_[x] && depth <= std::min(high_[x], max_range) &&
           depth - low_[x] <= kMaxGuess;
  }
  int half_over_pmd(std::size_t x, int depth, QuarterMm max_range) const noexcept {
    return std::max(depth - low_[x], std::min(high_[x], max_range) - depth);
  }

  QuarterMm depth(std::size_t x) const noexcept { return depth_[x]; }
  // Of eight pixels from x on, fewer at the end.
  QuarterMm farthest(std::size_t x) const noexcept {
    if (x + kCell > depth_.size()) {
      return std::ranges::max(depth_.subspan(x));
    }
    QuarterMm farthest = 0;
    for (const QuarterMm depth : std::span<const QuarterMm>(depth_).subspan(x).first<kCell>()) {
      farthest = std::max(farthest, depth);
    }
    return farthest;
  }
  void drop(std::size_t x) const noexcept {
    depth_[x] = kNoDepth;
    width_[x] = 0;
    source_[x] = Source::kConflict;
    cause_[x] = Cause::kMixedPixel;
  }

  void put(std::size_t x, QuarterMm depth, int half, Cause cause) const noexcept {
    depth_[x] = depth;
    width_[x] = static_cast<QuarterMm>(2 * std::min({half, depth - 1, kMaxQuarterMm / 2}));
    source_[x] = Source::kResolved;
    cause_[x] = cause;
  }

 private:
  std::span<QuarterMm> depth_;
  std::span<QuarterMm> width_;
  std::span<Source> source_;
  std::span<Cause> cause_;
  std::span<const QuarterMm> low_;
  std::span<const QuarterMm> high_;
};

// The surfaces around one cell.
class HoleFiller::Search {
 public:
  Search(const HoleFiller& filler, const MatchEvidence& evidence, int x, int y) noexcept
      : filler_(filler),
        evidence_(evidence),
        x_(std::min(x * kCell + kCell / 2, filler.width_ - 1)),
        y_(std::min(y * kCell + kCell / 2, filler.height_ - 1)) {
    add_beside(x, y);
    for (const Step& step : kDirections) {
      look(x, y, step);
    }
  }

  Guess guess() noexcept {
    const bool read = std::ranges::any_of(all(), is_read);
    const auto end = std::partition(far_.begin(), far_.begin() + count_,
                                    [&](const Surface& s) noexcept { return counts(s, read); });
    const std::size_t found = static_cast<std::size_t>(end - far_.begin());
    if (found == 0) {
      return {};
    }
    std::sort(far_.begin(), end,
              [](const Surface& a, const Surface& b) noexcept { return a.depth > b.depth; });
    const Surface& chosen = far_[std::min(kRank, found - 1)];
    int nearest = far_[found - 1].depth;
    for (const Surface& s : std::span(near_).first(count_)) {
      nearest = counts(s, read) ? std::min<int>(nearest, s.depth) : nearest;
    }
    if (chosen.depth - std::min(nearest, beside_) > kMaxGuess) {
      return {};
    }
    if (read) {
      return {.depth = chosen.depth, .half = 0, .read = true, .fills = true};
    }
    const int depth = chosen.depth;
    return {.depth = chosen.depth,
            .half = std::max({depth - nearest, far_[0].depth - depth, depth * kGuessPercent / 100}),
            .read = false,
            .fills = chosen.said.verdict == Verdict::kAllowed && found >= kFewest &&
                     depth <= kFarthestGuess};
  }

 private:
  using Verdict = MatchEvidence::Verdict;

  // A depth that may be there, and what the PMD says of it.
  struct Surface {
    QuarterMm depth = 0;
    MatchEvidence::Result said{};
  };

  std::span<const Surface> all() const noexcept { return std::span(far_).first(count_); }
  static bool is_read(const Surface& s) noexcept { return s.said.verdict == Verdict::kConfirmed; }
  static bool counts(const Surface& s, bool read) noexcept {
    return is_read(s) || (!read && s.said.verdict != Verdict::kContradicted);
  }

  // The nearest cell with a surface on the way from (x, y).
  void look(int x, int y, const Step& step) noexcept {
    const ImageView<QuarterMm>& cells = filler_.near_;
    int steps = 0;
    do {
      x += step.x;
      y += step.y;
      ++steps;
      if (x < 0 || y < 0 || x >= cells.width() || y >= cells.height()) {
        return;
      }
    } while (cells.at(x, y) == kNoDepth);
    if (steps <= kBeside) {
      add_beside(x, y);
    }
    const QuarterMm far = filler_.far_.at(x, y);
    const QuarterMm near = cells.at(x, y);
    far_[count_] = {far, verdict(far)};
    near_[count_] = {near, is_one_surface(near, far) ? far_[count_].said : verdict(near)};
    ++count_;
  }

  void add_beside(int x, int y) noexcept {
    const QuarterMm near = filler_.near_.at(x, y);
    beside_ = near == kNoDepth ? beside_ : std::min<int>(beside_, near);
  }

  MatchEvidence::Result verdict(QuarterMm depth) const noexcept {
    for (const Surface& s : all()) {
      if (std::abs(s.depth - depth) * kSameShare <= depth) {
        return s.said;
      }
    }
    return evidence_.judge_surface(x_, y_, depth);
  }

  const HoleFiller& filler_;
  const MatchEvidence& evidence_;
  int x_;
  int y_;
  std::array<Surface, kDirections.size()> far_{};
  std::array<Surface, kDirections.size()> near_{};
  std::size_t count_ = 0;
  int beside_ = kMaxQuarterMm;  // the nearest surface in the cell or beside it
};

HoleFiller::HoleFiller(int width, int height, QuarterMm max_range, Arena& arena) noexcept
    : width_(width), height_(height), max_range_(max_range) {
  const int columns = (width + kCell - 1) / kCell;
  const int rows = (height + kCell - 1) / kCell;
  near_ = arena.take_passing_image<QuarterMm>(columns, rows);
  far_ = arena.take_passing_image<QuarterMm>(columns, rows);
}

Rows HoleFiller::map_rows(Rows cells) const noexcept {
  return {std::min(cells.begin * kCell, height_), std::min(cells.end * kCell, height_)};
}

void HoleFiller::gather(Rows cells, const DepthMap& map) const noexcept {
  STOF_CHECK(map.depth.width() == width_ && map.depth.height() == height_);
  Columns nearest;
  Columns farthest;
  for (int row = cells.begin; row < cells.end; ++row) {
    std::ranges::fill(nearest, kMaxQuarterMm);
    std::ranges::fill(farthest, kNoDepth);
    for (int y = row * kCell; y < std::min((row + 1) * kCell, height_); ++y) {
      const std::span<const QuarterMm> depth = map.depth.row(y);
      const std::span<const QuarterMm> width = map.width.row(y);
      for (std::size_t x = 0; x < depth.size(); ++x) {  // values, not references: vectors
        const QuarterMm there = depth[x];
        const bool surface = width[x] < there / kSurfaceShare;
        const QuarterMm low = surface ? there : kMaxQuarterMm;
        const QuarterMm high = surface ? there : kNoDepth;
        nearest[x] = low < nearest[x] ? low : nearest[x];
        farthest[x] = high > farthest[x] ? high : farthest[x];
      }
    }
    const std::span<QuarterMm> near = near_.row(row);
    const std::span<QuarterMm> far = far_.row(row);
    for (std::size_t x = 0; x < near.size(); ++x) {
      near[x] = std::ranges::min(std::span(nearest).subspan(x * kCell).first<kCell>());
      far[x] = std::ranges::max(std::span(farthest).subspan(x * kCell).first<kCell>());
      if (far[x] == kNoDepth) {
        near[x] = kNoDepth;
      } else if (is_one_surface(near[x], far[x])) {
        far[x] = middle_of(near[x], far[x]);
      }
    }
  }
}

// The open pixels of a row of cells, one set for each row of pixels.
struct HoleFiller::OpenCells {
  std::array<PixelSet, kCell> hole;
  std::array<PixelSet, kCell> loose;
  std::array<PixelSet, kCell> guess;
  PixelSet any;      // holes and loose ones of all its rows
  PixelSet guesses;  // of all its rows
  std::array<OpenRow, kCell> pixels;

  void mark(const DepthMap& map, const HoleView& view, Rows rows) noexcept {
    const std::size_t n = index(map.depth.width());
    std::ranges::fill(any.words(n), 0U);
    std::ranges::fill(guesses.words(n), 0U);
    for (int y = rows.begin; y < rows.end; ++y) {
      const std::size_t k = index(y - rows.begin);
      pixels[k] = OpenRow(map, view, y);
      best::hole_masks({map.depth.row(y), map.width.row(y), map.source.row(y), map.cause.row(y),
                        view.disparity.row(y)},
                       {hole[k].words(n), loose[k].words(n), guess[k].words(n)});
      any.unite(hole[k], n);
      any.unite(loose[k], n);
      guesses.unite(guess[k], n);
    }
  }
};

void HoleFiller::fill(Rows cells, const HoleView& view, const MatchEvidence& evidence,
                      const DepthMap& map) const noexcept {
  STOF_CHECK(map.depth.width() == width_ && map.depth.height() == height_);
  STOF_CHECK(same_size(view.disparity, map.depth) && same_size(view.pmd_low, map.depth) &&
             same_size(view.pmd_high, map.depth) && same_size(map.cause, map.depth));
  const std::size_t n = index(width_);
  OpenCells open;
  for (int row = cells.begin; row < cells.end; ++row) {
    open.mark(map, view, {row * kCell, std::min((row + 1) * kCell, height_)});
    if (evidence.sees_finely()) {
      drop_guesses(row, view, open);
    }
    for (std::size_t x = open.any.next(0, n); x < n; x = open.any.next(x, n)) {
      const int column = static_cast<int>(x) / kCell;
      const Guess guess = Search(*this, evidence, column, row).guess();
      if (guess.depth != kNoDepth) {
        fill_cell(column, row, guess, open, evidence);
      }
      x = index(column + 1) * kCell;
    }
  }
}

// They become holes.
void HoleFiller::drop_guesses(int row, const HoleView& view, OpenCells& open) const noexcept {
  const std::size_t n = index(width_);
  const int rows = std::min(kCell, height_ - row * kCell);
  // Of a column of three cells, less one: without a surface it is the farthest.
  Columns nearest;
  const std::span<const QuarterMm> above = near_.row(std::max(row - 1, 0));
  const std::span<const QuarterMm> here = near_.row(row);
  const std::span<const QuarterMm> below = near_.row(std::min(row + 1, near_.height() - 1));
  for (std::size_t x = 0; x < here.size(); ++x) {
    const auto less = [x](std::span<const QuarterMm> cells) noexcept {
      return static_cast<QuarterMm>(cells[x] - 1);
    };
    nearest[x] = std::min({less(above), less(here), less(below)});
  }
  for (std::size_t x = open.guesses.next(0, n); x < n; x = open.guesses.next(x, n)) {
    const std::size_t cell = x / kCell;
    const std::size_t left = cell == 0 ? cell : cell - 1;
    const std::size_t right = std::min(cell + 1, here.size() - 1);
    const int most = std::min({nearest[left], nearest[cell], nearest[right]}) + 1 + kMaxGuess;
    for (int k = 0; k < rows && most < kMaxQuarterMm; ++k) {
      if (open.pixels[index(k)].farthest(cell * kCell) > most) {
        drop_guesses(cell * kCell, row * kCell + k, most, view, open);
      }
    }
    x = (cell + 1) * kCell;
  }
}

// Of eight pixels of a row.
void HoleFiller::drop_guesses(std::size_t first, int y, int most, const HoleView& view,
                              OpenCells& open) noexcept {
  const std::size_t k = index(y % kCell);
  const OpenRow& pixels = open.pixels[k];
  for (unsigned bits = open.guess[k].eight(first); bits != 0; bits &= bits - 1) {
    const std::size_t x = first + static_cast<std::size_t>(std::countr_zero(bits));
    const int depth = pixels.depth(x);
    if (depth > most && is_beside_nearer(view.pmd_high, static_cast<int>(x), y, depth)) {
      pixels.drop(x);
      open.loose[k].remove(x);
      open.hole[k].add(x);
      open.any.add(x);
    }
  }
}

void HoleFiller::fill_cell(int column, int row, const Guess& guess, const OpenCells& open,
                           const MatchEvidence& evidence) const noexcept {
  const std::size_t x = index(column) * kCell;
  CellBits hole = 0;
  CellBits loose = 0;
  for (std::size_t k = 0; k < index(std::min(kCell, height_ - row * kCell)); ++k) {
    hole |= CellBits{open.hole[k].eight(x)} << (k * kCell);
    loose |= CellBits{open.loose[k].eight(x)} << (k * kCell);
  }
  for (int k = 0; k < 4; ++k) {
    const CellBits here = kUpperLeft << (k % 2 * kQuarter + k / 2 * kQuarter * kCell);
    if (((hole | loose) & here) != 0) {
      fill_quarter(guess.read ? read(guess, evidence, 2 * column + k % 2, 2 * row + k / 2) : guess,
                   {.x = x, .hole = hole & here, .loose = loose & here}, open);
    }
  }
}

HoleFiller::Guess HoleFiller::read(const Guess& guess, const MatchEvidence& evidence, int column,
                                   int row) const noexcept {
  const MatchEvidence::Result said =
      evidence.judge_surface(std::min(column * kQuarter + kQuarter / 2, width_ - 1),
                             std::min(row * kQuarter + kQuarter / 2, height_ - 1), guess.depth);
  if (said.verdict != MatchEvidence::Verdict::kConfirmed) {
    return {};
  }
  const auto [low, high] = said.reading;
  return {
      .depth = middle_of(low, high), .half = width_of(low, high) / 2, .read = true, .fills = true};
}

void HoleFiller::fill_quarter(const Guess& guess, const OpenBits& bits,
                              const OpenCells& open) const noexcept {
  if (guess.depth == kNoDepth) {
    return;
  }
  const Cause cause = guess.read ? Cause::kRangeAmbiguous : Cause::kInterpolated;
  each_bit(guess.fills ? bits.hole : 0U, [&](std::size_t column, std::size_t row) noexcept {
    open.pixels[row].put(bits.x + column, guess.depth, guess.half, cause);
  });
  each_bit(bits.loose, [&](std::size_t column, std::size_t row) noexcept {
    const OpenRow& pixels = open.pixels[row];
    const std::size_t x = bits.x + column;
    if (pixels.is_allowed(x, guess.depth, max_range_)) {
      const QuarterMm depth = pixels.pulled(x, guess.depth, max_range_);
      pixels.put(x, depth, pixels.half_over_pmd(x, depth, max_range_),
                 pixels.is_mixed(x) ? Cause::kMixedPixel : Cause::kStereoAmbiguous);
    }
  });
}

}  // namespace stof::dsp
