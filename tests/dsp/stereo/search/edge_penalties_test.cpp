#include "dsp/stereo/search/edge_penalties.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

template <typename Cost>
class EdgePenalty : public testing::Test {};
using Costs = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(EdgePenalty, Costs);

TYPED_TEST(EdgePenalty, HalvesAtEdgesAndQuartersAtStrongOnesButNotBelowSmall) {
  const EdgePenalties<TypeParam> penalties{.small = 12, .large = 40, .edge = 16, .strong_edge = 32};
  const std::vector<std::uint8_t> row{100, 116, 133, 101, 68, 255};
  std::vector<TypeParam> large(7);
  edge_penalties_along(std::span<const std::uint8_t>(row), penalties, std::span<TypeParam>(large));
  EXPECT_EQ(large, (std::vector<TypeParam>{40, 40, 20, 20, 12, 12, 40}));
}

TYPED_TEST(EdgePenalty, BetweenRowsComparesTheColumnThePathComesFrom) {
  const EdgePenalties<TypeParam> penalties{.small = 1, .large = 40, .edge = 16, .strong_edge = 32};
  const std::vector<std::uint8_t> here{100, 100, 100};
  const std::vector<std::uint8_t> before{100, 120, 200};
  const auto run = [&](int shift) {
    std::vector<TypeParam> large(3);
    edge_penalties_across(std::span<const std::uint8_t>(here),
                          std::span<const std::uint8_t>(before), shift, penalties,
                          std::span<TypeParam>(large));
    return large;
  };
  EXPECT_EQ(run(0), (std::vector<TypeParam>{40, 20, 10}));
  EXPECT_EQ(run(1), (std::vector<TypeParam>{40, 40, 20}));   // from x - 1
  EXPECT_EQ(run(-1), (std::vector<TypeParam>{20, 10, 40}));  // from x + 1
}

TYPED_TEST(EdgePenalty, RowsOfNoAndOneColumn) {
  const EdgePenalties<TypeParam> penalties{.small = 1, .large = 40};
  const std::vector<std::uint8_t> row{9};
  std::vector<TypeParam> large{0};
  edge_penalties_along(std::span<const std::uint8_t>(), penalties, std::span<TypeParam>(large));
  EXPECT_EQ(large[0], 40);
  for (const int shift : {-1, 0, 1}) {
    large[0] = 0;
    edge_penalties_across(std::span<const std::uint8_t>(row), std::span<const std::uint8_t>(row),
                          shift, penalties, std::span<TypeParam>(large));
    EXPECT_EQ(large[0], 40);
  }
  edge_penalties_across(std::span<const std::uint8_t>(), std::span<const std::uint8_t>(), -1,
                        penalties, std::span<TypeParam>());
}

}  // namespace
}  // namespace stof::dsp
