#include "firmware/update/trial.h"

#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

namespace stof::update {
namespace {

using namespace std::chrono_literals;
using Verdict = Trial::Verdict;

constexpr hal::Duration kTurn = 20ms;
constexpr hal::Duration kPeriod = 33ms;

struct Ended {
  Verdict verdict = Verdict::kOpen;
  hal::Duration after{};
};

// A sensor that publishes what `at` says, from its start on.
Ended run(Shown before, const std::function<Published(hal::Duration)>& at,
          hal::Duration period = kPeriod, hal::Duration most = 10min) {
  Trial trial(before);
  const hal::Time start{1h};
  for (hal::Duration t{}; t < most; t += kTurn) {
    const Verdict verdict = trial.tick(start + t, at(t), period);
    if (verdict != Verdict::kOpen) {
      return {verdict, t};
    }
  }
  return {};
}

std::uint64_t count(hal::Duration t, hal::Duration period = kPeriod) {
  return static_cast<std::uint64_t>(t / period) + 1;
}
Published all(hal::Duration t) { return {count(t), count(t), count(t), count(t)}; }

TEST(Trial, ThirtySecondsOfWhatWasPublishedBeforeConfirm) {
  const Ended ended = run(kAllShown, all);
  EXPECT_EQ(ended.verdict, Verdict::kConfirmed);
  EXPECT_EQ(ended.after, Trial::kProof);
}

TEST(Trial, TimeBeforeTheFirstFrameDoesNotCount) {
  const Ended ended = run(
      kAllShown, [](hal::Duration t) { return t < 20s ? Published{.rounds = count(t)} : all(t); });
  EXPECT_EQ(ended.verdict, Verdict::kConfirmed);
  EXPECT_EQ(ended.after, 20s + Trial::kProof);
}

TEST(Trial, AProgramThatNeverSendsAFrameIsLeftWithin90Seconds) {
  const Ended ended = run(kAllShown, [](hal::Duration t) { return Published{.rounds = count(t)}; });
  EXPECT_EQ(ended.verdict, Verdict::kLeft);
  EXPECT_LE(ended.after, 70s);  // the start of the kernel comes on top
}

TEST(Trial, AKindThatWasThereBeforeIsMissed) {
  for (const Shown missing : {Shown{2}, Shown{4}, Shown{8}}) {
    const auto at = [missing](hal::Duration t) {
      Published published = all(t);
      published.frames = missing == 2 ? 0 : published.frames;
      published.with_pair = missing == 4 ? 0 : published.with_pair;
      published.with_pmd = missing == 8 ? 0 : published.with_pmd;
      return published;
    };
    EXPECT_EQ(run(kAllShown, at).verdict, Verdict::kLeft) << int{missing};
    // A camera that was broken before blocks nothing.
    EXPECT_EQ(run(static_cast<Shown>(kAllShown & ~missing), at).verdict, Verdict::kConfirmed);
  }
}

TEST(Trial, AStartOfTheProgramAloneConfirmsNothing) {
  EXPECT_EQ(run(0, [](hal::Duration) { return Published{}; }).verdict, Verdict::kLeft);
  EXPECT_EQ(run(0, [](hal::Duration t) { return Published{.rounds = count(t)}; }).verdict,
            Verdict::kConfirmed);
}

TEST(Trial, AGapBeginsTheHalfMinuteAnew) {
  const auto at = [](hal::Duration t) {  // nothing between 10 s and 20 s
    return all(t < 10s ? t : std::max<hal::Duration>(10s, t - 10s));
  };
  const Ended ended = run(kAllShown, at);
  EXPECT_EQ(ended.verdict, Verdict::kConfirmed);
  EXPECT_GE(ended.after, 20s + Trial::kProof);
  EXPECT_LT(ended.after, 21s + Trial::kProof);
}

TEST(Trial, AFrameInEachGapButOneIsLeftWhenTheTimeIsOver) {
  // A frame every 4 s never fills a gap of 3 s.
  const Ended ended = run(kAllShown, [](hal::Duration t) { return all(t / 4s * 4s); });
  EXPECT_EQ(ended.verdict, Verdict::kLeft);
}

TEST(Trial, ASensorOfAFrameAMinuteHasItsTime) {
  const Ended ended = run(
      kAllShown,
      [](hal::Duration t) {
        const std::uint64_t n = count(t, 60s) - 1;
        return Published{n, n, n, n};
      },
      60s, 1h);
  EXPECT_EQ(ended.verdict, Verdict::kConfirmed);
  EXPECT_GE(ended.after, 60s + Trial::kProof);
}

TEST(Trial, AVerdictStays) {
  Trial trial(kAllShown);
  const hal::Time start{1h};
  for (hal::Duration t{}; t <= Trial::kProof; t += kTurn) {
    static_cast<void>(trial.tick(start + t, all(t), kPeriod));
  }
  EXPECT_EQ(trial.tick(start + 1h, all(31s), kPeriod), Verdict::kConfirmed);
}

TEST(ShownLately, AreTheKindsThatRoseInTheSpan) {
  ShownLately lately;
  const hal::Time start{1h};
  lately.note(start, {});
  EXPECT_EQ(lately.within(start, 10s), 0);
  lately.note(start + 1s, {.rounds = 5, .frames = 4, .with_pair = 4, .with_pmd = 0});
  lately.note(start + 8s, {.rounds = 9, .frames = 8, .with_pair = 4, .with_pmd = 0});
  EXPECT_EQ(lately.within(start + 8s, 10s), 7);
  EXPECT_EQ(lately.within(start + 12s, 10s), 3);  // the pair was lost
  EXPECT_EQ(lately.within(start + 19s, 10s), 0);
}

}  // namespace
}  // namespace stof::update
