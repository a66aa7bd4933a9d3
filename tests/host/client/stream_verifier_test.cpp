// Streams that are signed for one receiver: what is forged, repeated, changed, of another receiver
// or of another key never becomes a frame.
#include "host/client/session/stream_verifier.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/reassembler.h"
#include "host/client/session/link_watch.h"
#include "tests/host/client/test_pattern.h"

namespace stof::client {
namespace {

using Verdict = StreamVerifier::Verdict;
using test::Datagram;
using test::frame_spec;
using wire::StreamKey;

constexpr Time kStart{std::chrono::seconds(100)};
constexpr std::uint32_t kSession = test::kOrigin.session_id;

StreamKey numbered(std::uint32_t number, unsigned secret = 1) {
  StreamKey key{.number = number};
  key.secret.fill(static_cast<std::byte>(secret));
  return key;
}

Datagram sign(const Datagram& datagram, const StreamKey& key, std::uint64_t counter) {
  wire::DatagramBuffer buffer{};
  wire::StreamTagger tagger(key);
  const auto made = wire::sign_datagram(datagram, tagger, counter, buffer);
  return {made.begin(), made.end()};
}

// All datagrams of a frame, signed from this counter on.
std::vector<Datagram> signed_frame(std::uint32_t number, const StreamKey& key,
                                   std::uint64_t& counter, bool parity = false) {
  test::FrameSpec spec = frame_spec(number);
  spec.parity = parity;
  std::vector<Datagram> packets = test::datagrams(spec);
  for (Datagram& packet : packets) {
    packet = sign(packet, key, ++counter);
  }
  return packets;
}

class Verifier : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(wire::start_crypto());
    verifier_.set_key(key_, kSession);
  }
  Verdict judge(std::uint64_t counter, const StreamKey& key) {
    return verifier_.judge(sign(plain_, key, counter), session_);
  }
  Verdict judge(std::uint64_t counter) { return judge(counter, key_); }

  std::uint32_t session_ = kSession;  // of what is judged
  StreamKey key_ = numbered(5);
  Datagram plain_ = test::datagrams(frame_spec(1)).front();
  StreamVerifier verifier_;
};

TEST_F(Verifier, TakesEachCounterOnceInAnyOrder) {
  std::vector<std::uint64_t> counters(500);
  std::ranges::generate(counters, [next = 0U]() mutable { return ++next; });
  std::ranges::shuffle(counters, std::mt19937_64(1));
  for (const std::uint64_t counter : counters) {
    EXPECT_EQ(judge(counter), Verdict::kGood) << counter;
  }
  for (const std::uint64_t counter : counters) {
    EXPECT_EQ(judge(counter), Verdict::kDuplicate) << counter;
  }
  EXPECT_EQ(verifier_.good(), 500U);
}

TEST_F(Verifier, WhatIsTooOldToBeKnownIsLate) {
  EXPECT_EQ(judge(5000), Verdict::kGood);
  EXPECT_EQ(judge(5000 - StreamVerifier::kWindow), Verdict::kLate);
  EXPECT_EQ(judge(5001 - StreamVerifier::kWindow), Verdict::kGood);
  EXPECT_EQ(judge(5001 - StreamVerifier::kWindow), Verdict::kDuplicate);
  // Counters that were skipped are free, whatever lay at their place before.
  EXPECT_EQ(judge(5000 + 900), Verdict::kGood);
  EXPECT_EQ(judge(5001 + StreamVerifier::kWindow - 200), Verdict::kGood);
  EXPECT_EQ(judge(5000), Verdict::kDuplicate);
  EXPECT_EQ(judge(5000 + 900 + 10 * StreamVerifier::kWindow), Verdict::kGood);
  EXPECT_EQ(judge(5000), Verdict::kLate);
}

TEST_F(Verifier, RefusesWhatAnotherKeySigned) {
  EXPECT_EQ(judge(1, numbered(5, 2)), Verdict::kForged);
  EXPECT_EQ(judge(1, numbered(6)), Verdict::kNotSigned);  // another receiver's
  EXPECT_EQ(judge(1, numbered(0)), Verdict::kNotSigned);
  EXPECT_EQ(verifier_.judge(plain_, kSession), Verdict::kNotSigned);
  verifier_.await_key(true);
  EXPECT_EQ(judge(1, numbered(6)), Verdict::kKeyToCome);
  EXPECT_EQ(verifier_.judge(plain_, kSession), Verdict::kNotSigned);
  EXPECT_EQ(verifier_.good(), 0U);
}

// Nobody who cannot sign moves what is known.
TEST_F(Verifier, AForgedCounterFarAheadStopsNothing) {
  EXPECT_EQ(judge(~std::uint64_t{0}, numbered(5, 2)), Verdict::kForged);
  Datagram changed = sign(plain_, key_, 1);
  changed[59] = std::byte{0xFF};  // of the counter
  test::reseal(changed);
  EXPECT_EQ(verifier_.judge(changed, kSession), Verdict::kForged);
  EXPECT_EQ(judge(1), Verdict::kGood);
}

TEST_F(Verifier, TheKeyBeforeIsGoodUntilTheNext) {
  EXPECT_EQ(judge(1), Verdict::kGood);
  verifier_.set_key(numbered(6, 3), kSession);
  EXPECT_EQ(judge(2), Verdict::kGood);
  EXPECT_EQ(judge(1), Verdict::kDuplicate);
  EXPECT_EQ(judge(1, numbered(6, 3)), Verdict::kGood);
  verifier_.set_key(numbered(6, 3), kSession);  // told again
  EXPECT_EQ(judge(1, numbered(6, 3)), Verdict::kDuplicate);
  verifier_.set_key(numbered(7, 4), kSession);
  EXPECT_EQ(judge(3), Verdict::kNotSigned);
}

// A sensor that starts again counts its keys from 1.
TEST_F(Verifier, TheSameNumberOfAnotherSessionReplacesIt) {
  EXPECT_EQ(judge(1), Verdict::kGood);
  session_ = 2;
  verifier_.set_key(numbered(5, 9), session_);
  EXPECT_EQ(judge(2), Verdict::kForged);
  EXPECT_EQ(judge(1, numbered(5, 9)), Verdict::kGood);
}

// Else whoever kept what it signed could show it after the next start.
TEST_F(Verifier, AKeyOfAnotherSessionIsNoneAnyMore) {
  verifier_.set_key(numbered(6), kSession);
  verifier_.set_key(numbered(7), kSession);
  EXPECT_EQ(judge(1, numbered(6)), Verdict::kGood);
  EXPECT_EQ(verifier_.good_number(), 6U);
  session_ = 2;
  verifier_.set_key(numbered(1), session_);
  EXPECT_EQ(judge(2, numbered(7)), Verdict::kNotSigned);
  EXPECT_EQ(judge(1, numbered(1)), Verdict::kGood);
}

// A sensor that starts again counts its keys from 1 again, and its answer with the key may be lost.
TEST_F(Verifier, TheSameNumberInAnotherSessionIsNoForgeryOfTheKnownKey) {
  EXPECT_EQ(judge(1), Verdict::kGood);
  session_ = 2;
  verifier_.await_key(true);
  EXPECT_EQ(judge(1, numbered(5, 9)), Verdict::kKeyToCome);
  verifier_.set_key(numbered(5, 9), session_);
  EXPECT_EQ(judge(1, numbered(5, 9)), Verdict::kGood);
  session_ = kSession;  // late, of before the start
  EXPECT_EQ(judge(2), Verdict::kKeyToCome);
  verifier_.await_key(false);
  EXPECT_EQ(judge(2), Verdict::kNotSigned);
}

class SignedFrames : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(wire::start_crypto()); }
  std::optional<Frame> push(const std::vector<Datagram>& packets) {
    std::optional<Frame> frame;
    for (const Datagram& packet : packets) {
      reassembler_.push(packet, now_);
      if (const std::optional<Frame> next = reassembler_.take()) {
        frame = next;
      }
    }
    watch_.look(reassembler_, now_);
    return frame;
  }
  bool told() const { return watch_.state(now_).forged_traffic; }

  StreamKey key_ = numbered(5);
  std::uint64_t counter_ = 0;
  Time now_ = kStart;
  StreamVerifier verifier_;
  Reassembler reassembler_{{.verifier = &verifier_}};
  LinkWatch watch_{kStart};
};

TEST_F(SignedFrames, ComeWholeAndUnsignedOnesNever) {
  EXPECT_FALSE(push(test::datagrams(frame_spec(1))));
  EXPECT_FALSE(told()) << "before there is a key nobody knows better";
  verifier_.set_key(key_, kSession);
  const std::optional<Frame> frame = push(signed_frame(2, key_, counter_));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
  EXPECT_FALSE(told());
  EXPECT_FALSE(push(test::datagrams(frame_spec(3))));
  EXPECT_TRUE(told());
  const Statistics& statistics = reassembler_.statistics();
  EXPECT_EQ(statistics.not_signed, 2 * test::datagrams(frame_spec(1)).size());
  EXPECT_EQ(statistics.sessions, 1U);
}

TEST_F(SignedFrames, ForgedAndRepeatedOnesAreCountedAndNoneComes) {
  verifier_.set_key(key_, kSession);
  const std::vector<Datagram> frame = signed_frame(2, key_, counter_);
  ASSERT_TRUE(push(frame));
  EXPECT_FALSE(push(frame));
  EXPECT_EQ(reassembler_.statistics().duplicate, frame.size());
  EXPECT_FALSE(told()) << "networks repeat, too";
  std::uint64_t other = 100;
  const std::vector<Datagram> forged = signed_frame(3, numbered(5, 2), other);
  EXPECT_FALSE(push(forged));
  EXPECT_EQ(reassembler_.statistics().forged, forged.size());
  EXPECT_TRUE(told());
  // A frame of before cannot be sent on as a newer one: its number is signed as well.
  std::vector<Datagram> renumbered = frame;
  for (Datagram& packet : renumbered) {
    packet[20] = std::byte{9};
    packet[56] ^= std::byte{64};
    test::reseal(packet);
  }
  EXPECT_FALSE(push(renumbered));
  EXPECT_EQ(reassembler_.statistics().forged, forged.size() + renumbered.size());
  ASSERT_TRUE(push(signed_frame(3, key_, counter_)));
  EXPECT_EQ(reassembler_.statistics().packets(), 5 * frame.size());
}

TEST_F(SignedFrames, AStrangersSessionDoesNotEndTheirs) {
  verifier_.set_key(key_, kSession);
  ASSERT_TRUE(push(signed_frame(2, key_, counter_)));
  test::FrameSpec stranger = frame_spec(3);
  stranger.origin.session_id += 1;
  EXPECT_FALSE(push(test::datagrams(stranger)));
  EXPECT_EQ(reassembler_.statistics().sessions, 1U);
  EXPECT_TRUE(push(signed_frame(3, key_, counter_)));
}

TEST_F(SignedFrames, DamageIsNoForgery) {
  verifier_.set_key(key_, kSession);
  std::vector<Datagram> frame = signed_frame(2, key_, counter_);
  frame[3][70] ^= std::byte{1};
  push(frame);
  EXPECT_EQ(reassembler_.statistics().bad_crc, 1U);
  EXPECT_EQ(reassembler_.statistics().forged, 0U);
  EXPECT_FALSE(told());
}

TEST_F(SignedFrames, ParityMakesGoodWhatIsLostOfThem) {
  verifier_.set_key(key_, kSession);
  ASSERT_TRUE(push(signed_frame(2, key_, counter_, true)));
  for (std::size_t lost = 0; lost < 13; ++lost) {
    std::vector<Datagram> packets =
        signed_frame(static_cast<std::uint32_t>(3 + lost), key_, counter_, true);
    packets.erase(packets.begin() + static_cast<std::ptrdiff_t>(lost));
    const std::optional<Frame> frame = push(packets);
    ASSERT_TRUE(frame) << lost;
    EXPECT_TRUE(frame->complete()) << lost;
    EXPECT_EQ(frame->recovered_packets, 1U);
  }
}

}  // namespace
}  // namespace stof::client
