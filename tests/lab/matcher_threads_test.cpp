#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "lab/matcher.h"
#include "posix/worker_threads.h"
#include "tests/support/random.h"

namespace stof::lab {
namespace {

struct Size {
  int width;
  int height;
};

std::size_t pixels(Size size) { return static_cast<std::size_t>(size.width * size.height); }

// All that a Matcher tells of one pair.
struct Found {
  std::vector<Disparity> disparity;
  std::vector<Disparity> weak;
  std::vector<std::uint8_t> ratio;
  std::vector<std::uint8_t> filled;

  bool operator==(const Found&) const = default;
};

template <typename T>
std::vector<T> copied(ImageView<const T> image) {
  std::vector<T> all;
  for (int y = 0; y < image.height(); ++y) {
    all.insert(all.end(), image.row(y).begin(), image.row(y).end());
  }
  return all;
}

struct alignas(Arena::kAlign) Line {
  std::byte bytes[Arena::kAlign];  // NOLINT(modernize-avoid-c-arrays): a cache line
};

std::size_t bytes_of(const MatchParams& params, Size size, int threads) {
  return bytes_taken([&](Arena& arena) {
    Matcher(params, size.width, size.height, arena, ThreadTeam::standing_for(threads));
  });
}

// Of the second of two frames, in exactly the memory that was asked for.
Found match(const MatchParams& params, Size size, std::span<const std::uint8_t> left,
            std::span<const std::uint8_t> right, const ThreadTeam& team) {
  const std::size_t bytes = bytes_of(params, size, team.threads());
  std::vector<Line> memory((bytes + Arena::kAlign - 1) / Arena::kAlign);
  Arena arena({memory.data()->bytes, bytes});
  Matcher matcher(params, size.width, size.height, arena, team);
  Found found{
      .disparity = std::vector<Disparity>(pixels(size)), .weak = {}, .ratio = {}, .filled = {}};
  const ImageView<const std::uint8_t> l(left.data(), size.width, size.height);
  const ImageView<const std::uint8_t> r(right.data(), size.width, size.height);
  const ImageView<Disparity> out(found.disparity.data(), size.width, size.height);
  matcher.match({.left = r, .right = l}, out);
  matcher.match({.left = l, .right = r}, out);
  found.weak = copied(matcher.weak());
  found.ratio = copied(matcher.ratio());
  found.filled = copied(matcher.filled());
  return found;
}

std::vector<MatchParams> every_kind() {
  std::vector<MatchParams> kinds;
  for (const char* const name : {"fast", "quality", "chapter"}) {
    kinds.push_back(as_the_appliance(find_preset(name)->params));
    kinds.push_back(as_the_appliance(for_depth(*find_preset(name))));
  }
  const auto with = [&](auto change) {
    MatchParams params{{.disparities = 32, .left_right_tolerance = 1, .speckle_pixels = 5}};
    change(params);
    kinds.push_back(params);
  };
  with([](MatchParams& p) { p.prefilter_cap = 15, p.min_texture = 3, p.confidence = true; });
  with([](MatchParams& p) { p.smooth = true, p.equalise = true, p.fill = true; });
  with([](MatchParams& p) {
    p.method = Method::kScanlineOptimisation, p.median = true, p.distinct = true;
  });
  with([](MatchParams& p) { p.method = Method::kDynamicProgramming; });
  with([](MatchParams& p) { p.method = Method::kSemiGlobal, p.directions = 8; });
  with([](MatchParams& p) { p.cost = Cost::kCensus9x7, p.histogram_permille = 20; });
  with([](MatchParams& p) { p.cost = Cost::kSsd, p.subpixel = Subpixel::kLeastSquares; });
  with([](MatchParams& p) { p.pyramid_levels = 1, p.confidence = true, p.median = true; });
  with([](MatchParams& p) { p.block_shape = BlockShape::kCross, p.block_width = 20; });
  for (MatchParams& params : kinds) {
    params.disparities = 32;
  }
  return kinds;
}

// A picture with a slanted texture, its right view, noise in both.
std::vector<std::uint8_t> picture(Size size, int shift, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<std::uint8_t> image(pixels(size));
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const auto u = static_cast<unsigned>(x + shift + y / 16);
      const unsigned cell = (u / 3 * 2654435761U ^ static_cast<unsigned>(y / 3) * 40503U) >> 7;
      image[static_cast<std::size_t>(y * size.width + x)] =
          static_cast<std::uint8_t>(cell % 200 + static_cast<unsigned>(random.between(0, 9)));
    }
  }
  return image;
}

TEST(MatcherThreads, ResultIsTheSameForAnyNumberOfThreads) {
  posix::WorkerThreads workers({.threads = 4});
  for (const Size size : {Size{1, 1}, Size{40, 1}, Size{70, 3}, Size{50, 41}, Size{67, 130}}) {
    const std::vector<std::uint8_t> left = picture(size, 0, 1);
    const std::vector<std::uint8_t> right = picture(size, 6, 2);
    std::size_t kind = 0;
    for (const MatchParams& params : every_kind()) {
      const Found alone = match(params, size, left, right, {});
      for (int threads = 1; threads <= 4; ++threads) {
        ASSERT_TRUE(match(params, size, left, right, ThreadTeam(workers, threads)) == alone)
            << size.width << "x" << size.height << ", kind " << kind << ", " << threads
            << " threads";
      }
      ++kind;
    }
  }
}

TEST(MatcherThreads, FindsWhatIsThere) {
  const Size size{90, 100};
  posix::WorkerThreads workers({.threads = 3});
  const Found found = match(as_the_appliance(find_preset("quality")->params), size,
                            picture(size, 0, 1), picture(size, 6, 2), ThreadTeam(workers, 3));
  const auto near = [](Disparity d) {
    return d.valid() && std::abs(d.raw - 6 * Disparity::kOne) <= Disparity::kOne / 2;
  };
  EXPECT_GE(std::ranges::count_if(found.disparity, near), size.width * size.height * 7 / 10);
}

TEST(MatcherThreads, EachThreadTakesMemoryOfItsOwn) {
  const MatchParams params = as_the_appliance(find_preset("quality")->params);
  const std::size_t one = bytes_of(params, {640, 480}, 1);
  const std::size_t two = bytes_of(params, {640, 480}, 2);
  const std::size_t three = bytes_of(params, {640, 480}, 3);
  EXPECT_GT(two, one);
  EXPECT_LT(three, 3 * one);
}

}  // namespace
}  // namespace stof::lab
