#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/target.h"
#include "firmware/wire/codec/rvl_decode.h"
#include "firmware/wire/codec/rvl_encode.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/long_tests.h"
#include "tests/support/random.h"

namespace stof::wire {
namespace {

using test::GuardedBuffer;
using test::Random;

template <typename T>
struct Sample {
  std::string name;
  std::vector<T> values;
};

template <typename T>
std::vector<Sample<T>> samples() {
  constexpr int kTop = std::numeric_limits<T>::max();
  std::vector<Sample<T>> all;
  for (const std::size_t size : {1U, 2U, 7U, 8U, 9U, 63U, 64U, 65U, 640U, 4096U}) {
    Random random(size);
    std::vector<T> values(size);
    const std::string at = " of " + std::to_string(size);
    all.push_back({"zeros" + at, values});
    random.fill(std::span(values));
    all.push_back({"noise" + at, values});
    std::ranges::fill(values, static_cast<T>(kTop));
    all.push_back({"maximum" + at, values});
    for (std::size_t i = 0; i < size; ++i) {
      values[i] = static_cast<T>(i);
    }
    all.push_back({"rising" + at, values});
    std::ranges::reverse(values);
    all.push_back({"falling" + at, values});
    for (std::size_t i = 0; i < size; ++i) {
      values[i] = static_cast<T>(i % 2 * static_cast<std::size_t>(kTop));
    }
    all.push_back({"alternating" + at, values});
    int level = kTop / 2;
    for (T& value : values) {
      level = std::clamp(level + random.between(-9, 9), 1, kTop);
      value = random.between(0, 20) == 0 ? T{0} : static_cast<T>(level);
    }
    all.push_back({"walk with holes" + at, values});
  }
  return all;
}

// Codes into memory that ends at an unreadable page, decodes from and to such memory.
template <typename T>
void expect_round_trip(const Sample<T>& sample, std::size_t space) {
  SCOPED_TRACE(sample.name + " into " + std::to_string(space) + " bytes");
  GuardedBuffer<T> values(sample.values.size());
  std::ranges::copy(sample.values, values.span().begin());
  GuardedBuffer<std::byte> out(space, std::byte{0xEE});
  const RvlCoded coded = rvl_encode<T>(values.span(), out.span());
  ASSERT_LE(coded.bytes, space);
  ASSERT_EQ(coded.bytes % 4, 0U);
  ASSERT_LE(coded.values, values.size());

  GuardedBuffer<std::byte> in(coded.bytes);
  std::ranges::copy(out.span().first(coded.bytes), in.span().begin());
  GuardedBuffer<T> back(coded.values);
  ASSERT_EQ(rvl_decode<T>(in.span(), back.span()), Status::kOk);
  EXPECT_TRUE(std::ranges::equal(back.span(), std::span(sample.values).first(coded.values)));
}

template <typename T>
void expect_all_round_trips() {
  for (const Sample<T>& sample : samples<T>()) {
    for (const std::size_t space : {0U, 3U, 4U, 7U, 8U, 12U, 100U, 1158U}) {
      expect_round_trip(sample, space);
    }
    const std::size_t enough = 8 + 4 * sample.values.size();
    expect_round_trip(sample, enough);
    std::vector<std::byte> out(enough);
    EXPECT_EQ(rvl_encode<T>(sample.values, out).values, sample.values.size()) << sample.name;
  }
}

TEST(RvlTest, CodesTheWorkedExample) {
  const std::array<std::uint16_t, 6> values{0, 0, 5, 7, 7, 0};
  const std::array<std::byte, 4> bytes{std::byte{0x10}, std::byte{0x40}, std::byte{0xA1},
                                       std::byte{0x23}};
  std::array<std::byte, 8> out{};
  const RvlCoded coded = rvl_encode<std::uint16_t>(values, out);
  EXPECT_EQ(coded.values, 6U);
  ASSERT_EQ(coded.bytes, 4U);
  EXPECT_TRUE(std::ranges::equal(std::span(out).first<4>(), bytes));
  std::array<std::uint16_t, 6> back{};
  EXPECT_EQ(rvl_decode<std::uint16_t>(bytes, back), Status::kOk);
  EXPECT_EQ(back, values);
}

TEST(RvlTest, GivesBackWhatItCoded16) { expect_all_round_trips<std::uint16_t>(); }
TEST(RvlTest, GivesBackWhatItCoded8) { expect_all_round_trips<std::uint8_t>(); }

// What is compiled for all processors, and for those with longer vectors.
template <typename T>
void expect_same_on_all_processors() {
  Random random(11);
  for (const Sample<T>& sample : samples<T>()) {
    for (const std::size_t space : {4U, 12U, 1112U, 20'000U}) {
      std::array<std::vector<std::byte>, 2> codes;
      std::array<std::uint32_t, 2> least{};
      for (const bool avx2 : {false, true}) {
        const dsp::UseVectors use(avx2 ? dsp::Vectors::kAvx2 : dsp::Vectors::kNeon);
        least[avx2 ? 1 : 0] = rvl_least_nibbles<T>(sample.values);
        GuardedBuffer<std::byte> out(space);
        const RvlCoded coded = rvl_encode<T>(sample.values, out.span());
        codes[avx2 ? 1 : 0].assign(out.span().begin(),
                                   out.span().begin() + static_cast<std::ptrdiff_t>(coded.bytes));
      }
      ASSERT_EQ(codes[0], codes[1]) << sample.name;
      ASSERT_EQ(least[0], least[1]) << sample.name;
      for (int damage = 0; damage < 4 && !codes[0].empty(); ++damage) {
        std::array<std::vector<T>, 2> back{std::vector<T>(sample.values.size()),
                                           std::vector<T>(sample.values.size())};
        const auto decode = [&codes](dsp::Vectors vectors, std::vector<T>& values) {
          const dsp::UseVectors use(vectors);
          return rvl_decode<T>(codes[0], values);
        };
        const Status status = decode(dsp::Vectors::kNeon, back[0]);
        ASSERT_EQ(decode(dsp::Vectors::kAvx2, back[1]), status) << sample.name;
        ASSERT_TRUE(status != Status::kOk || back[0] == back[1]) << sample.name;
        codes[0][random.next() % codes[0].size()] ^= static_cast<std::byte>(random.next());
      }
    }
  }
}

TEST(RvlTest, IsTheSameOnAllProcessors) {
  if (dsp::widest_vectors() < dsp::Vectors::kAvx2) {
    GTEST_SKIP() << "this processor runs one kind of code only";
  }
  expect_same_on_all_processors<std::uint16_t>();
  expect_same_on_all_processors<std::uint8_t>();
}

TEST(RvlTest, EveryPairOfValuesComesBack) {
  std::array<std::byte, 8> out{};
  for (unsigned first = 0; first < 256; ++first) {
    for (unsigned second = 0; second < 256; ++second) {
      const std::array<std::uint8_t, 2> values{static_cast<std::uint8_t>(first),
                                               static_cast<std::uint8_t>(second)};
      std::array<std::uint8_t, 2> back{};
      const RvlCoded coded = rvl_encode<std::uint8_t>(values, out);
      ASSERT_EQ(coded.values, 2U);
      ASSERT_EQ(rvl_decode<std::uint8_t>(std::span(out).first(coded.bytes), back), Status::kOk);
      ASSERT_EQ(back, values);
    }
  }
}

TEST(RvlTest, TakesAsManyValuesAsFit) {
  Random random(3);
  std::vector<std::uint16_t> values(2000);
  random.fill(std::span(values), 0, 3000);
  for (std::size_t space = 8; space < 400; space += 4) {
    std::vector<std::byte> out(space);
    const std::size_t fit = rvl_encode<std::uint16_t>(values, out).values;
    ASSERT_LT(fit, values.size());
    std::vector<std::byte> more(2 * space);
    const auto next = std::span<const std::uint16_t>(values).first(fit + 1);
    const RvlFit one_more = rvl_fit<std::uint16_t>(next, fit + 1, 1, more);
    EXPECT_GT(one_more.all.nibbles + 5, 2 * space) << space;
  }
}

TEST(RvlTest, TakesAllValuesIfTheyFit) {
  Random random(4);
  for (int run = 0; run < 300; ++run) {
    std::vector<std::uint16_t> values(static_cast<std::size_t>(random.between(1, 700)));
    random.fill(std::span(values), 0, random.between(1, 3000));
    std::vector<std::byte> out(4 * values.size() + 8);
    const std::size_t bytes = rvl_encode<std::uint16_t>(values, out).bytes;
    EXPECT_EQ(rvl_encode<std::uint16_t>(values, std::span(out).first(bytes)).values, values.size());
    EXPECT_LT(rvl_encode<std::uint16_t>(values, std::span(out).first(bytes - 4)).values,
              values.size());
  }
}

// No sequence is shorter than what is said of any part of it.
TEST(RvlTest, NoCodeIsShorterThanItsLeastNibbles) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Random random(seed);
    std::vector<std::uint16_t> values(static_cast<std::size_t>(random.between(1, 300)));
    random.fill(std::span(values), 0, random.between(0, 1) == 0 ? 8 : 65535);
    for (std::uint16_t& value : values) {
      value = random.between(0, 5) == 0 ? std::uint16_t{0} : value;
    }
    std::vector<std::byte> out(4 * values.size() + 8);
    const std::uint32_t whole = rvl_fit<std::uint16_t>(values, values.size(), 1, out).all.nibbles;
    const std::span<const std::uint16_t> all(values);
    const std::size_t half = values.size() / 2;
    EXPECT_LE(rvl_least_nibbles(all), whole) << "seed " << seed;
    EXPECT_LE(rvl_least_nibbles(all.first(half)) + rvl_least_nibbles(all.subspan(half)), whole)
        << "seed " << seed;
  }
}

TEST(RvlTest, LeastNibblesOfKnownValues) {
  // Differences of one nibble up to -4 and 3, of two up to -32 and 31.
  const std::vector<std::uint16_t> near{100, 103, 99, 103, 71, 102, 70, 101, 133, 133};
  // 1 behind no known value; then 1, 1, 2, 2, 2, 2, 2, 3, 1.
  EXPECT_EQ(rvl_least_nibbles<std::uint16_t>(near), 17U);
  // One for each value behind a hole and for each run that begins: 1, 1 + 1, 0, 0, 1 + 1, 1.
  const std::vector<std::uint16_t> holes{500, 0, 0, 9000, 9001};
  EXPECT_EQ(rvl_least_nibbles<std::uint16_t>(holes), 5U);
}

// A sequence cut at the last row that fits is that of the whole rows, whatever its last run was.
TEST(RvlTest, EndsWithARowOrWithTheLastValue) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed);
    const auto row = static_cast<std::size_t>(random.between(1, 90));
    const auto first_row = static_cast<std::size_t>(random.between(1, static_cast<int>(row)));
    std::vector<std::uint16_t> values(first_row + row * 20);
    const int holes = random.between(0, 3);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool hole = (i / 50) % 4 < static_cast<std::size_t>(holes);
      values[i] = hole ? std::uint16_t{0} : static_cast<std::uint16_t>(random.between(0, 600));
    }
    for (const bool rows : {false, true}) {
      std::vector<std::byte> out(static_cast<std::size_t>(random.between(8, 600)), std::byte{0xFF});
      const RvlFit fit = rvl_fit<std::uint16_t>(values, first_row, row, out);
      const std::size_t past =
          fit.all.values < first_row ? 0 : first_row + (fit.all.values - first_row) / row * row;
      ASSERT_EQ(fit.rows.values, past) << "seed " << seed;
      const RvlCut& cut = rows ? fit.rows : fit.all;
      const std::size_t bytes = rvl_finish(cut, out);
      ASSERT_EQ(bytes, rvl_bytes(cut));
      ASSERT_LE(bytes, out.size());
      std::vector<std::uint16_t> back(cut.values);
      ASSERT_EQ(rvl_decode<std::uint16_t>(std::span(out).first(bytes), back), Status::kOk)
          << "seed " << seed;
      EXPECT_TRUE(std::ranges::equal(back, std::span(values).first(cut.values)));
    }
  }
}

TEST(RvlTest, RefusesEveryTruncationAndEveryWordMore) {
  for (const Sample<std::uint16_t>& sample : samples<std::uint16_t>()) {
    std::vector<std::byte> out(8 + 4 * sample.values.size());
    const std::size_t bytes = rvl_encode<std::uint16_t>(sample.values, out).bytes;
    std::vector<std::uint16_t> back(sample.values.size());
    const std::size_t step = std::max<std::size_t>(1, bytes / 200);
    for (std::size_t cut = 0; cut < bytes; cut += step) {
      GuardedBuffer<std::byte> in(cut);
      std::ranges::copy(std::span(out).first(cut), in.span().begin());
      ASSERT_EQ(rvl_decode<std::uint16_t>(in.span(), back), Status::kCorrupt)
          << sample.name << " cut to " << cut;
    }
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(bytes), out.end(), std::byte{});
    EXPECT_EQ(rvl_decode<std::uint16_t>(std::span(out).first(bytes + 4), back), Status::kCorrupt);
    back.push_back(0);
    EXPECT_EQ(rvl_decode<std::uint16_t>(std::span(out).first(bytes), back), Status::kCorrupt);
    back.resize(back.size() - 2);
    EXPECT_EQ(rvl_decode<std::uint16_t>(std::span(out).first(bytes), back), Status::kCorrupt);
  }
}

struct Word {
  const char* name;
  std::uint32_t word;
  std::size_t values;
  Status status;
};

TEST(RvlTest, DecodesWordsAsTheFormatSays) {
  for (const Word& c : {Word{"zeros only", 0x30000000, 3, Status::kOk},
                        Word{"behind the end something", 0x30000001, 3, Status::kCorrupt},
                        Word{"a hole", 0x01211000, 3, Status::kOk},
                        Word{"others in two parts", 0x01201200, 2, Status::kOk},
                        Word{"a longer number than needed", 0xB0000000, 3, Status::kOk},
                        Word{"six nibbles", 0xB8888000, 3, Status::kOk},
                        Word{"seven nibbles", 0xB8888800, 3, Status::kCorrupt},
                        Word{"all of them go on", 0xFFFFFFFF, 3, Status::kCorrupt},
                        Word{"an empty run within", 0x10102000, 3, Status::kCorrupt},
                        Word{"more others than pixels", 0x04222200, 3, Status::kCorrupt},
                        Word{"more zeros than pixels", 0x40000000, 3, Status::kCorrupt},
                        Word{"a difference to zero", 0x02210000, 2, Status::kOk}}) {
    const std::array<std::byte, 4> in{
        static_cast<std::byte>(c.word), static_cast<std::byte>(c.word >> 8),
        static_cast<std::byte>(c.word >> 16), static_cast<std::byte>(c.word >> 24)};
    std::vector<std::uint16_t> values(c.values);
    EXPECT_EQ(rvl_decode<std::uint16_t>(in, values), c.status) << c.name;
  }
}

TEST(RvlTest, NothingAtAllIsNoBytes) {
  EXPECT_EQ(rvl_encode<std::uint8_t>({}, {}).bytes, 0U);
  EXPECT_EQ(rvl_decode<std::uint8_t>({}, {}), Status::kOk);
  const std::array<std::byte, 4> word{};
  EXPECT_EQ(rvl_decode<std::uint8_t>(word, {}), Status::kCorrupt);
}

// STOF_LONG=1: a million of each.
TEST(RvlTest, SurvivesAnyBytes) {
  for (std::uint64_t seed = 0; seed < (test::long_tests() ? 1'000'000U : 5'000U); ++seed) {
    Random random(seed);
    GuardedBuffer<std::byte> in(static_cast<std::size_t>(random.between(0, 40)));
    const int most = random.between(0, 1) == 0 ? 0x33 : 0xFF;  // small numbers get further
    for (std::size_t i = 0; i < in.size(); ++i) {
      in[i] = static_cast<std::byte>(random.between(0, 255) & most);
    }
    GuardedBuffer<std::uint16_t> values16(static_cast<std::size_t>(random.between(0, 100)));
    GuardedBuffer<std::uint8_t> values8(values16.size());
    const Status status16 = rvl_decode<std::uint16_t>(in.span(), values16.span());
    const Status status8 = rvl_decode<std::uint8_t>(in.span(), values8.span());
    ASSERT_EQ(status16, status8) << "seed " << seed;  // both read the same numbers
  }
}

}  // namespace
}  // namespace stof::wire
