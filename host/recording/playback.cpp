#include "host/recording/playback.h"

#include "firmware/wire/packet.h"

namespace stof::recording {

std::expected<Playback, Problem> Playback::open(const std::filesystem::path& file) {
  auto reader = FrameReader::open(file);
  if (!reader) {
    return std::unexpected(std::move(reader.error()));
  }
  return Playback(std::move(*reader));
}

std::optional<RecordedFrame> Playback::next() {
  std::optional<RecordedFrame> frame = reader_.next();
  statistics_.bad_crc = reader_.damaged();
  if (!frame) {
    return frame;
  }
  frame->stamp.clock = wire::ClockState::kRecorded;
  count(*frame);
  look_beside(frame->log_time);
  return frame;
}

void Playback::count(const RecordedFrame& frame) {
  constexpr std::uint32_t kBackwards = std::uint32_t{1} << 31;
  const bool same = origin_ && origin_->session_id == frame.origin.session_id &&
                    origin_->device_id == frame.origin.device_id;
  if (!same) {
    ++statistics_.sessions;
  } else if (const std::uint32_t step = frame.stamp.number - number_;
             step > 1 && step < kBackwards) {
    statistics_.frames_lost += step - 1;
  }
  origin_ = frame.origin;
  number_ = frame.stamp.number;
  ++(frame.missing_packets == 0 ? statistics_.frames_complete : statistics_.frames_incomplete);
  statistics_.packets_missing += frame.missing_packets;
  const std::uint32_t missing = frame.missing_packets;
  statistics_.packets_ok += frame.packets > missing ? frame.packets - missing : 0;
}

// What was recorded beside the frames until then.
void Playback::look_beside(std::uint64_t until) {
  until_ = until;
  const auto& all = reader_.sights().health;
  for (; health_seen_ < all.size() && all[health_seen_].first <= until; ++health_seen_) {
    health_ = all[health_seen_].second;
    health_at_ns_ = all[health_seen_].first;
  }
}

std::optional<wire::EventReport> Playback::take_event() {
  const auto& all = reader_.sights().events;
  if (events_seen_ >= all.size() || all[events_seen_].first > until_) {
    return std::nullopt;
  }
  return all[events_seen_++].second;
}

}  // namespace stof::recording
