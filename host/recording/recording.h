#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/frame/frame.h"
#include "host/recording/mcap/progress.h"
#include "host/recording/mcap/reader.h"
#include "host/recording/topics.h"

// What a recorded file holds, whole or cut. Files of other programs are read, too, as far as MCAP
// goes: then there are no frames.
namespace stof::recording {

using mcap::Problem;

// The topic of a channel, where it is one of ours: its name, encoding and schema.
std::optional<Topic> topic_of(const mcap::FileIndex& index, std::uint16_t id);

// Frame numbers that the recording does not have.
struct Gap {
  std::uint32_t after = 0;  // number of the frame before
  std::uint32_t frames = 0;
  std::uint64_t log_time = 0;  // of the frame behind
};

struct Summary {
  bool indexed = false;  // sound, and names what is there
  mcap::StreamReader::End end = mcap::StreamReader::End::kWhole;
  std::uint64_t bytes = 0;
  std::uint64_t whole_bytes = 0;    // without what is cut
  std::uint64_t damaged = 0;        // records or chunks that could not be read
  std::uint64_t damaged_bytes = 0;  // of them, and between records; of those in the middle
  mcap::FileIndex index{};
  mcap::TextMap sensor{};                                // the metadata record `stof`
  std::optional<wire::CalibrationPacket> calibration{};  // the last one
  std::uint64_t frames = 0;
  std::uint64_t incomplete_frames = 0;
  std::uint32_t sessions = 0;        // starts of the sensor that are in it
  std::uint64_t frames_missing = 0;  // in all gaps
  std::vector<Gap> gaps{};           // the first kMostGaps
  static constexpr std::size_t kMostGaps = 1000;
};

// Reads the whole file, as FrameReader does: what one says of its frames is what the other finds.
std::expected<Summary, Problem> summarise(const std::filesystem::path& file,
                                          const mcap::Progress& progress = {});

// A frame of a recording. Images that were not recorded are empty.
class RecordedFrame {
 public:
  std::uint64_t log_time = 0;
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
};

struct Sights {                                                        // beside the frames
  std::vector<std::pair<std::uint64_t, wire::HealthReport>> health{};  // with log time
  std::vector<std::pair<std::uint64_t, wire::EventReport>> events{};
};

// Frame after frame of a recording, from the begin, also of a cut one.
class FrameReader {
 public:
  static std::expected<FrameReader, Problem> open(const std::filesystem::path& file);
  // Nothing at the end. What is damaged is left out and counted.
  std::optional<RecordedFrame> next();
  std::uint64_t damaged() const noexcept { return damaged_; }
  std::uint64_t damaged_bytes() const noexcept { return reader_.damaged_bytes(); }
  // Bytes of the file that were read, of all.
  std::uint64_t position() const noexcept { return reader_.position(); }
  std::uint64_t size() const { return source_->size(); }
  // Of what was read so far.
  const Sights& sights() const noexcept { return sights_; }

 private:
  FrameReader(std::unique_ptr<mcap::FileSource> source, mcap::StreamReader&& reader)
      : source_(std::move(source)), reader_(std::move(reader)) {}
  // The frame that this message ends, if it begins another one.
  std::optional<RecordedFrame> take(Topic topic, const mcap::Message& message);
  void take_picture(Topic topic, const Image& image);
  void take_image(Topic topic, const Image& image);
  void take_packet(Topic topic, const mcap::Message& message, const Packet& packet);

  std::unique_ptr<mcap::FileSource> source_;
  mcap::StreamReader reader_;
  std::optional<RecordedFrame> frame_;  // that is being put together
  std::optional<wire::CalibrationPacket> calibration_;
  Sights sights_;
  std::uint64_t damaged_ = 0;
};

}  // namespace stof::recording
