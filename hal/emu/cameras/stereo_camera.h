#pragma once

#include <cstdint>
#include <vector>

#include "hal/clock.h"
#include "hal/emu/cameras/exposure_simulator.h"
#include "hal/emu/cameras/trigger.h"
#include "hal/emu/devices/faults.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/stereo_camera.h"

namespace stof::hal::emu {

struct StereoTiming {
  Duration exposure = std::chrono::milliseconds(4);
  Duration readout = std::chrono::milliseconds(6);  // from its end until the frame is there
};

// Two global-shutter sensors on one trigger line: both expose [edge, edge + exposure]. An edge
// during an exposure is ignored, as such sensors do. Exposure numbers, and so sequences, count from
// 1. Four slots; when none is free the oldest unread frame is lost. Pixels are made inside
// wait_frame: on a real clock it takes that long on top of the wait. No heap after construction.
// Clock, imagery and live faults must outlive it, and it the frames it lends. Faults: faults.h.
class StereoCamera final : public hal::StereoCamera, public EdgeListener {
 public:
  StereoCamera(hal::Clock& clock, Imagery& imagery, const StereoTiming& timing,
               const FaultPlan& faults = {}, LiveFault* live = nullptr);

  void on_edge(Time edge) noexcept override;
  Result<BorrowedFrame<StereoFrame>> wait_frame(Time deadline) noexcept override;
  // Ends a kHang. For any thread.
  void reopen() noexcept { views_.reopen(); }

 private:
  struct View {
    std::uint32_t number = 0;
    Exposure exposure{};
    Time end() const noexcept { return exposure.end; }
  };
  using Views = ExposureSimulator<View>;  // first: left, second: right
  StereoFrame fill(const Views::Shot& shot, int buffer) noexcept;

  hal::Clock& clock_;
  Imagery& imagery_;
  StereoTiming timing_;
  std::vector<std::uint8_t> pixels_;
  Views views_;
};

}  // namespace stof::hal::emu
