#include "tests/support/kernel_check.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "dsp/base/target.h"

namespace stof::test {
namespace {

using dsp::Vectors;
using Draw = KernelCase::Draw;

constexpr std::array<const char*, dsp::kVectorLevels> kNames{"ref", "neon", "avx2", "avx512"};
constexpr std::array kDraws{Draw::kAny, Draw::kEnds, Draw::kLowest, Draw::kHighest};

#if defined(STOF_MUTATE_STORES)
constexpr bool kMutated = true;
#else
constexpr bool kMutated = false;
#endif

const char* name_of(Vectors level) { return kNames[static_cast<std::size_t>(level)]; }

// ns of each test at each level; 0 where it was not run.
std::map<std::string, std::array<double, dsp::kVectorLevels>>& times() {
  static std::map<std::string, std::array<double, dsp::kVectorLevels>> all;
  return all;
}

bool timed() {
  static const bool asked = std::getenv("STOF_KERNEL_TIMES") != nullptr;
  return asked;
}

std::string this_test() {
  const testing::TestInfo* const info = testing::UnitTest::GetInstance()->current_test_info();
  return std::string(info->test_suite_name()) + "." + info->name();
}

// Which arrays the reference wrote, and of which another level made something else.
struct Judgement {
  std::vector<bool> written;
  std::vector<bool> different;

  void add(const KernelCase& reference, const KernelCase& level) {
    written.resize(std::max(written.size(), reference.arrays()));
    different.resize(written.size());
    for (std::size_t k = 0; k < reference.arrays(); ++k) {
      written[k] = written[k] || reference.changed(k);
      if (!std::ranges::equal(reference.bytes(k), level.bytes(k))) {
        different[k] = true;
      }
    }
  }
};

// Where two arrays begin to differ, in words.
std::string difference(const KernelCase& reference, const KernelCase& level) {
  if (reference.arrays() != level.arrays()) {
    return "the number of arrays";
  }
  for (std::size_t k = 0; k < reference.arrays(); ++k) {
    const auto [a, b] = std::ranges::mismatch(reference.bytes(k), level.bytes(k));
    if (a != reference.bytes(k).end() || b != level.bytes(k).end()) {
      return "array " + std::to_string(k) + ", byte " +
             std::to_string(a - reference.bytes(k).begin()) + " of " +
             std::to_string(reference.bytes(k).size());
    }
  }
  return "";
}

KernelCase made_by(const KernelBody& body, Vectors level, std::size_t length, std::uint64_t seed,
                   Draw draw, bool timed) {
  const dsp::UseVectors use(level);
  KernelCase made(length, seed, draw, timed);
  body(made);
  return made;
}

// A build with STOF_MUTATE_STORES mutates what each level but the reference stores: a test must
// have seen it in each array that the kernel wrote, in one of its comparisons.
struct ComparedLevel {
  Vectors level;
  Judgement judgement;
};
bool survived = false;

// What this run of the program compares with the reference.
std::vector<ComparedLevel>& compared() {
  static std::vector<ComparedLevel> levels;
  return levels;
}

void judge_mutation() {
  for (auto& [level, judgement] : compared()) {
    const Judgement judged = std::exchange(judgement, {});
    for (std::size_t k = 0; kMutated && k < judged.written.size(); ++k) {
      if (judged.written[k] && !judged.different[k]) {
        std::printf("survived: %s, array %zu of %s is wrong and equals the reference\n",
                    name_of(level), k, this_test().c_str());
        survived = true;
      }
    }
  }
}

// False where the rest need not be looked at.
bool compare(const KernelBody& body, std::size_t length, std::uint64_t seed, Draw draw) {
  const KernelCase reference = made_by(body, Vectors::kRef, length, seed, draw, false);
  for (auto& [level, judgement] : compared()) {
    const KernelCase other = made_by(body, level, length, seed, draw, false);
    judgement.add(reference, other);
    const std::string where = difference(reference, other);
    if (!kMutated && !where.empty()) {
      ADD_FAILURE() << name_of(level) << " differs from the reference in " << where << ": length "
                    << length << ", seed " << seed << ", draw " << static_cast<int>(draw);
      return false;
    }
  }
  return true;
}

// Every level is compared in the run at the first of them, so that the reference, which takes
// longest, runs once.
bool compares_now() { return !compared().empty() && dsp::vectors() == compared().front().level; }

void note_time(const KernelBody& body, std::size_t length) {
  if (timed()) {
    const KernelCase made = made_by(body, dsp::vectors(), length, 1, Draw::kAny, true);
    times()[this_test()][static_cast<std::size_t>(dsp::vectors())] += made.nanoseconds();
  }
}

// long double is computed in registers that a kernel could leave taken (MMX); the sum then is not a
// number, and so is what libraries compute behind it.
void check_long_double() {
  const volatile long double one = 1;
  EXPECT_EQ(one + one, 2.0L) << "a kernel left the registers of long double taken";
}

class EveryLevel : public testing::EmptyTestEventListener {
 public:
  explicit EveryLevel(int first) : first_(first) {}
  void OnTestIterationStart(const testing::UnitTest& /*all*/, int iteration) override {
    dsp::use_vectors(static_cast<Vectors>(first_ + iteration));
    std::printf("[ LEVEL    ] %s\n", name_of(dsp::vectors()));
  }
  void OnTestEnd(const testing::TestInfo& /*test*/) override {
    judge_mutation();
    check_long_double();
  }

 private:
  int first_;
};

void print_times() {
  for (const auto& [test, at] : times()) {
    std::printf("[ TIME     ] %-60s", test.c_str());
    for (std::size_t level = 0; level < at.size(); ++level) {
      if (at[level] > 0) {
        std::printf("  %s %.0f ns", kNames[level], at[level]);
      } else {
        std::printf("  %s -", kNames[level]);
      }
    }
    std::printf("\n");
  }
}

}  // namespace

void KernelCase::run(const std::function<void()>& kernel) {
  for (std::size_t k = before_.size(); k < buffers_.size(); ++k) {
    before_.emplace_back(buffers_[k].span().begin(), buffers_[k].span().end());
  }
  kernel();
  if (!timed_) {
    return;
  }
  using Clock = std::chrono::steady_clock;
  double fastest = std::numeric_limits<double>::max();
  for (int round = 0; round < 20; ++round) {
    constexpr int kCalls = 20;
    const Clock::time_point begin = Clock::now();
    for (int call = 0; call < kCalls; ++call) {
      kernel();
    }
    const std::chrono::duration<double, std::nano> took = Clock::now() - begin;
    fastest = std::min(fastest, took.count() / kCalls);
  }
  nanoseconds_ += fastest;
}

bool KernelCase::changed(std::size_t k) const {
  return k < before_.size() && !std::ranges::equal(before_[k], buffers_[k].span());
}

bool check_kernel(std::span<const std::size_t> lengths, const KernelBody& body) {
  note_time(body, lengths.back());
  for (const std::size_t length : lengths) {
    for (const Draw draw : kDraws) {
      if (!compares_now() || !compare(body, length, length + 1, draw)) {
        return compares_now();
      }
    }
  }
  return true;
}

bool check_kernel_rounds(std::size_t rounds, const KernelBody& body) {
  note_time(body, rounds - 1);
  for (std::size_t round = 0; round < rounds; ++round) {
    if (!compares_now() || !compare(body, round, round + 1, kDraws[round % 8 == 7 ? 1 : 0])) {
      return compares_now();
    }
  }
  return true;
}

}  // namespace stof::test

int main(int argc, char** argv) {
  using stof::dsp::Vectors;
  testing::InitGoogleTest(&argc, argv);
  const int levels = static_cast<int>(stof::dsp::widest_vectors()) + 1;
  // STOF_KERNEL_LEVEL=avx2: that one alone.
  const char* const only = std::getenv("STOF_KERNEL_LEVEL");
  int first = 0;
  while (only != nullptr && first + 1 < levels &&
         only != std::string(stof::test::name_of(static_cast<Vectors>(first)))) {
    ++first;
  }
  GTEST_FLAG_SET(repeat, only == nullptr ? levels : 1);
  testing::UnitTest::GetInstance()->listeners().Append(new stof::test::EveryLevel(first));
  const int last = only == nullptr ? levels - 1 : first;
  for (int level = std::max(first, 1); level <= last; ++level) {
    stof::test::compared().push_back({static_cast<Vectors>(level), {}});
  }
  const int result = RUN_ALL_TESTS();
  for (int level = levels; level <= static_cast<int>(stof::dsp::kWidestBuilt); ++level) {
    std::printf("[  SKIPPED ] level %s: this processor lacks it\n",
                stof::test::name_of(static_cast<Vectors>(level)));
  }
  stof::test::print_times();
  return stof::test::survived ? 1 : result;
}
