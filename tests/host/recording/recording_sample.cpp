#include <charconv>
#include <cstdio>
#include <cstring>
#include <random>
#include <vector>

#include "host/recording/recorder.h"

// recording_sample FILE COUNT: a recording with so many messages on each channel, of small random
// pictures, for readers of other programs.
namespace stof {
namespace {

constexpr int kWidth = 33;
constexpr int kHeight = 7;

struct Pictures {
  std::vector<std::uint16_t> wide = std::vector<std::uint16_t>(kWidth * kHeight);
  std::vector<std::uint8_t> narrow = std::vector<std::uint8_t>(kWidth * kHeight);
  std::vector<dsp::Source> source = std::vector<dsp::Source>(kWidth * kHeight, dsp::Source::kBoth);
  std::vector<dsp::Disparity> disparity = std::vector<dsp::Disparity>(kWidth * kHeight);

  explicit Pictures(std::uint32_t seed) {
    std::mt19937 random(seed);  // NOLINT: the same numbers in each run
    for (std::size_t k = 0; k < wide.size(); ++k) {
      wide[k] = static_cast<std::uint16_t>(random());
      narrow[k] = static_cast<std::uint8_t>(random());
    }
  }
  // Incomplete, so that what was received is recorded, too.
  client::Frame frame(std::uint32_t number) const {
    client::Frame frame{
        .origin = {.device_id = 1, .session_id = 2},
        .stamp = {.number = number, .freshness = number, .exposure_middle_ns = number}};
    const dsp::ImageView<const std::uint16_t> pixels(wide.data(), kWidth, kHeight);
    const dsp::ImageView<const std::uint8_t> grey(narrow.data(), kWidth, kHeight);
    frame.depth = frame.interval_width = pixels;
    frame.pmd = {pixels, pixels, pixels, pixels};
    frame.source = {source.data(), kWidth, kHeight};
    frame.disparity = {disparity.data(), kWidth, kHeight};
    frame.received = frame.left = frame.right = grey;
    frame.packets = 5;
    frame.missing_packets = 1;
    frame.info.emplace();
    frame.calibration = wire::CalibrationPacket{
        .image_width = kWidth, .image_height = kHeight, .fx = 65536, .fy = 65536};
    return frame;
  }
};

int write(const char* file, std::uint32_t count) {
  auto sink = mcap::FileSink::open(file, mcap::FileSink::Existing::kReplace);
  if (!sink) {
    std::fprintf(stderr, "%s\n", sink.error().message.c_str());
    return 2;
  }
  auto recorder = recording::Recorder::start(*sink, {.library = "recording_sample"});
  if (!recorder) {
    std::fprintf(stderr, "%s\n", recorder.error().message.c_str());
    return 2;
  }
  for (std::uint32_t number = 0; number < count; ++number) {
    const Pictures pictures(number);
    const client::Frame frame = pictures.frame(number);
    const std::uint64_t time = 1'000'000'000 + std::uint64_t{number} * 33'000'000;
    recording::TopicMessages messages;
    recording::append_calibration(messages, frame, time);
    recording::append_health(messages, frame.origin, {.uptime_ms = number, .active = number}, time);
    recording::append_event(messages, frame.origin, {.sequence = number}, time);
    recording::append_settings(messages, "{}", time);
    recording::append_frame(messages, frame, time);
    recording::append_raw(messages,
                          {.origin = frame.origin,
                           .stamp = frame.stamp,
                           .info = {},
                           .left = frame.left,
                           .right = frame.right,
                           .pmd = frame.pmd},
                          time);
    if (!(*recorder)->put(std::move(messages))) {
      std::fprintf(stderr, "%s: the disk is full or too slow\n", file);
      return 1;
    }
  }
  return (*recorder)->finish().problem ? 1 : 0;
}

}  // namespace
}  // namespace stof

int main(int argc, char** argv) {
  std::uint32_t count = 0;
  if (argc != 3 ||
      std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), count).ec != std::errc()) {
    std::fputs("recording_sample FILE COUNT\n", stderr);
    return 2;
  }
  return stof::write(argv[1], count);
}
