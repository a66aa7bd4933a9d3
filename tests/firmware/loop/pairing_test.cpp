#include "firmware/loop/pairing.h"

#include <array>
#include <chrono>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;

constexpr hal::Time kEdge{std::chrono::seconds(1000)};
constexpr ExposureWindow kWindow{kEdge, 4ms, 200us};
constexpr hal::Time kEarliest = hal::Time::min();
constexpr hal::Time kLatest = hal::Time::max();

hal::Exposure at(hal::Duration after, hal::Duration length = 4ms) {
  return {kEdge + after, kEdge + after + length};
}

TEST(MatchExposure, TakesExposuresThatBeginWithinTheToleranceAndNoOthers) {
  EXPECT_EQ(match_exposure(kWindow, at(0ns)), Drop::kNone);
  EXPECT_EQ(match_exposure(kWindow, at(200us)), Drop::kNone);
  EXPECT_EQ(match_exposure(kWindow, at(-200us)), Drop::kNone);
  EXPECT_EQ(match_exposure(kWindow, at(200us + 1ns)), Drop::kNewerEdge);
  EXPECT_EQ(match_exposure(kWindow, at(-200us - 1ns)), Drop::kOlderEdge);
}

TEST(MatchExposure, TakesExposuresAsLongAsTheSensorExposesAndNoLonger) {
  EXPECT_EQ(match_exposure(kWindow, at(0ns, 1ns)), Drop::kNone);
  EXPECT_EQ(match_exposure(kWindow, at(0ns, 4ms + 200us)), Drop::kNone);
  EXPECT_EQ(match_exposure(kWindow, at(200us, 4ms + 200us)), Drop::kNone);
  EXPECT_EQ(match_exposure(kWindow, at(0ns, 4ms + 200us + 1ns)), Drop::kBadStamp);
  EXPECT_EQ(match_exposure(kWindow, at(0ns, 0ns)), Drop::kBadStamp);
  EXPECT_EQ(match_exposure(kWindow, at(0ns, -1ns)), Drop::kBadStamp);
}

// Under UndefinedBehaviorSanitizer this also says that no stamp overflows.
TEST(MatchExposure, SurvivesEveryExtremeStamp) {
  const std::array extremes{kEarliest, kEarliest + 1ns, hal::Time{}, kEdge, kLatest - 1ns, kLatest};
  for (const hal::Time begin : extremes) {
    for (const hal::Time end : extremes) {
      EXPECT_NE(match_exposure(kWindow, {begin, end}), Drop::kNone);
    }
  }
  EXPECT_EQ(match_exposure(kWindow, {kEarliest, kLatest}), Drop::kOlderEdge);
  EXPECT_EQ(match_exposure(kWindow, {kLatest, kEarliest}), Drop::kNewerEdge);
  EXPECT_EQ(match_exposure(kWindow, {kEdge, kLatest}), Drop::kBadStamp);
}

TEST(SequenceGuard, BelievesStepsAheadAcrossTheWrap) {
  SequenceGuard guard;
  EXPECT_TRUE(guard.advances(0xFFFF'FFFE));
  guard.accept(0xFFFF'FFFE);
  EXPECT_TRUE(guard.advances(0xFFFF'FFFF));
  EXPECT_TRUE(guard.advances(0));
  EXPECT_TRUE(guard.advances(SequenceGuard::kMaxStep - 2));
  EXPECT_FALSE(guard.advances(SequenceGuard::kMaxStep - 1));
}

TEST(SequenceGuard, NeverBelievesARepeatedNumber) {
  SequenceGuard guard;
  guard.accept(41);
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(guard.advances(41));
  }
}

TEST(SequenceGuard, NeverBelievesAFewOldNumbersAgainAndAgain) {
  SequenceGuard guard;
  guard.accept(41);
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(guard.advances(38 + static_cast<std::uint32_t>(i % 3)));
  }
}

TEST(SequenceGuard, FollowsASensorThatStartedAnew) {
  SequenceGuard guard;
  guard.accept(1'000'000);
  for (std::uint32_t sequence = 1; sequence < SequenceGuard::kRestart; ++sequence) {
    EXPECT_FALSE(guard.advances(sequence)) << sequence;
  }
  EXPECT_TRUE(guard.advances(SequenceGuard::kRestart));
}

TEST(SequenceGuard, BelievesAnyNumberAfterALoss) {
  SequenceGuard guard;
  guard.accept(500);
  guard.forget();
  EXPECT_TRUE(guard.advances(3));
}

TEST(SequenceGuard, AfterAnOpeningAnyOtherNumberIsNewButTheOneThatRepeatsIsNot) {
  SequenceGuard guard;
  guard.accept(41);
  guard.expect_another();
  EXPECT_FALSE(guard.advances(41));
  EXPECT_TRUE(guard.advances(1));
  guard.accept(1);
  EXPECT_FALSE(guard.advances(1));
  EXPECT_FALSE(guard.advances(41 + SequenceGuard::kMaxStep)) << "once alone";
}

struct Stereo {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(64);
  hal::StereoFrame frame{.left = {pixels.data(), 8, 8},
                         .right = {pixels.data(), 8, 8},
                         .left_exposure = at(0ns),
                         .right_exposure = at(10us),
                         .left_sequence = 10,
                         .right_sequence = 20};
};

TEST(StereoPairing, TakesAFrameOnceOnly) {
  StereoPairing pairing(8, 8);
  Stereo stereo;
  EXPECT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kNone);
  EXPECT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kStale);
}

TEST(StereoPairing, RefusesAFrozenFrameWithFreshStamps) {
  StereoPairing pairing(8, 8);
  Stereo stereo;
  ASSERT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kNone);
  for (int i = 1; i < 50; ++i) {
    const hal::Duration later = i * 33ms;
    stereo.frame.left_exposure = at(later);
    stereo.frame.right_exposure = at(later);
    EXPECT_EQ(pairing.judge({kEdge + later, 4ms, 200us}, stereo.frame), Drop::kStale);
  }
}

TEST(StereoPairing, RefusesViewsOfDifferentExposures) {
  for (const hal::Duration apart : {-33ms, -1ms, 1ms, 33ms}) {
    StereoPairing pairing(8, 8);
    Stereo stereo;
    stereo.frame.right_exposure = at(apart);
    EXPECT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kTorn);
    std::swap(stereo.frame.left_exposure, stereo.frame.right_exposure);
    EXPECT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kTorn);
  }
}

TEST(StereoPairing, RefusesAFrameOfWhichOneViewIsRepeated) {
  StereoPairing pairing(8, 8);
  Stereo stereo;
  ASSERT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kNone);
  ++stereo.frame.left_sequence;
  EXPECT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kTorn);
}

TEST(StereoPairing, TellsOldEdgesFromNewOnes) {
  StereoPairing pairing(8, 8);
  Stereo stereo;
  stereo.frame.left_exposure = stereo.frame.right_exposure = at(-33ms);
  EXPECT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kOlderEdge);
  stereo.frame.left_exposure = stereo.frame.right_exposure = at(33ms);
  EXPECT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kNewerEdge);
}

TEST(StereoPairing, RefusesOtherSizes) {
  StereoPairing pairing(8, 7);
  Stereo stereo;
  EXPECT_EQ(pairing.judge(kWindow, stereo.frame), Drop::kWrongSize);
  stereo.frame.left = {};
  EXPECT_EQ(StereoPairing(8, 8).judge(kWindow, stereo.frame), Drop::kWrongSize);
}

constexpr ExposureWindow pmd_window(hal::Duration edge_after) {
  return {kEdge + edge_after, 16ms, 200us};
}

struct Pmd {
  std::vector<std::uint16_t> pixels = std::vector<std::uint16_t>(64);
  hal::PmdFrame frame;

  explicit Pmd(hal::Duration after = 0ns) {
    frame.sequence = 5;
    for (std::size_t k = 0; k < 4; ++k) {
      frame.samples[k] = {pixels.data(), 8, 8};
      frame.exposures[k] = at(after + static_cast<int>(k) * 4ms);
    }
  }
  Drop judge(PmdPairing& pairing) const {
    const std::array windows{pmd_window(0ns)};
    return pairing.judge(windows, frame).drop;
  }
};

TEST(PmdPairing, TakesFourSamplesOfOneEdgeOnceOnly) {
  PmdPairing pairing(8, 8);
  const Pmd pmd;
  EXPECT_EQ(pmd.judge(pairing), Drop::kNone);
  EXPECT_EQ(pmd.judge(pairing), Drop::kStale);
}

TEST(PmdPairing, RefusesAnySampleOfAnotherExposure) {
  for (std::size_t k = 0; k < 4; ++k) {
    for (const hal::Duration apart : {-33ms, 33ms}) {
      PmdPairing pairing(8, 8);
      Pmd pmd;
      pmd.frame.exposures[k].begin += apart;
      pmd.frame.exposures[k].end += apart;
      EXPECT_NE(pmd.judge(pairing), Drop::kNone) << "sample " << k;
    }
  }
}

TEST(PmdPairing, RefusesSamplesInAnotherOrderOrOnTopOfEachOther) {
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = a + 1; b < 4; ++b) {
      PmdPairing pairing(8, 8);
      Pmd swapped;
      std::swap(swapped.frame.exposures[a], swapped.frame.exposures[b]);
      EXPECT_NE(swapped.judge(pairing), Drop::kNone);
      Pmd doubled;
      doubled.frame.exposures[b] = doubled.frame.exposures[a];
      EXPECT_NE(doubled.judge(pairing), Drop::kNone);
    }
  }
}

TEST(PmdPairing, SurvivesEveryExtremeStamp) {
  const std::array extremes{kEarliest, hal::Time{}, kLatest};
  for (std::size_t k = 0; k < 4; ++k) {
    for (const hal::Time time : extremes) {
      PmdPairing pairing(8, 8);
      Pmd begin;
      begin.frame.exposures[k].begin = time;
      // An early begin of a later sample overlaps the one before it.
      EXPECT_NE(begin.judge(pairing), Drop::kNone);
      Pmd end;
      end.frame.exposures[k].end = time;
      EXPECT_NE(end.judge(pairing), Drop::kNone);
    }
  }
}

TEST(PmdPairing, FindsTheEdgeOfAFrameThatTookSeveralPeriods) {
  PmdPairing pairing(8, 8);
  const std::array windows{pmd_window(0ns), pmd_window(-33ms), pmd_window(-66ms)};
  const Pmd pmd(-66ms);
  const PmdVerdict verdict = pairing.judge(windows, pmd.frame);
  EXPECT_EQ(verdict.drop, Drop::kNone);
  EXPECT_EQ(verdict.age, 2);
  PmdPairing other(8, 8);
  EXPECT_EQ(other.judge(windows, Pmd(-99ms).frame).drop, Drop::kOlderEdge);
  EXPECT_EQ(other.judge(windows, Pmd(-50ms).frame).drop, Drop::kOlderEdge);
}

TEST(PmdPairing, RefusesOtherSizes) {
  PmdPairing pairing(8, 8);
  Pmd pmd;
  pmd.frame.samples[3] = {};
  EXPECT_EQ(pmd.judge(pairing), Drop::kWrongSize);
}

}  // namespace
}  // namespace stof::firmware
