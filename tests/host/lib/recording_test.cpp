// libstof writes recordings, and reads them and serial lines as it reads a sensor.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <stof/stof.h>
#include <stof/stof.hpp>
#include <unistd.h>

#include "hal/framing/cobs.h"
#include "tests/host/lib/lib_sensor.h"
#include "tests/support/pty.h"

namespace {

using namespace std::chrono_literals;
using stof::test::all_streams;
using stof::test::calibration;
using stof::test::send;
using stof::test::subscribe;

constexpr std::uint32_t kFrames = 5;

// A folder of this test's own.
class Folder {
 public:
  Folder() {
    std::string name = std::filesystem::temp_directory_path() / "stof_lib_XXXXXX";
    EXPECT_NE(::mkdtemp(name.data()), nullptr);
    path_ = name;
  }
  ~Folder() {
    std::error_code none;
    std::filesystem::remove_all(path_, none);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

std::vector<std::uint16_t> pixels(const stof::Image<std::uint16_t>& image) {
  std::vector<std::uint16_t> out;
  for (int y = 0; y < image.height(); ++y) {
    out.insert(out.end(), image.row(y), image.row(y) + image.width());
  }
  return out;
}

std::optional<stof::Sensor> open_recording(const std::string& file, std::uint32_t pace = 0) {
  stof_options options = STOF_INIT(stof_options);
  options.recording = file.c_str();
  options.pace_percent = pace;
  std::string why;
  auto opened = stof::Sensor::open(options, &why);
  EXPECT_TRUE(opened) << why;
  return opened;
}

// The depths of kFrames frames, which `file` records.
std::vector<std::vector<std::uint16_t>> record(const std::string& file) {
  stof::test::Sensor sensor;
  stof::Sensor client = stof::test::open(sensor);
  subscribe(client, sensor);
  std::string why;
  EXPECT_EQ(client.record(file, &why), STOF_OK) << why;
  EXPECT_EQ(client.record(file, &why), STOF_BUSY);
  send(sensor, {calibration()});
  std::vector<std::vector<std::uint16_t>> depths;
  for (std::uint32_t number = 5; number < 5 + kFrames; ++number) {
    send(sensor, all_streams(number));
    const auto frame = client.next(30s);
    if (!frame) {
      ADD_FAILURE() << "no frame";
      break;
    }
    EXPECT_EQ(frame->c().recorded_ns, 0);
    depths.push_back(pixels(frame->depth()));
  }
  const auto goes_on = client.recorded();
  EXPECT_TRUE(goes_on && goes_on->recording == 1 && goes_on->frames == kFrames);
  stof_recorded recorded = STOF_INIT(stof_recorded);
  EXPECT_EQ(client.end_recording(&recorded, &why), STOF_OK) << why;
  EXPECT_EQ(recorded.frames, kFrames);
  EXPECT_EQ(recorded.frames_dropped, 0U);
  EXPECT_EQ(recorded.indexed, 1U);
  EXPECT_EQ(recorded.bytes, std::filesystem::file_size(file));
  EXPECT_EQ(client.end_recording(), STOF_NOT_YET);
  return depths;
}

TEST(Recording, WhatIsRecordedIsReadAsItWasReceived) {
  const Folder folder;
  const std::string file = folder.file("a.mcap");
  const auto depths = record(file);
  auto client = open_recording(file);
  ASSERT_TRUE(client);
  EXPECT_EQ(stof_fd(client->c()), -1);
  stof_status status = STOF_OK;
  std::vector<stof::Point> points;
  std::vector<stof::KeptFrame> kept;
  for (std::uint32_t k = 0; k < kFrames; ++k) {
    EXPECT_EQ(client->due(), 0ms);
    const auto frame = client->next(0ms, &status);
    ASSERT_TRUE(frame) << stof_status_text(status);
    EXPECT_EQ(frame->number(), 5 + k);
    EXPECT_EQ(frame->c().emulated, 2);
    EXPECT_GT(frame->c().recorded_ns, 0);
    EXPECT_TRUE(frame->complete());
    EXPECT_EQ(frame->depth().missing(), 0U);
    EXPECT_TRUE(frame->depth().arrived(0, 0));
    EXPECT_FALSE(frame->disparity().empty());
    EXPECT_FALSE(frame->left().empty());
    EXPECT_FALSE(frame->right().empty());
    EXPECT_FALSE(frame->pmd(3).empty());
    EXPECT_EQ(pixels(frame->depth()), depths[k]);
    EXPECT_EQ(frame->points(points), STOF_OK);
    kept.emplace_back(*frame);
    EXPECT_TRUE(kept.back().ok());
    EXPECT_FALSE(stof::KeptFrame(*frame).ok()) << "kept twice";
  }
  EXPECT_FALSE(client->next(0ms, &status));
  EXPECT_EQ(status, STOF_END);
  EXPECT_EQ(client->link().conditions, 0U);
  EXPECT_EQ(client->statistics().frames_complete, kFrames);
  EXPECT_EQ(client->get().status, STOF_UNSUPPORTED);
  EXPECT_FALSE(client->clock());
  std::string why;
  EXPECT_EQ(client->record(folder.file("b.mcap"), &why), STOF_UNSUPPORTED);
  EXPECT_FALSE(why.empty());
  client.reset();
  for (std::uint32_t k = 0; k < kFrames; ++k) {
    EXPECT_EQ(pixels(kept[k]->depth()), depths[k]);
  }
}

TEST(Recording, TheThreadOfARecordingEndsWithItsEnd) {
  const Folder folder;
  const std::string file = folder.file("a.mcap");
  record(file);
  auto client = open_recording(file, 100'000);
  ASSERT_TRUE(client);
  std::atomic<std::uint32_t> frames{0};
  std::atomic<int> ended{-1};
  stof::Callbacks callbacks;
  callbacks.frame = [&](const stof::Frame&) { ++frames; };
  callbacks.failed = [&](stof_status status) { ended = status; };
  ASSERT_EQ(client->start(callbacks), STOF_OK);
  for (int i = 0; i < 6000 && ended < 0; ++i) {
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_EQ(ended, STOF_END);
  EXPECT_EQ(frames, kFrames);
}

TEST(Recording, ACutOneIsReadAndWhatIsNoneIsRefused) {
  const Folder folder;
  const std::string file = folder.file("a.mcap");
  record(file);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1000);
  auto client = open_recording(file);
  ASSERT_TRUE(client);
  stof_status status = STOF_OK;
  while (client->next(0ms, &status)) {
  }
  EXPECT_EQ(status, STOF_END);

  std::ofstream(folder.file("text")) << "no recording";
  for (const char* const name : {"text", "absent", "."}) {
    stof_options options = STOF_INIT(stof_options);
    const std::string path = folder.file(name);
    options.recording = path.c_str();
    stof_sensor* sensor = nullptr;
    char why[256] = {};
    EXPECT_EQ(stof_open(&options, &sensor, why, sizeof why), STOF_FILE);
    EXPECT_EQ(std::string(why).find(path), 0U) << why;
  }
}

TEST(Recording, AFileThatIsThereIsKept) {
  const Folder folder;
  const std::string file = folder.file("a.mcap");
  std::ofstream(file) << "mine";
  stof::test::Sensor sensor;
  {
    stof::Sensor client = stof::test::open(sensor);
    std::string why;
    EXPECT_EQ(client.record(file, &why), STOF_FILE);
    EXPECT_EQ(why.find(file), 0U) << why;
    EXPECT_FALSE(client.recorded());
    EXPECT_EQ(client.record(folder.file("absent/a.mcap"), &why), STOF_FILE);
    EXPECT_EQ(client.record(folder.file("empty.mcap"), &why), STOF_OK) << why;
  }
  EXPECT_EQ(std::filesystem::file_size(file), 4U);
  EXPECT_FALSE(std::filesystem::exists(folder.file("empty.mcap"))) << "without a frame";
}

TEST(SerialLine, FramesOfALineAreReadAsThoseOfASensor) {
  stof::test::Pty pty;
  if (!pty.open()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  stof_options options = STOF_INIT(stof_options);
  options.line = pty.name().c_str();
  options.max_age_ms = 60'000;
  std::string why;
  auto client = stof::Sensor::open(options, &why);
  ASSERT_TRUE(client) << why;
  std::vector<stof::test::Datagram> sent{calibration()};
  for (const auto& packet : all_streams(7)) {
    sent.push_back(packet);
  }
  std::thread writer([&] {
    for (const auto& packet : sent) {
      std::vector<std::byte> code(stof::hal::cobs_bound(packet.size()) + 1);
      code.resize(stof::hal::cobs_encode(packet, code) + 1);
      code.back() = std::byte{0};
      for (std::size_t done = 0; done < code.size();) {
        const ssize_t taken = ::write(pty.fd(), code.data() + done, code.size() - done);
        done += taken > 0 ? static_cast<std::size_t>(taken) : 0;
        if (taken <= 0) {
          std::this_thread::sleep_for(1ms);
        }
      }
    }
  });
  const auto frame = client->next(30s);
  writer.join();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->number(), 7U);
  EXPECT_TRUE(frame->complete());
  EXPECT_TRUE(frame->calibration());
  pty.close();
  stof_status status = STOF_OK;
  EXPECT_FALSE(client->next(30s, &status));
  EXPECT_EQ(status, STOF_LOST);
}

TEST(SerialLine, WhatCannotBeWantedTogetherIsRefused) {
  stof_options options = STOF_INIT(stof_options);
  options.line = "/dev/null";
  EXPECT_FALSE(stof::Sensor::open(options)) << "no line";
  options.sensor = "127.0.0.1";
  stof_sensor* sensor = nullptr;
  char why[256] = {};
  EXPECT_EQ(stof_open(&options, &sensor, why, sizeof why), STOF_BAD_ARGUMENT);
  EXPECT_NE(std::string(why), "");
  options.sensor = nullptr;
  options.raw_pictures = STOF_RAW_LEFT;
  EXPECT_EQ(stof_open(&options, &sensor, why, sizeof why), STOF_BAD_ARGUMENT);
}

}  // namespace
