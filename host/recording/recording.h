#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/client/frame/frame.h"
#include "host/recording/frame_assembler.h"
#include "host/recording/mcap/progress.h"
#include "host/recording/mcap/reader.h"
#include "host/recording/recorded_frame.h"
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

// Whether a file is whole, once it was read.
struct FileState {
  bool indexed = true;  // sound, and names what is there
  mcap::StreamReader::End end = mcap::StreamReader::End::kWhole;
  bool being_written = false;  // by another program, when it was opened
  std::uint32_t files = 1;     // one behind the other
};

struct Summary {
  FileState state{};
  std::uint64_t bytes = 0;
  std::uint64_t whole_bytes = 0;    // without what is cut
  std::uint64_t damaged = 0;        // records or chunks that could not be read
  std::uint64_t damaged_bytes = 0;  // of them, and between records; of those in the middle
  mcap::FileIndex index{};
  mcap::TextMap sensor{};                                // the metadata record `stof`
  std::optional<wire::CalibrationPacket> calibration{};  // the last one
  bool lenses_contradict = false;                        // ToldLenses
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

// Frame after frame of a recording, from the begin, also of a cut one.
class FrameReader {
 public:
  static std::expected<FrameReader, Problem> open(const std::filesystem::path& file);
  // Nothing at the end. What is damaged is left out and counted.
  std::optional<RecordedFrame> next();
  std::uint64_t damaged() const noexcept { return damaged_ + frames_.damaged(); }
  std::uint64_t damaged_bytes() const noexcept { return reader_.damaged_bytes(); }
  // Once next() gave nothing.
  FileState state() const noexcept;
  // Bytes of the file that were read, of all.
  std::uint64_t position() const noexcept { return reader_.position(); }
  std::uint64_t size() const { return source_->size(); }
  // Of what was read so far.
  const Sights& sights() const noexcept { return frames_.sights(); }
  const ToldLenses& lenses() const noexcept { return frames_.lenses(); }
  // It was told that somebody speaks in the sensor's name.
  bool forged_traffic() const noexcept { return forged_traffic_; }

 private:
  FrameReader(std::unique_ptr<mcap::FileSource> source, mcap::StreamReader&& reader)
      : source_(std::move(source)),
        reader_(std::move(reader)),
        being_written_(source_->is_locked()) {}

  std::optional<RecordedFrame> of_its_file(std::optional<RecordedFrame> frame) const;

  std::unique_ptr<mcap::FileSource> source_;
  mcap::StreamReader reader_;
  FrameAssembler frames_;
  std::uint64_t damaged_ = 0;  // records
  bool being_written_;
  bool forged_traffic_ = false;
  std::uint32_t file_ = 1;  // of the frame that is being put together
};

}  // namespace stof::recording
