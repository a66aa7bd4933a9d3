#pragma once

#include <optional>
#include <string>
#include <vector>

#include "board/timing.h"
#include "dsp/fusion/depth_map.h"
#include "hal/time.h"

namespace stof::board {

// A recording of what cameras gave: its edges go out when they did, on a clock of their own, its
// frames come again, and what is computed of them is compared with the depth that was recorded. A
// picture that was lost is missing. For the loop's thread; on host builds alone: allocates.
class Replay {
 public:
  virtual ~Replay() = default;

  // When the next edge went out; none: the recording is over.
  virtual std::optional<hal::Time> next_edge() noexcept = 0;

  // What changed before the frame of the next edge was computed. Told once for each edge.
  struct Change {
    std::optional<std::string> settings{};  // the document that holds from now on
    bool begins_anew = false;               // the pipeline was built anew
  };
  virtual Change take_change() = 0;
  // With the frame of the last edge depth was averaged with none before.
  virtual bool forgets_past() noexcept = 0;

  // How depth was sent whose frames are recorded from now on: rounded, or as it was computed.
  struct Sent {
    bool depth_rounded = false;
    bool width_rounded = false;
  };
  virtual void note_streams(const Sent& sent) noexcept = 0;
  // What the loop made of an edge.
  virtual void computed(hal::Time edge, const dsp::DepthMap& map) noexcept = 0;

  // How the cameras were driven that were recorded, as far as it tells; `own`: of this board.
  virtual TimingConfig timing(const TimingConfig& own) const noexcept = 0;
  virtual const std::string& settings() const noexcept = 0;  // the document at the first edge

  struct Verdict {
    std::vector<std::string> lines{};  // for a person: what was equal, what was missing
    bool equal = false;                // all that was recorded was computed, and equal
  };
  virtual Verdict verdict() const = 0;
};

}  // namespace stof::board
