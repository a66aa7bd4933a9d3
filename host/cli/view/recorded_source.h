#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/cli/recording/recorded_link.h"
#include "host/recording/indexed_frames.h"
#include "host/recording/recording.h"

namespace stof::host {

// Where the frames of a recording come from: by its index, from any time on, or without one from
// the begin.
class RecordedSource {
 public:
  struct Happening {
    std::uint64_t log_time = 0;
    std::size_t order = 0;  // among those of one time
    std::variant<wire::EventReport, LinkTeller::Change> what{};
  };

  // Throws Failure.
  explicit RecordedSource(const std::string& file);

  bool seekable() const { return indexed_.has_value(); }
  // Without an index of the first frame that was read; the end is not known.
  std::uint64_t begin_ns() const { return indexed_ ? indexed_->begin_ns() : first_ns_; }
  std::uint64_t end_ns() const { return indexed_ ? indexed_->end_ns() : 0; }

  void begin_anew();
  // Only where it is seekable. The next frame is the first one of that time or later; where none of
  // these can be read, the last one before.
  void seek(std::uint64_t log_time) {
    indexed_->seek(log_time);
    sought_ = log_time;
  }
  std::optional<recording::RecordedFrame> next();

  // What the sensor told and what befell its link, as far as is known now, in order.
  const std::vector<Happening>& happenings() const noexcept { return happenings_; }
  // What the sensor had said of itself at that time, which is not before the frame that was read
  // before the last one; none: nobody knows.
  std::optional<wire::HealthReport> health(std::uint64_t log_time) const;

 private:
  void read_indexed();  // what happens in all of it
  void note(const recording::RecordedFrame& frame);
  void keep(const std::vector<std::pair<std::uint64_t, wire::EventReport>>& events);

  std::string file_;
  std::optional<recording::IndexedFrames> indexed_;
  std::optional<std::uint64_t> sought_;  // since the frame before
  std::optional<recording::FrameReader> ordered_;
  std::uint64_t first_ns_ = 0;
  bool read_once_ = false;  // to the end, without an index
  RecordedLink link_;
  std::optional<wire::Origin> origin_;  // of the frame before, without an index
  std::size_t events_ = 0;              // of the file's, among the happenings
  std::size_t changes_ = 0;             // of the link's
  std::vector<Happening> happenings_;
};

}  // namespace stof::host
