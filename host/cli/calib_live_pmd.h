#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/image.h"
#include "dsp/calib/calibration.h"
#include "host/cli/receive.h"

// The recordings that `stof calib pmd` takes, from a live sensor before which a wall is put at one
// known distance after the other.
namespace stof::host {

struct PmdLiveOptions : ReceiveOptions {
  std::vector<double> distances{};  // of the wall, from the PMD camera's lens along its axis, m
  std::size_t exposures = 30;       // of each wall
  bool on() const { return !sensor.empty(); }
};

// Frames of one PMD camera that shows a wall, A0 to A3 below each other: why they are no recording
// of it, or empty. It moved by more than 10 mm between the first and the second half of them, or
// half of the pixels in the middle are saturated.
std::string problem_of_wall(const std::vector<dataset::Image<std::uint16_t>>& frames,
                            const dsp::PmdSensor& camera);

// A recording in `folder` of each distance that it holds none of: z1500.json, z1500_raw.pgm. Each
// wall is asked for on stdout (aside: stderr), and taken when somebody presses Enter. `camera`:
// size, lens and levels of the PMD camera, of the calibration file `start`. Throws Failure: stopped
// or stdin ended (1; what was taken is kept), silent sensor (1), a camera of another size (2).
void record_pmd_walls(const PmdLiveOptions& options, const std::filesystem::path& folder,
                      const std::filesystem::path& start, const dsp::PmdSensor& camera, bool aside);

}  // namespace stof::host
