#include "host/cli/view/recorded_source.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>

#include "host/cli/failure.h"

namespace stof::host {

RecordedSource::RecordedSource(const std::string& file) : file_(file) {
  if (auto indexed = recording::IndexedFrames::open(file)) {
    indexed_.emplace(std::move(*indexed));
    read_indexed();
  } else {
    ordered_.emplace(value_or_fail(recording::FrameReader::open(file_)));
  }
}

void RecordedSource::read_indexed() {
  const std::vector<std::uint64_t>& starts = indexed_->starts();
  std::size_t start = starts.empty() ? 0 : 1;  // the first one is no start again
  for (const std::uint64_t time : indexed_->frame_times()) {
    const std::size_t before = start;
    while (start < starts.size() && starts[start] <= time) {
      ++start;
    }
    link_.frame(time, indexed_->period(time), start != before);
  }
  keep(indexed_->events());
}

// Behind what is kept: what is newly known.
void RecordedSource::keep(const std::vector<std::pair<std::uint64_t, wire::EventReport>>& events) {
  const auto begin = static_cast<std::ptrdiff_t>(happenings_.size());
  const auto add = [this](std::uint64_t log_time, const auto& what) {
    happenings_.push_back({.log_time = log_time, .order = happenings_.size(), .what = what});
  };
  for (; events_ < events.size(); ++events_) {
    add(events[events_].first, events[events_].second);
  }
  const std::vector<RecordedLink::Change>& changes = link_.changes();
  for (; changes_ < changes.size(); ++changes_) {
    add(changes[changes_].log_time, changes[changes_].change);
  }
  std::sort(happenings_.begin() + begin, happenings_.end(),
            [](const Happening& a, const Happening& b) {
              return std::pair(a.log_time, a.order) < std::pair(b.log_time, b.order);
            });
}

void RecordedSource::begin_anew() {
  if (indexed_) {
    indexed_->seek(0);
  } else {
    read_once_ = true;
    ordered_.emplace(value_or_fail(recording::FrameReader::open(file_)));
  }
}

void RecordedSource::note(const recording::RecordedFrame& frame) {
  first_ns_ = first_ns_ == 0 ? frame.log_time : first_ns_;
  if (read_once_) {
    return;
  }
  const bool starts = origin_ && (origin_->session_id != frame.origin.session_id ||
                                  origin_->device_id != frame.origin.device_id);
  origin_ = frame.origin;
  link_.frame(frame.log_time,
              std::chrono::nanoseconds(frame.calibration ? frame.calibration->period_ns : 0),
              starts);
  keep(ordered_->sights().events);
}

std::optional<recording::RecordedFrame> RecordedSource::next() {
  if (indexed_) {
    const std::optional<std::uint64_t> sought = std::exchange(sought_, std::nullopt);
    std::optional<recording::RecordedFrame> frame = indexed_->next();
    return frame || !sought ? std::move(frame) : indexed_->last_before(*sought);
  }
  std::optional<recording::RecordedFrame> frame = ordered_->next();
  if (frame) {
    note(*frame);
  }
  return frame;
}

std::optional<wire::HealthReport> RecordedSource::health(std::uint64_t log_time) const {
  return indexed_ ? indexed_->health(log_time) : recording::health_at(ordered_->sights(), log_time);
}

}  // namespace stof::host
