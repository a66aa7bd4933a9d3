#include "host/cli/recording/recorded_link.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "host/client/frame/made_with.h"
#include "host/client/session/link_watch.h"

namespace stof::host {

void RecordedLink::look(const client::LinkState& link, std::uint64_t log_time) {
  teller_.look(link, std::nullopt, client::Time(std::chrono::nanoseconds(log_time)));
  for (const LinkTeller::Change& change : teller_.changes()) {
    changes_.push_back({.log_time = log_time, .change = change});
  }
}

client::Duration RecordedLink::believed(client::Duration period) const {
  const client::Duration longest =
      std::min(*std::ranges::max_element(gaps_), client::kLongestPeriod);
  return std::clamp(period, client::Duration(0),
                    noted_ == 0 ? client::FramePace::kUnproven : longest + longest / 8);
}

void RecordedLink::frame(std::uint64_t log_time, client::Duration period, bool starts) {
  constexpr std::uint64_t kLast = std::numeric_limits<std::int64_t>::max();  // of any clock
  log_time = std::clamp(log_time, newest_.value_or(0), kLast);
  const client::Duration silence = client::silence_after(believed(period));
  const auto silence_ns = static_cast<std::uint64_t>(std::chrono::nanoseconds(silence).count());
  if (newest_ && log_time - *newest_ > silence_ns) {
    look({.silent = true, .frame_age = silence}, *newest_ + silence_ns);
  }
  if (newest_) {
    gaps_[noted_++ % gaps_.size()] = std::chrono::nanoseconds(log_time - *newest_);
  }
  newest_ = log_time;
  look({.silent = false, .restarted = starts, .frame_age = client::Duration(0)}, log_time);
}

}  // namespace stof::host
