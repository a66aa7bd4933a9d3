#include "host/recording/recording.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <mutex>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "host/recording/indexed_frames.h"
#include "host/recording/recorder.h"
#include "host/recording/session_recording.h"
#include "tests/dataset/scratch.h"
#include "tests/host/recording/memory_sink.h"

namespace stof {
namespace {

using recording::Topic;
using namespace std::chrono_literals;

constexpr int kWidth = 17;
constexpr int kHeight = 5;

// A frame with pixels of its own in each image.
struct Pictures {
  std::vector<dsp::QuarterMm> depth;
  std::vector<dsp::QuarterMm> width;
  std::vector<dsp::Source> source;
  std::vector<dsp::Cause> cause;
  std::vector<std::uint8_t> received;
  std::vector<std::uint8_t> left;

  explicit Pictures(std::uint32_t number) {
    std::mt19937 random(number);  // NOLINT: the same numbers in each run
    for (int k = 0; k < kWidth * kHeight; ++k) {
      depth.push_back(static_cast<dsp::QuarterMm>(random()));
      width.push_back(static_cast<dsp::QuarterMm>(random()));
      source.push_back(static_cast<dsp::Source>(random() % 6));
      cause.push_back(static_cast<dsp::Cause>(random() % 7));
      received.push_back(static_cast<std::uint8_t>(random() % 8));
      left.push_back(static_cast<std::uint8_t>(random()));
    }
  }
  client::Frame frame(std::uint32_t number, std::uint32_t session = 5) const {
    client::Frame frame{.origin = {.device_id = 3, .session_id = session},
                        .stamp = {.number = number,
                                  .freshness = number,
                                  .exposure_middle_ns = std::int64_t{1'500'000'000} * number}};
    frame.depth = {depth.data(), kWidth, kHeight};
    frame.interval_width = {width.data(), kWidth, kHeight};
    frame.source = {source.data(), kWidth, kHeight};
    frame.cause = {cause.data(), kWidth, kHeight};
    frame.received = {received.data(), kWidth, kHeight};
    frame.left = {left.data(), kWidth, kHeight};
    frame.packets = 9;
    frame.missing_packets = 2;
    frame.info.emplace().latency_ns = number;
    frame.calibration.emplace().image_width = kWidth;
    frame.calibration->image_height = kHeight;
    frame.calibration->fx = frame.calibration->fy = 65536;
    return frame;
  }
};

class RecordingTest : public test::Scratch {
 protected:
  // Records the frames of these numbers.
  std::filesystem::path write(const std::vector<std::uint32_t>& numbers, std::uint32_t session = 5,
                              std::chrono::milliseconds sync_period = std::chrono::hours(1)) {
    const auto file = folder() / "r.mcap";
    auto sink = mcap::FileSink::open(file, mcap::FileSink::Existing::kReplace);
    EXPECT_TRUE(sink);
    auto recorder =
        recording::Recorder::start(*sink, {.library = "test", .sync_period = sync_period});
    EXPECT_TRUE(recorder);
    (*recorder)->put(mcap::Metadata{.name = "stof", .entries = {{"device_id", "3"}}});
    for (const std::uint32_t number : numbers) {
      const Pictures pictures(number);
      const client::Frame frame = pictures.frame(number, session);
      recording::TopicMessages messages;
      if (number == numbers.front()) {
        recording::append_calibration(messages, frame, number);
        recording::append_health(messages, frame.origin, {.uptime_ms = 77}, number);
        recording::append_event(messages, frame.origin, {.sequence = 4, .at_ns = 5}, number);
      }
      recording::append_frame(messages, frame, 1'000 + number);
      EXPECT_TRUE((*recorder)->put(std::move(messages)));
    }
    const auto ended = (*recorder)->finish();
    EXPECT_FALSE(ended.problem);
    EXPECT_TRUE(ended.indexed);
    return file;
  }
};

// A lens as it was told, and the fingerprint that a frame names.
struct ToldFrame {
  std::int32_t fx;  // 0: the frame was received without one
  std::uint32_t fingerprint;
};

class RecordedLenses : public RecordingTest {
 protected:
  // Recorded as it is received; the lens of each frame as it is read, 0: none.
  std::vector<std::int32_t> read_again(const std::vector<ToldFrame>& told) {
    const auto file = folder() / "lenses.mcap";
    auto sink = mcap::FileSink::open(file, mcap::FileSink::Existing::kReplace);
    auto recorder = recording::Recorder::start(*sink, {.library = "test"});
    recording::SessionRecording session(**recorder, {}, {});
    const Pictures pictures(1);
    std::uint32_t number = 1;
    for (const ToldFrame& one : told) {
      client::Frame frame = pictures.frame(number++);
      frame.last_packet = client::Time(std::chrono::seconds(number));
      frame.info->calibration_fingerprint = one.fingerprint;
      frame.calibration->fx = one.fx;
      frame.calibration->fingerprint = one.fingerprint;
      if (one.fx == 0) {
        frame.calibration.reset();
      }
      session.take(frame, "here");
    }
    EXPECT_FALSE((*recorder)->finish().problem);
    std::vector<std::int32_t> lenses;
    auto reader = recording::FrameReader::open(file);
    while (const auto frame = reader->next()) {
      lenses.push_back(frame->calibration ? frame->calibration->fx : 0);
    }
    contradict_ = reader->lenses().contradict();
    const auto summary = recording::summarise(file);
    EXPECT_EQ(summary->lenses_contradict, contradict_);
    return lenses;
  }

  bool contradict_ = false;
};

TEST_F(RecordedLenses, EachFrameHasItsOwn) {
  EXPECT_EQ(read_again({{1, 7}, {1, 7}, {2, 8}, {1, 7}, {1, 7}}),
            (std::vector<std::int32_t>{1, 1, 2, 1, 1}));
  EXPECT_FALSE(contradict_);
}

TEST_F(RecordedLenses, ThatContradictEachOtherAreTold) {
  EXPECT_EQ(read_again({{1, 7}, {4, 7}, {1, 7}}), (std::vector<std::int32_t>{1, 4, 1}));
  EXPECT_TRUE(contradict_);
}

TEST_F(RecordedLenses, OneThatWasNotBelievedAnyMoreHoldsNoMore) {
  EXPECT_EQ(read_again({{4, 7}, {0, 7}, {0, 7}}), (std::vector<std::int32_t>{4, 0, 0}));
  EXPECT_TRUE(contradict_);
  EXPECT_EQ(read_again({{4, 7}, {0, 7}, {4, 7}}), (std::vector<std::int32_t>{4, 0, 4}));
}

TEST_F(RecordingTest, FramesComeBackBitForBit) {
  const auto file = write({10, 11, 12});
  auto reader = recording::FrameReader::open(file);
  ASSERT_TRUE(reader);
  for (const std::uint32_t number : {10U, 11U, 12U}) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame) << number;
    const Pictures pictures(number);
    EXPECT_EQ(frame->depth, pictures.depth);
    EXPECT_EQ(frame->interval_width, pictures.width);
    EXPECT_EQ(frame->source, pictures.source);
    EXPECT_EQ(frame->cause, pictures.cause);
    EXPECT_EQ(frame->received, pictures.received);
    EXPECT_EQ(frame->left, pictures.left);
    EXPECT_EQ(frame->stamp.number, number);
    EXPECT_EQ(frame->stamp.exposure_middle_ns, std::int64_t{1'500'000'000} * number);
    EXPECT_EQ(frame->missing_packets, 2U);
    EXPECT_EQ(frame->log_time, 1'000 + number);
    ASSERT_TRUE(frame->info);
    EXPECT_EQ(frame->info->latency_ns, number);
    ASSERT_TRUE(frame->calibration);
    EXPECT_EQ(frame->calibration->image_width, kWidth);
    EXPECT_EQ(frame->view().depth.at(3, 2), pictures.depth[2 * kWidth + 3]);
  }
  EXPECT_FALSE(reader->next());
  EXPECT_EQ(reader->damaged(), 0U);
  ASSERT_EQ(reader->sights().health.size(), 1U);
  EXPECT_EQ(reader->sights().health.front().second.uptime_ms, 77U);
  ASSERT_EQ(reader->sights().events.size(), 1U);
  EXPECT_EQ(reader->sights().events.front().second.sequence, 4U);
}

TEST_F(RecordingTest, FramesFromAnyTimeOnAreThoseOfTheWholeFile) {
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t number = 10; number < 40; ++number) {
    numbers.push_back(number);
  }
  // A chunk for nearly each frame, and one for all of them.
  for (const std::chrono::milliseconds period : {0ms, 1'000'000ms}) {
    const auto file = write(numbers, 5, period);
    auto frames = recording::IndexedFrames::open(file);
    ASSERT_TRUE(frames) << frames.error().message;
    EXPECT_EQ(frames->begin_ns(), 10U);
    EXPECT_EQ(frames->end_ns(), 1'039U);
    ASSERT_EQ(frames->events().size(), 1U);
    for (const std::uint64_t from : {0U, 1'039U, 1'010U, 1'020U, 1'025U}) {
      frames->seek(from);
      for (std::uint64_t time = std::max<std::uint64_t>(from, 1'010); time < 1'040; ++time) {
        const auto frame = frames->next();
        ASSERT_TRUE(frame) << from << " " << time;
        EXPECT_EQ(frame->log_time, time);
        EXPECT_EQ(frame->depth, Pictures(frame->stamp.number).depth);
        EXPECT_EQ(frame->left, Pictures(frame->stamp.number).left);
        ASSERT_TRUE(frame->calibration);
        EXPECT_EQ(frame->calibration->image_width, kWidth);
      }
      EXPECT_FALSE(frames->next());
    }
    frames->seek(1'040);
    EXPECT_FALSE(frames->next());
  }
}

TEST_F(RecordingTest, TheLastFrameThatCanBeReadIsFound) {
  const auto file = write({10, 11, 12, 13}, 5, 0ms);
  {
    auto source = mcap::FileSource::open(file);
    const auto index = mcap::IndexedReader::open(*source)->index();
    std::fstream bytes(file);
    bytes.seekp(static_cast<std::streamoff>(index.chunks.back().chunk_offset + 60));
    bytes << "damaged";
  }
  auto frames = recording::IndexedFrames::open(file);
  ASSERT_TRUE(frames);
  frames->seek(frames->end_ns());
  EXPECT_FALSE(frames->next());
  EXPECT_EQ(frames->last_before(frames->end_ns())->log_time, 1'012U);
  EXPECT_FALSE(frames->next());
  EXPECT_FALSE(frames->last_before(1'010));
}

TEST_F(RecordingTest, HealthOfAPlaceIsWhatWasSaidLastBeforeIt) {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  for (const std::chrono::milliseconds period : {0ms, 1'000'000ms}) {  // chunks: many, one
    const auto file = folder() / "health.mcap";
    auto sink = mcap::FileSink::open(file, mcap::FileSink::Existing::kReplace);
    ASSERT_TRUE(sink);
    auto recorder = recording::Recorder::start(*sink, {.library = "test", .sync_period = period});
    ASSERT_TRUE(recorder);
    for (std::uint32_t number = 1; number <= 20; ++number) {
      const Pictures pictures(number);
      const client::Frame frame = pictures.frame(number);
      recording::TopicMessages messages;
      recording::append_frame(messages, frame, number * kSecond);
      if (number < 10 || number > 16) {
        recording::append_health(messages, frame.origin, {.uptime_ms = number},
                                 number * kSecond + kSecond / 2);
      }
      ASSERT_TRUE((*recorder)->put(std::move(messages)));
    }
    ASSERT_TRUE((*recorder)->finish().indexed);
    auto frames = recording::IndexedFrames::open(file);
    ASSERT_TRUE(frames);
    const auto at = [&](std::uint64_t number) {
      frames->seek(number * kSecond);
      const auto frame = frames->next();
      EXPECT_TRUE(frame && frame->stamp.number == number) << number;
      return frames->health(number * kSecond)
          .value_or(wire::HealthReport{.uptime_ms = 0})
          .uptime_ms;
    };
    EXPECT_EQ(at(9), 8U);
    EXPECT_EQ(at(2), 1U);
    EXPECT_EQ(at(20), 19U);
    EXPECT_EQ(at(1), 0U);   // nothing was said yet
    EXPECT_EQ(at(12), 9U);  // still fresh
    EXPECT_EQ(at(14), 0U);  // too old
    EXPECT_EQ(at(17), 0U);  // what came later is not it
    // As it plays on.
    frames->seek(7 * kSecond);
    for (std::uint64_t number = 7; number < 10; ++number) {
      ASSERT_TRUE(frames->next());
      EXPECT_EQ(frames->health(number * kSecond).value_or(wire::HealthReport{}).uptime_ms,
                number - 1);
    }
  }
}

TEST_F(RecordingTest, WhatAnEarlierStartSaidIsNothingOfALaterOne) {
  constexpr std::uint64_t kTenth = 100'000'000;
  const auto file = folder() / "restart.mcap";
  auto sink = mcap::FileSink::open(file, mcap::FileSink::Existing::kReplace);
  ASSERT_TRUE(sink);
  auto recorder = recording::Recorder::start(*sink, {.library = "test", .sync_period = 1h});
  ASSERT_TRUE(recorder);
  for (std::uint32_t at = 1; at <= 20; ++at) {
    const Pictures pictures(at);
    client::Frame frame = pictures.frame(at, at < 10 ? 5 : 6);
    frame.calibration->period_ns = kTenth;
    recording::TopicMessages messages;
    if (at == 1 || at == 10) {
      recording::append_calibration(messages, frame, at * kTenth);
    }
    recording::append_frame(messages, frame, at * kTenth);
    if (at == 8 || at == 14) {
      recording::append_health(messages, frame.origin, {.uptime_ms = at}, at * kTenth + 1);
    }
    ASSERT_TRUE((*recorder)->put(std::move(messages)));
  }
  ASSERT_TRUE((*recorder)->finish().indexed);
  auto frames = recording::IndexedFrames::open(file);
  ASSERT_TRUE(frames);
  EXPECT_EQ(frames->starts(), (std::vector<std::uint64_t>{kTenth, 10 * kTenth}));
  EXPECT_EQ(frames->frame_times().size(), 20U);
  EXPECT_EQ(frames->frame_times().back(), 20 * kTenth);
  EXPECT_EQ(frames->period(kTenth - 1), 0ns);
  EXPECT_EQ(frames->period(5 * kTenth), 100ms);
  const auto told = [](const std::optional<wire::HealthReport>& health) {
    return health ? health->uptime_ms : 0;
  };
  auto ordered = recording::FrameReader::open(file);
  ASSERT_TRUE(ordered);
  for (std::uint64_t at = 1; at <= 20; ++at) {
    const std::uint64_t right = at < 9 ? 0 : at < 10 ? 8 : at < 15 ? 0 : 14;
    ASSERT_TRUE(ordered->next());
    EXPECT_EQ(told(recording::health_at(ordered->sights(), at * kTenth)), right) << at;
    frames->seek(at * kTenth);
    ASSERT_TRUE(frames->next());
    EXPECT_EQ(told(frames->health(at * kTenth)), right) << at;
  }
}

TEST_F(RecordingTest, AFileWithoutIndexHasNoTimesToSeek) {
  const auto file = write({10, 11, 12});
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  const auto frames = recording::IndexedFrames::open(file);
  ASSERT_FALSE(frames);
  test::expect_one_line_about(frames.error().message, file, "stof recover");
}

TEST_F(RecordingTest, SummaryCountsFramesAndGaps) {
  const auto file = write({10, 11, 15, 16, 20});
  const auto summary = recording::summarise(file);
  ASSERT_TRUE(summary);
  EXPECT_TRUE(summary->state.indexed);
  EXPECT_EQ(summary->frames, 5U);
  EXPECT_EQ(summary->incomplete_frames, 5U);
  EXPECT_EQ(summary->frames_missing, 6U);
  EXPECT_EQ(summary->sessions, 1U);
  ASSERT_EQ(summary->gaps.size(), 2U);
  EXPECT_EQ(summary->gaps[0].after, 11U);
  EXPECT_EQ(summary->gaps[0].frames, 3U);
  EXPECT_EQ(summary->sensor, (mcap::TextMap{{"device_id", "3"}}));
  ASSERT_TRUE(summary->calibration);
  EXPECT_EQ(summary->calibration->image_height, kHeight);

  // The same of the file without its index.
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  const auto cut = recording::summarise(file);
  ASSERT_TRUE(cut);
  EXPECT_FALSE(cut->state.indexed);
  EXPECT_EQ(cut->frames, 5U);
  EXPECT_EQ(cut->gaps.size(), 2U);
  EXPECT_EQ(cut->sensor, summary->sensor);
  EXPECT_EQ(cut->index.statistics.message_count, summary->index.statistics.message_count);
}

TEST_F(RecordingTest, FramesThatComeAgainAreNoGap) {
  const auto file = write({10, 11, 12});
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  const auto summary = recording::summarise(put("twice.mcap", bytes + bytes));
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->frames, 6U);
  EXPECT_EQ(summary->frames_missing, 0U);
  EXPECT_EQ(summary->damaged, 1U);
}

TEST_F(RecordingTest, FilesThatCannotBeARecordingAreFoundAtOnce) {
  using Existing = mcap::FileSink::Existing;
  const auto there = put("there.mcap", "x");
  for (const auto& [file, fact] :
       {std::pair<std::filesystem::path, const char*>{"/dev/full", "is not a file"},
        {folder(), "is not a file"},
        {folder() / "absent" / "r.mcap", "make the folder"},
        {there / "r.mcap", ""},
        {there, "another name"}}) {
    const auto sink = mcap::FileSink::open(file, Existing::kRefuse);
    ASSERT_FALSE(sink) << file;
    test::expect_one_line_about(sink.error().message, file, fact);
  }
  EXPECT_EQ(std::filesystem::file_size(there), 1U);
}

class FullDiskOf : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Rooms, FullDiskOf, testing::Values(1'000, 20'000, 5'000'000));

TEST_P(FullDiskOf, EndsTheRecordingAndIsTold) {
  test::MemorySink disk(GetParam());
  auto recorder = recording::Recorder::start(disk, {});
  ASSERT_TRUE(recorder);
  bool taken = true;
  for (std::uint32_t number = 0; number < 10'000 && taken; ++number) {
    const Pictures pictures(number);
    recording::TopicMessages messages;
    recording::append_frame(messages, pictures.frame(number), number);
    taken = (*recorder)->put(std::move(messages));
  }
  const auto ended = (*recorder)->finish();
  ASSERT_TRUE(ended.problem);
  EXPECT_EQ(ended.problem->message, "disk: is full: make room");
  EXPECT_LE(disk.file.size(), GetParam());
  const mcap::MemorySource source(disk.file);
  auto reader = mcap::StreamReader::open(source);
  ASSERT_TRUE(reader);
  std::uint64_t frames = 0;
  while (true) {
    const auto item = reader->next();
    ASSERT_TRUE(item) << item.error().message;
    if (!*item) {
      break;
    }
    const auto& message = std::get<mcap::Message>(**item);
    const std::string& topic = reader->index().channels.at(message.channel_id).topic;
    frames += topic == info_of(Topic::kFrameInfo).name ? 1U : 0U;
  }
  EXPECT_EQ(ended.frames, frames);
  EXPECT_EQ(reader->index().statistics.message_count, ended.statistics.message_count);
}

// A disk that stands still: the receiver goes on, and what is lost is known.
class StandingSink : public test::MemorySink {
 public:
  std::expected<void, mcap::Problem> write(mcap::Bytes bytes) override {
    const std::scoped_lock lock(stands);
    return MemorySink::write(bytes);
  }
  std::mutex stands;
};

TEST(Recorder, SlowDiskRefusesWhatItCannotHold) {
  StandingSink disk;
  auto recorder = recording::Recorder::start(disk, {.queue_bytes = 10'000});
  ASSERT_TRUE(recorder);
  int refused = 0;
  {
    const std::scoped_lock lock(disk.stands);
    for (std::uint32_t number = 0; number < 100; ++number) {
      const Pictures pictures(number);
      recording::TopicMessages messages;
      recording::append_frame(messages, pictures.frame(number), number);
      refused += (*recorder)->put(std::move(messages)) ? 0 : 1;
    }
  }
  EXPECT_GT(refused, 50);
  EXPECT_FALSE((*recorder)->finish().problem);
}

TEST(CdrMessage, BytesAreThoseOfTheStandard) {
  const std::array<std::uint16_t, 2> pixels{0x0102, 0x0304};
  const recording::Buffer bytes =
      encode(recording::Image{.header = {.stamp_ns = -1, .frame_id = "ab"},
                              .width = 2,
                              .height = 1,
                              .encoding = "16UC1",
                              .data = std::as_bytes(std::span(pixels))});
  const std::array<std::uint8_t, 60> expected{
      0,    1,    0,    0,                                     // encapsulation
      0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xC9, 0x9A, 0x3B,          // sec -1, nanosec 999,999,999
      3,    0,    0,    0,    'a',  'b',  0,    0,             // frame id, filled to 4
      1,    0,    0,    0,    2,    0,    0,    0,             // height, width
      6,    0,    0,    0,    '1',  '6',  'U',  'C',  '1', 0,  // encoding
      0,    0,                                                 // is_bigendian, filled
      4,    0,    0,    0,    4,    0,    0,    0,             // step, length
      0x02, 0x01, 0x04, 0x03};
  constexpr std::size_t kSize = 52;
  ASSERT_EQ(bytes.size(), kSize);
  EXPECT_TRUE(std::ranges::equal(bytes, std::as_bytes(std::span(expected)).first(kSize)));
  const auto back = recording::decode_image(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->header.stamp_ns, -1);
  EXPECT_EQ(back->width, 2U);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(recording::decode_image(recording::Bytes(bytes).first(size))) << size;
  }
}

TEST(Millimetres, AreRoundedHalfUp) {
  EXPECT_EQ(recording::millimetres(0, 250), 0);
  EXPECT_EQ(recording::millimetres(1, 250), 0);
  EXPECT_EQ(recording::millimetres(2, 250), 1);
  EXPECT_EQ(recording::millimetres(5, 250), 1);
  EXPECT_EQ(recording::millimetres(6, 250), 2);
  EXPECT_EQ(recording::millimetres(65535, 250), 16384);
  EXPECT_EQ(recording::millimetres(65535, 5000), 65535);
}

}  // namespace
}  // namespace stof
