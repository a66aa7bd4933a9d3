#include "board/emu/recorded_rig.h"

#include <array>
#include <chrono>
#include <filesystem>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "board/emu/recorded_depth.h"
#include "board/emu/scenes.h"
#include "firmware/wire/calibration/calibration_file.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/frame/raw_packets.h"
#include "host/recording/recorder.h"
#include "tests/dataset/scratch.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;

constexpr int kWidth = 32;
constexpr int kHeight = 24;
constexpr std::int64_t kPeriodNs = 50'000'000;
constexpr std::int64_t kFirstEdgeNs = 7'000'000'000;
const std::string kSettings = "{\"period_ms\": 50}";
const std::string kOtherSettings = "{\"period_ms\": 50, \"depth\": {\"max_range_mm\": 5000}}";

std::uint32_t fingerprint(const std::string& document) {
  return wire::crc32c(std::as_bytes(std::span(document)));
}

// What was lost of an exposure, and what its frame was made with.
struct Exposed {
  std::uint8_t lost = 0;   // pictures that were sent and did not arrive
  std::uint8_t state = 0;  // RawInfo::state
  bool other_settings = false;
  std::uint32_t number = 0;   // RawInfo::number; 0: one more than before
  std::int64_t begin_ns = 0;  // of the left exposure; 0: as it should be
  std::uint32_t session = 4;
  std::uint32_t skipped = 0;  // frames before it that have no exposure here
  std::uint32_t dropped = 0;  // RawInfo::dropped
};

class RecordedRigTest : public Scratch {
 protected:
  static std::string calibration_file() {
    board::SceneOptions scene;
    scene.size = hal::emu::Size{kWidth, kHeight};
    scene.pmd = hal::emu::Size{8, 6};
    const auto world = board::render_world(scene);  // the calibration looks into it
    const dsp::Calibration calibration = world.imagery->calibration();
    std::string file(wire::calibration_file_bytes(calibration), '\0');
    EXPECT_TRUE(
        wire::encode_calibration_file(calibration, std::as_writable_bytes(std::span(file))));
    return file;
  }

  void put_documents(recording::Recorder& recorder) const {
    recording::OwnedAttachment file{.name = recording::kCalibrationAttachment};
    mcap::append_bytes(file.data, mcap::bytes_of(calibration_));
    recorder.put(std::move(file));
    recording::TopicMessages messages;
    recording::append_settings(messages, kSettings, 1);
    recorder.put(std::move(messages));
  }

  // Pixels that tell exposure and camera.
  std::vector<std::uint8_t> eye(std::size_t exposure, int which) const {
    std::vector<std::uint8_t> pixels(kWidth * kHeight);
    std::iota(pixels.begin(), pixels.end(),
              static_cast<std::uint8_t>(2 * exposure + (which != 0 ? 1 : 0)));
    return pixels;
  }
  std::vector<std::uint16_t> sample(std::size_t exposure) const {
    return std::vector<std::uint16_t>(48, static_cast<std::uint16_t>(300 + exposure));
  }
  std::vector<std::uint16_t> depth(std::size_t exposure) const {
    return std::vector<std::uint16_t>(kWidth * kHeight, static_cast<std::uint16_t>(exposure + 1));
  }

  static client::Frame frame_of(std::size_t k, const Exposed& exposed, std::uint32_t calibration) {
    client::Frame frame{.origin = {.device_id = 3, .session_id = exposed.session},
                        .stamp = {.number = static_cast<std::uint32_t>(k),
                                  .freshness = static_cast<std::uint32_t>(k + 100)},
                        .packets = 2};
    frame.info.emplace();
    frame.info->settings_fingerprint =
        fingerprint(exposed.other_settings ? kOtherSettings : kSettings);
    frame.info->calibration_fingerprint = calibration;
    return frame;
  }

  static wire::RawInfo info_of(std::size_t k, const Exposed& exposed, std::uint32_t number) {
    const std::int64_t edge = kFirstEdgeNs + static_cast<std::int64_t>(k) * kPeriodNs;
    wire::RawInfo info{.edge_ns = edge,
                       .sequences = {number, number, number},
                       .number = number,
                       .dropped = exposed.dropped,
                       .width = kWidth,
                       .height = kHeight,
                       .camera_width = kWidth,
                       .camera_height = kHeight,
                       .pmd_width = 8,
                       .pmd_height = 6,
                       .pictures = wire::kRawPictures,
                       .step = 1,
                       .state = exposed.state,
                       .pmd_every = 1,
                       .disparities = 8};
    info.pair_exposures.fill({.begin_ns = edge + 1000, .end_ns = edge + 3'000'000});
    for (std::size_t s = 0; s < info.pmd_exposures.size(); ++s) {
      const std::int64_t begin = edge + static_cast<std::int64_t>(s) * 2'000'000;
      info.pmd_exposures[s] = {.begin_ns = begin, .end_ns = begin + 2'000'000};
    }
    if (exposed.begin_ns != 0) {
      info.pair_exposures.front().begin_ns = exposed.begin_ns;
    }
    return info;
  }

  std::filesystem::path record(const std::vector<Exposed>& all) {
    const auto file = folder() / "raw.mcap";
    auto sink = mcap::FileSink::open(file, mcap::FileSink::Existing::kReplace);
    EXPECT_TRUE(sink);
    auto recorder = recording::Recorder::start(*sink, {.library = "test"});
    EXPECT_TRUE(recorder);
    put_documents(**recorder);
    std::uint32_t number = 0;
    std::uint32_t skipped = 0;
    const std::uint32_t calibration =
        wire::calibration_fingerprint(std::as_bytes(std::span(calibration_)));
    for (std::size_t k = 0; k < all.size(); ++k) {
      number = all[k].number != 0 ? all[k].number : number + 1;
      const std::vector<std::uint16_t> plane = depth(k);
      const std::vector<std::uint8_t> left = eye(k, 0);
      const std::vector<std::uint8_t> right = eye(k, 1);
      const std::vector<std::uint16_t> samples = sample(k);
      client::Frame frame = frame_of(k, all[k], calibration);
      skipped += all[k].skipped;
      frame.stamp.number += skipped;
      frame.stamp.freshness += skipped;
      frame.depth = {plane.data(), kWidth, kHeight};
      client::RawExposure raw{.origin = frame.origin,
                              .stamp = frame.stamp,
                              .info = info_of(k, all[k], number),
                              .missing = all[k].lost};
      if ((all[k].lost & wire::kRawLeft) == 0) {
        raw.left = {left.data(), kWidth, kHeight};
      }
      if ((all[k].lost & wire::kRawRight) == 0) {
        raw.right = {right.data(), kWidth, kHeight};
      }
      if ((all[k].lost & wire::kRawPmd) == 0) {
        raw.pmd.fill({samples.data(), 8, 6});
      }
      recording::TopicMessages messages;
      recording::append_frame(messages, frame, 10 + k);
      recording::append_raw(messages, raw, 10 + k);
      (*recorder)->put(std::move(messages));
      if (all[k].other_settings) {  // behind the frame, as it is learnt then
        recording::TopicMessages later;
        recording::append_settings(later, kOtherSettings, 10 + k);
        (*recorder)->put(std::move(later));
      }
    }
    EXPECT_FALSE((*recorder)->finish().problem);
    return file;
  }

  std::unique_ptr<board::RecordedRig> open(const std::vector<Exposed>& all, bool paced = false) {
    auto rig = board::RecordedRig::open(record(all), paced);
    EXPECT_TRUE(rig) << (rig ? "" : rig.error());
    return rig ? std::move(*rig) : nullptr;
  }

  // Depth as it was recorded, with one pixel that may be another.
  void compute(board::RecordedRig& rig, std::size_t k, int more = 0) const {
    std::vector<std::uint16_t> plane = depth(k);
    std::vector<std::uint16_t> width(plane.size());
    std::vector<dsp::Source> source(plane.size());
    plane[77] = static_cast<std::uint16_t>(plane[77] + more);
    rig.computed(edge(k), {.depth = {plane.data(), kWidth, kHeight},
                           .width = {width.data(), kWidth, kHeight},
                           .source = {source.data(), kWidth, kHeight}});
  }
  static hal::Time edge(std::size_t k) {
    return hal::Time(hal::Duration(kFirstEdgeNs + static_cast<std::int64_t>(k) * kPeriodNs));
  }

  std::string calibration_ = calibration_file();
};

TEST_F(RecordedRigTest, GivesEdgesAndPicturesAsTheyWere) {
  const auto rig = open({{.state = wire::kRawBegunAnew}, {}, {}});
  ASSERT_TRUE(rig);
  EXPECT_EQ(rig->disparities(), 8);
  EXPECT_EQ(rig->settings(), kSettings);
  for (std::size_t k = 0; k < 3; ++k) {
    ASSERT_EQ(rig->next_edge(), edge(k));
    const auto pulsed = rig->pulse();
    ASSERT_TRUE(pulsed);
    EXPECT_EQ(*pulsed, edge(k));
    EXPECT_GE(rig->clock().now(), edge(k));
    const auto pair = rig->stereo().wait_frame(edge(k) + 40ms);
    ASSERT_TRUE(pair);
    const std::vector<std::uint8_t> right = eye(k, 1);
    EXPECT_TRUE(std::equal(right.begin(), right.end(), (*pair)->right.data()));
    EXPECT_EQ((*pair)->left_exposure.begin, edge(k) + 1us);
    EXPECT_EQ((*pair)->left_sequence, k + 1);
    const auto set = rig->pmd().wait_frame(edge(k) + 40ms);
    ASSERT_TRUE(set);
    EXPECT_EQ((*set)->samples[3].at(7, 5), 300 + k);
    EXPECT_EQ((*set)->exposures[3].end, edge(k) + 8ms);
    // Each once.
    EXPECT_EQ(rig->stereo().wait_frame(edge(k) + 41ms).error(), Status::kTimeout);
    compute(*rig, k);
  }
  EXPECT_EQ(rig->next_edge(), std::nullopt);
  EXPECT_FALSE(rig->pulse());
  EXPECT_TRUE(rig->verdict().equal) << rig->verdict().lines.front();
}

TEST_F(RecordedRigTest, ALostPictureIsMissingAndTold) {
  const auto rig = open({{}, {.lost = wire::kRawRight}, {.lost = wire::kRawPmd}});
  ASSERT_TRUE(rig);
  for (std::size_t k = 0; k < 3; ++k) {
    ASSERT_TRUE(rig->pulse());
    const hal::Time deadline = edge(k) + 40ms;
    EXPECT_EQ(rig->stereo().wait_frame(deadline).has_value(), k != 1);
    EXPECT_EQ(rig->pmd().wait_frame(deadline).has_value(), k != 2);
    compute(*rig, k);
  }
  const board::Replay::Verdict verdict = rig->verdict();
  EXPECT_FALSE(verdict.equal);
  ASSERT_GE(verdict.lines.size(), 2U);
  EXPECT_NE(verdict.lines[1].find("2 exposures miss a picture"), std::string::npos)
      << verdict.lines[1];
}

TEST_F(RecordedRigTest, TellsWhatDiffersAndWhatWasNeverReceived) {
  const auto rig = open({{}, {.number = 4, .skipped = 2}, {}});
  ASSERT_TRUE(rig);
  for (std::size_t k = 0; k < 3; ++k) {
    ASSERT_TRUE(rig->pulse());
    compute(*rig, k, k == 2 ? 1 : 0);
  }
  const board::Replay::Verdict verdict = rig->verdict();
  EXPECT_FALSE(verdict.equal);
  ASSERT_EQ(verdict.lines.size(), 2U);
  EXPECT_EQ(verdict.lines[0],
            "replay: 2 frames equal the recorded depth, 1 differ, the first is frame 4");
  EXPECT_NE(verdict.lines[1].find("2 exposures were never received"), std::string::npos);
}

// An exposure that was begun and given up advances the sensor's number, and counts as dropped.
TEST_F(RecordedRigTest, WhatWasGivenUpCountsOnce) {
  const auto rig = open({{}, {.number = 4, .skipped = 2, .dropped = 2}, {.dropped = 2}});
  ASSERT_TRUE(rig);
  for (std::size_t k = 0; k < 3; ++k) {
    ASSERT_TRUE(rig->pulse());
    compute(*rig, k);
  }
  const board::Replay::Verdict verdict = rig->verdict();
  ASSERT_EQ(verdict.lines.size(), 2U);
  EXPECT_NE(verdict.lines[1].find(" 2 exposures were never received"), std::string::npos)
      << verdict.lines[1];
}

TEST_F(RecordedRigTest, ExposuresBehindARestartAreMissing) {
  const auto rig = open({{}, {.session = 5}, {.session = 5}});
  ASSERT_TRUE(rig);
  ASSERT_TRUE(rig->pulse());
  compute(*rig, 0);
  EXPECT_EQ(rig->next_edge(), std::nullopt);
  const board::Replay::Verdict verdict = rig->verdict();
  EXPECT_FALSE(verdict.equal) << "one of three was compared";
  ASSERT_EQ(verdict.lines.size(), 2U);
  EXPECT_EQ(verdict.lines[1],
            "replay: 2 exposures behind a restart of the sensor were not replayed");
}

// Whoever waits in parts until the next edge, to tell its health and to end as asked, waits as long
// as it takes; the edge itself then takes no more.
TEST_F(RecordedRigTest, PacedWaitsLastAsLongAsTheyDid) {
  const auto rig = open({{}, {}}, true);
  ASSERT_TRUE(rig);
  const auto before = std::chrono::steady_clock::now();
  ASSERT_TRUE(rig->pulse());
  rig->clock().wait_until(edge(0) + 20ms);
  EXPECT_GE(std::chrono::steady_clock::now() - before, 20ms);
  rig->clock().wait_until(edge(1));
  EXPECT_GE(std::chrono::steady_clock::now() - before, 50ms);
  ASSERT_TRUE(rig->pulse());
  EXPECT_EQ(rig->clock().now(), edge(1));
}

TEST_F(RecordedRigTest, TellsChangesBeforeTheFrameThatWasMadeWithThem) {
  const auto rig = open({{.state = wire::kRawBegunAnew | wire::kRawForgotPast},
                         {},
                         {.state = wire::kRawBegunAnew, .other_settings = true},
                         {.state = wire::kRawForgotPast, .other_settings = true}});
  ASSERT_TRUE(rig);
  const std::array<bool, 4> anew{true, false, true, false};
  const std::array<bool, 4> forgot{true, false, false, true};
  for (std::size_t k = 0; k < 4; ++k) {
    const board::Replay::Change change = rig->take_change();
    EXPECT_EQ(change.begins_anew, anew[k]) << k;
    EXPECT_EQ(change.settings.has_value(), k == 0 || k == 2) << k;
    if (k == 2) {
      EXPECT_EQ(change.settings, kOtherSettings);
    }
    EXPECT_FALSE(rig->take_change().begins_anew) << "told once";
    ASSERT_TRUE(rig->pulse());
    EXPECT_EQ(rig->forgets_past(), forgot[k]) << k;
  }
}

TEST_F(RecordedRigTest, LeavesOutExposuresWithTimesThatCannotBe) {
  const auto rig = open({{}, {.begin_ns = std::numeric_limits<std::int64_t>::min()}, {}});
  ASSERT_TRUE(rig);
  ASSERT_TRUE(rig->pulse());
  EXPECT_EQ(rig->next_edge(), edge(2));
  EXPECT_FALSE(rig->verdict().equal);
}

TEST_F(RecordedRigTest, RefusesFilesThatHoldNothingToComputeAgain) {
  const auto none = board::RecordedRig::open(folder() / "none.mcap", false);
  ASSERT_FALSE(none);
  const auto empty = board::RecordedRig::open(record({}), false);
  ASSERT_FALSE(empty);
  EXPECT_NE(empty.error().find("no raw pictures"), std::string::npos) << empty.error();
  calibration_[calibration_.size() / 2] ^= 1;
  const auto damaged = board::RecordedRig::open(record({{}}), false);
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().find("calibration"), std::string::npos) << damaged.error();
}

}  // namespace
}  // namespace stof::test
