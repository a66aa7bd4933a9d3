#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/wire/messages/raw_info.h"
#include "host/recording/recording.h"

// Raw recordings (stof record --raw): what the cameras gave, exposure after exposure.
namespace stof::recording {

// What the whole recording says, before its first exposure is needed: settings lie behind the first
// frame that was made with them.
struct RawSummary {
  wire::Origin origin{};             // of the first session with exposures: the only one read
  std::uint64_t exposures = 0;       // of it
  std::uint64_t other_sessions = 0;  // exposures of others
  std::string calibration{};         // file of the sensor's calibration, the first; empty: none
  std::map<std::uint32_t, std::string> settings{};  // documents by their fingerprint
  std::string first_settings{};                     // the one at the begin; empty: none
  std::optional<wire::CalibrationPacket> packet{};  // the first
  wire::RawInfo first{};
  std::int64_t pair_exposure_ns = 0;  // the longest
  std::int64_t pmd_exposure_ns = 0;   // from A0's begin to A3's end, likewise
  std::int64_t from_edge_ns = 0;      // an exposure began farthest from its edge, likewise
};

// One exposure. Pictures that were lost, or not recorded, are empty.
struct RawInput {
  wire::FrameStamp stamp{};
  wire::RawInfo info{};
  std::vector<std::uint8_t> left{};
  std::vector<std::uint8_t> right{};
  std::array<std::vector<std::uint16_t>, 4> pmd{};
  std::uint8_t missing = 0;              // of info.pictures
  std::optional<RecordedFrame> frame{};  // that was computed from it; none: it was lost
};

// From the begin, also of a cut recording.
class RawReader {
 public:
  // Reads the whole file once. A problem: no MCAP file, or it holds nothing to compute again.
  static std::expected<RawReader, Problem> open(const std::filesystem::path& file);

  const RawSummary& summary() const noexcept { return summary_; }
  // nullptr at the end.
  std::unique_ptr<RawInput> next();
  std::uint64_t damaged() const noexcept { return damaged_ + frames_.damaged(); }

 private:
  RawReader(RawSummary summary, std::unique_ptr<mcap::FileSource> source,
            mcap::StreamReader&& reader, FrameReader&& frames)
      : summary_(std::move(summary)),
        source_(std::move(source)),
        reader_(std::move(reader)),
        frames_(std::move(frames)) {}

  void take(Topic topic, const mcap::Message& message);
  void find_frame(RawInput& input);

  RawSummary summary_;
  std::unique_ptr<mcap::FileSource> source_;
  mcap::StreamReader reader_;
  FrameReader frames_;
  std::optional<RecordedFrame> frame_;  // read, and not yet anybody's
  std::unique_ptr<RawInput> input_;     // that is being put together
  std::unique_ptr<RawInput> whole_;     // the one before
  std::uint64_t damaged_ = 0;
};

}  // namespace stof::recording
