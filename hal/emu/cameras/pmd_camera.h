#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/clock.h"
#include "hal/emu/cameras/exposure_simulator.h"
#include "hal/emu/cameras/trigger.h"
#include "hal/emu/devices/faults.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/pmd_camera.h"

namespace stof::hal::emu {

struct PmdTiming {
  Duration integration = std::chrono::milliseconds(16);  // of all four samples together
  Duration readout = std::chrono::milliseconds(4);       // from its end until the frame is there
  int every = 1;  // exposes at the first edge and at every so many after it, at least 1
};

// Four samples one after the other, sample k in the k-th quarter of the integration. An edge during
// an integration is counted, but ignored. Sets count from 1. Slots, heap, lifetime and rendering
// time as emu::StereoCamera. Faults: faults.h; their calls count the edges at which it would
// expose.
class PmdCamera final : public hal::PmdCamera, public EdgeListener {
 public:
  // imagery.pmd_size() must not be empty.
  PmdCamera(hal::Clock& clock, Imagery& imagery, const PmdTiming& timing,
            const FaultPlan& faults = {}, LiveFault* live = nullptr);

  void on_edge(Time edge) noexcept override;
  Result<BorrowedFrame<PmdFrame>> wait_frame(Time deadline) noexcept override;
  // Ends a kHang. For any thread.
  void reopen() noexcept { sets_.reopen(); }

 private:
  struct Set {
    std::uint32_t number = 0;
    std::array<Exposure, 4> exposures{};
    Time end() const noexcept { return exposures.back().end; }
  };
  using Sets = ExposureSimulator<Set>;  // first: A0 and A1, second: A2 and A3
  PmdFrame fill(const Sets::Shot& shot, int buffer) noexcept;

  hal::Clock& clock_;
  Imagery& imagery_;
  PmdTiming timing_;
  std::vector<std::uint16_t> samples_;
  Sets sets_;
  std::uint32_t edges_ = 0;
};

}  // namespace stof::hal::emu
