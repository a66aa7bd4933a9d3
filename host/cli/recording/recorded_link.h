#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/cli/live/link_teller.h"

namespace stof::host {

// What a recording tells of its link, as it would have been told live, on its own clock: the sensor
// fell silent, started again, sends again.
class RecordedLink {
 public:
  struct Change {
    std::uint64_t log_time = 0;
    LinkTeller::Change change{};
  };

  // The next frame. period: that the sensor told, which counts as far as gaps before bear it out;
  // 0: not known. starts: it is of a later start of the sensor than the one before.
  void frame(std::uint64_t log_time, client::Duration period, bool starts);
  // All of the frames until now, in order.
  const std::vector<Change>& changes() const noexcept { return changes_; }
  unsigned silences() const noexcept { return teller_.silences(); }

 private:
  void look(const client::LinkState& link, std::uint64_t log_time);

  LinkTeller teller_{LinkTeller::Health::kLeftOut};
  client::Duration believed(client::Duration period) const;

  std::array<client::Duration, 32> gaps_{};  // the newest ones; 0: none yet
  std::size_t noted_ = 0;                    // ever
  std::optional<std::uint64_t> newest_;
  std::vector<Change> changes_;
};

}  // namespace stof::host
