#include "dsp/stereo/search/sum_paths.h"

#include <algorithm>
#include <limits>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

template <typename Cost, typename Sum>
void expect_equal_sums() {
  for (std::size_t count = 2; count <= 8; ++count) {
    for (const std::size_t n : {0U, 16U, 32U, 48U, 160U}) {
      test::Random random(n + count);
      std::vector<test::GuardedBuffer<Cost>> rows;
      std::vector<const Cost*> pointers;
      for (std::size_t k = 0; k < count; ++k) {
        rows.emplace_back(n);
        random.fill(rows.back().span(), 0, std::is_same_v<Cost, std::uint8_t> ? 255 : 8191);
        pointers.push_back(rows.back().span().data());
      }
      test::GuardedBuffer<Sum> reference(n);
      ref::sum_paths(std::span<const Cost* const>(pointers), reference.span());
      for (const Vectors vectors : test::all_vectors()) {
        const test::UseVectors use(vectors);
        test::GuardedBuffer<Sum> fast(n);
        best::sum_paths(std::span<const Cost* const>(pointers), fast.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), fast.span())) << count << ", " << n;
      }
      for (std::size_t i = 0; i < n; ++i) {
        std::size_t total = 0;
        for (const Cost* const row : pointers) {
          total += row[i];
        }
        ASSERT_EQ(reference[i], std::min<std::size_t>(total, std::numeric_limits<Sum>::max()));
      }
    }
  }
}

TEST(SumPaths, VectorsEqualTheReferenceForEveryNumberOfDirections) {
  expect_equal_sums<std::uint8_t, std::uint8_t>();
  expect_equal_sums<std::uint8_t, std::uint16_t>();
  expect_equal_sums<std::uint16_t, std::uint16_t>();
}

}  // namespace
}  // namespace stof::dsp
