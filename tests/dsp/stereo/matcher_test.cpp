#include "dsp/stereo/matcher.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

// What the appliance asks of a Matcher; tests/lab/matcher_test.cpp has every method.
namespace stof::dsp {
namespace {

using Pixels = std::vector<std::uint8_t>;

constexpr int kWidth = 70;
constexpr int kHeight = 50;
constexpr int kStripesWidth = 160;  // more than the candidates of a search

Pixels noise(std::uint64_t seed) {
  Pixels out(kWidth * kHeight);
  test::Random(seed).fill(std::span(out), 0, 60);
  return out;
}

// A search that finds its number everywhere, and tells what it was asked.
class Told final : public RowSearch {
 public:
  explicit Told(int disparity) : disparity_(disparity) {}
  void start(const PreparedPair&, Guide) noexcept override { ++started; }
  void match(int y, const MatchedRow& out) noexcept override {
    rows.push_back(y);
    std::ranges::fill(out.disparity, Disparity::from_pixels(disparity_));
    std::ranges::fill(out.ratio, std::uint8_t{7});
  }

  int started = 0;
  std::vector<int> rows;

 private:
  int disparity_;
};

class OneSearch final : public SearchMaker {
 public:
  explicit OneSearch(RowSearch& search) : search_(search) {}
  RowSearch* make(const MatchParams&, int, int, Arena&) noexcept override { return &search_; }
  int rows_at_once(int height) const noexcept override { return height; }

 private:
  RowSearch& search_;
};

TEST(Matcher, SearchesWithWhatItIsGiven) {
  const Pixels picture = noise(1);
  const ImageView<const std::uint8_t> view(picture.data(), kWidth, kHeight);
  Told told(5);
  OneSearch maker(told);
  // No blocks of grey values: of no concern to another search.
  const MatchParams params{.prefilter_cap = std::nullopt, .median = true, .confidence = true};
  test::GuardedPart<Matcher> matcher(
      [&](Arena& arena) { return Matcher(params, kWidth, kHeight, arena, {}, &maker); });
  std::vector<Disparity> out(picture.size());
  matcher->match({.left = view, .right = view}, {out.data(), kWidth, kHeight});
  EXPECT_EQ(told.started, 1);
  EXPECT_EQ(told.rows.size(), static_cast<std::size_t>(kHeight));
  EXPECT_EQ(std::ranges::count(out, Disparity::from_pixels(5)), kWidth * kHeight);
  EXPECT_EQ(matcher->ratio().at(3, 4), 7);
}

TEST(Matcher, KeepsForEveryPresetWhatItsChecksDropped) {
  for (const char* const name : {"fast", "quality"}) {
    const MatchParams params = for_depth(*find_preset(name));
    test::GuardedPart<Matcher> matcher(
        [&](Arena& arena) { return Matcher(params, kWidth, kHeight, arena); });
    const Pixels left = noise(1);
    const Pixels right = noise(2);
    std::vector<Disparity> out(left.size());
    const ImageView<Disparity> map(out.data(), kWidth, kHeight);
    matcher->match(
        {.left = {left.data(), kWidth, kHeight}, .right = {right.data(), kWidth, kHeight}}, map);
    int weak = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool dropped = matcher->weak().at(x, y).valid();
        weak += dropped ? 1 : 0;
        ASSERT_TRUE(!dropped || !map.at(x, y).valid() || params.median) << name;
      }
    }
    EXPECT_TRUE(weak > 0 || params.search == Search::kSemiGlobal);  // which hardly match noise
    EXPECT_FALSE(matcher->ratio().empty());
  }
}

// Steep stripes, whose derivatives reach the cap of the prefilter everywhere, so that one period on
// nothing differs at all.
TEST(Matcher, FindsNoMatchForStripesThatRepeat) {
  constexpr int kShift = 6;
  constexpr std::size_t kFrom = 24;  // before, the right picture holds less than a period
  const MatchParams params = for_depth(*find_preset("fast"));
  test::GuardedPart<Matcher> matcher(
      [&](Arena& arena) { return Matcher(params, kStripesWidth, kHeight, arena); });
  for (const bool repeats : {true, false}) {
    const Pixels noisy = noise(1);
    const auto texture = [&](int x, int y) {
      const int column = repeats ? x % 8 : x;
      return repeats ? std::uint8_t(column < 4 ? 40 * column : 40 * (8 - column))
                     : noisy[static_cast<std::size_t>(37 * x + 91 * y) % noisy.size()];
    };
    Pixels left(kStripesWidth * kHeight);
    Pixels right(left.size());
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kStripesWidth; ++x) {
        const std::size_t at = static_cast<std::size_t>(y * kStripesWidth + x);
        left[at] = texture(x, y);
        right[at] = texture(x + kShift, y);
      }
    }
    std::vector<Disparity> out(left.size());
    const ImageView<Disparity> map(out.data(), kStripesWidth, kHeight);
    matcher->match({.left = {left.data(), kStripesWidth, kHeight},
                    .right = {right.data(), kStripesWidth, kHeight}},
                   map);
    std::ptrdiff_t matched = 0;
    for (int y = 0; y < kHeight; ++y) {
      matched +=
          std::ranges::count_if(map.row(y).subspan(kFrom), [](Disparity d) { return d.valid(); });
    }
    if (repeats) {
      EXPECT_EQ(matched, 0);
    } else {
      EXPECT_GT(matched, kStripesWidth * kHeight / 3);
    }
  }
}

TEST(MatchParams, SayWhatCannotBeMatched) {
  EXPECT_EQ(check({}, 640, 480), Status::kOk);
  EXPECT_EQ(check({}, 0, 480), Status::kInvalidArgument);
  EXPECT_EQ(check({.disparities = 0}, 640, 480), Status::kInvalidArgument);
  EXPECT_EQ(check({.prefilter_cap = std::nullopt}, 640, 480), Status::kInvalidArgument);
  EXPECT_EQ(check({.block_width = 17}, 640, 480), Status::kInvalidArgument);
  EXPECT_EQ(check({.block_width = 17, .prefilter_cap = 14}, 640, 480), Status::kOk);
  EXPECT_EQ(check({.search = Search::kSemiGlobal, .prefilter_cap = std::nullopt}, 640, 480),
            Status::kOk);
  EXPECT_EQ(check({.search = Search::kSemiGlobal,
                   .smoothness = Smoothness{.small_step = 4, .large_step = kMaxStep + 1}},
                  640, 480),
            Status::kInvalidArgument);
  EXPECT_EQ(check({.min_texture = 2}, 640, 480), Status::kOk);
  EXPECT_EQ(check({.disparities = 257}, 640, 480), Status::kTooLarge);
  EXPECT_EQ(check({}, 5000, 480), Status::kTooLarge);
}

}  // namespace
}  // namespace stof::dsp
