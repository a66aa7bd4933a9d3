#include "dsp/stereo/matcher.h"

#include "dsp/base/arena_phase.h"
#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/stereo/search/block_search.h"
#include "dsp/stereo/search/semi_global_search.h"

namespace stof::dsp {
namespace {

// Rows that a thread prepares or clears at once: a row looks at few others.
constexpr int kRowsOfPictures = 16;

class OwnSearches final : public SearchMaker {
 public:
  explicit OwnSearches(const MatchParams& params) noexcept
      : paths_(params.search == Search::kSemiGlobal) {}

  RowSearch* make(const MatchParams& params, int width, int height,
                  Arena& arena) noexcept override {
    STOF_CHECK(check(params, width, height) == Status::kOk);
    if (paths_) {
      return arena.make<SemiGlobalSearch>(params, width);
    }
    return arena.make<BlockSearch>(params, width);
  }
  // Paths work on whole stripes; sums over blocks begin anew only where a thread takes over what is
  // another's.
  int rows_at_once(int) const noexcept override {
    return paths_ ? SemiGlobalSearch::Paths::kStripe : kRowsOfPictures;
  }

 private:
  bool paths_;
};

}  // namespace

// The pictures live through both phases: rows are searched, all at the same time; then the map is
// checked.
Matcher::Matcher(const MatchParams& params, int width, int height, Arena& arena,
                 const ThreadTeam& team, SearchMaker* maker) noexcept
    : team_(team),
      pair_(params, width, height, arena, maker == nullptr && params.search == Search::kSemiGlobal),
      margins_(params.distinct ? arena.take_image<std::int16_t>(width, height)
                               : ImageView<std::int16_t>()),
      ratio_(params.confidence ? arena.take_image<std::uint8_t>(width, height)
                               : ImageView<std::uint8_t>()),
      checks_(params, width, height, margins_, ArenaPhase(arena), team) {
  STOF_CHECK(width >= 1 && height >= 1 && in_ranges(params) && fits(params, width, height));
  OwnSearches own(params);
  SearchMaker& searches = maker != nullptr ? *maker : own;
  rows_at_once_ = searches.rows_at_once(height);
  const ArenaPhase all(arena);
  for (int thread = 0; thread < team.threads(); ++thread) {
    searches_[index(thread)] = searches.make(params, width, height, all);
  }
}

void Matcher::match(const MatchInput& input, ImageView<Disparity> out) noexcept {
  STOF_CHECK(same_size(input.left, out));
  width_ = out.width();
  height_ = out.height();
  checks_.start(width_, height_);
  pair_.start(input.left, input.right);
  if (out.empty()) {
    return;
  }
  prepare(input);
  search(out);
  const auto clear_border = [&] {
    if (input.rectifier != nullptr) {
      team_.run_rows(out.rows(), kRowsOfPictures,
                     [&](Rows rows, int) noexcept { input.rectifier->clear_border(rows, out); });
    }
  };
  // Before, because what looks at the whole map must not see what lies beyond a border; and after,
  // because the median writes there.
  clear_border();
  checks_.apply(pair_, out);
  clear_border();
}

void Matcher::prepare(const MatchInput& input) noexcept {
  for (int thread = 0; thread < team_.threads(); ++thread) {
    searches_[index(thread)]->start(pair_, input.guide);
  }
  const Rows rows{0, height_};
  if (pair_.filters()) {
    team_.run_rows(rows, kRowsOfPictures, [this](Rows some, int) noexcept { pair_.filter(some); });
  }
  if (pair_.derives()) {
    team_.run_rows(rows, kRowsOfPictures, [this](Rows some, int) noexcept { pair_.derive(some); });
  }
}

void Matcher::search(ImageView<Disparity> out) noexcept {
  team_.run_rows(out.rows(), rows_at_once_, [&](Rows rows, int thread) noexcept {
    for (int y = rows.begin; y < rows.end; ++y) {
      searches_[index(thread)]->match(y, row_of(y, out));
    }
  });
}

MatchedRow Matcher::row_of(int y, ImageView<Disparity> out) noexcept {
  const std::size_t n = index(width_);
  MatchedRow row{.disparity = out.row(y), .margins = {}, .ratio = {}};
  if (!margins_.empty()) {
    row.margins = margins_.row(y).first(n);
  }
  if (!ratio_.empty()) {
    row.ratio = ratio_.row(y).first(n);
  }
  return row;
}

ImageView<const std::uint8_t> Matcher::ratio() const noexcept {
  return cut(ratio_, width_, height_);
}

}  // namespace stof::dsp
