#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/frame/frame.h"

namespace stof::recording {

// A frame of a recording. Images that were not recorded are empty.
class RecordedFrame {
 public:
  std::uint64_t log_time = 0;
  std::uint32_t file = 1;  // of files one behind the other
  wire::Origin origin{};
  wire::FrameStamp stamp{};
  std::optional<wire::FrameInfo> info{};
  std::optional<wire::CalibrationPacket> calibration{};
  std::uint32_t packets = 0;
  std::uint32_t missing_packets = 0;
  int width = 0;  // of depth
  int height = 0;
  std::vector<dsp::QuarterMm> depth{};
  std::vector<dsp::QuarterMm> interval_width{};
  std::vector<dsp::Source> source{};
  std::vector<dsp::Cause> cause{};
  std::vector<std::uint8_t> received{};
  int left_width = 0;  // of both eyes
  int left_height = 0;
  std::vector<std::uint8_t> left{};
  std::vector<std::uint8_t> right{};
  std::vector<dsp::Disparity> disparity{};  // of the size of depth
  int pmd_width = 0;                        // of a sample
  int pmd_height = 0;
  std::array<std::vector<std::uint16_t>, 4> pmd{};

  // Views into this object: depth, width, source, cause and left as they were received.
  client::Frame view() const;
  // The same with the other pictures, marks and what is missing, as a receiver gives it.
  client::Frame whole_view() const;
};

struct Sights {                                                        // beside the frames
  std::vector<std::pair<std::uint64_t, wire::HealthReport>> health{};  // with log time
  std::vector<std::pair<std::uint64_t, wire::EventReport>> events{};
  // In which session of the sensor each of them was said.
  std::vector<std::uint32_t> health_sessions{};
  std::vector<std::uint32_t> event_sessions{};
  // Log times of what each start of the sensor said first.
  std::vector<std::uint64_t> starts{};
};

// Health comes once a second: what is older says nothing of a time.
constexpr std::uint64_t kHealthHoldsNs = 3'000'000'000;
// What the sensor had said of itself at that log time, since its start; none: nobody knows.
std::optional<wire::HealthReport> health_at(const Sights& sights, std::uint64_t log_time);

}  // namespace stof::recording
