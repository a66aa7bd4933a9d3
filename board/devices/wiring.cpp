#include "board/devices/wiring.h"

namespace stof::board {

const PairConfig& pair_of(const DeviceOptions& device_options) {
  return device_options.cameras == PairKind::kLibcamera ? kDevices.libcamera : kDevices.v4l2;
}

int priority_of(const DeviceOptions& device_options) {
  return device_options.priority.value_or(kDevices.priority);
}

// What is not wired is fanned out of the left camera's line.
hal::linux::GpioTriggerOptions trigger_options(const DeviceOptions& device_options) {
  const PairConfig& pair = pair_of(device_options);
  hal::linux::GpioTriggerOptions options;
  options.active_low = pair.active_low;
  options.width = pulse_length(pair, kTiming.stereo_exposure);
  options.width_is_exposure = pair.pulse == hal::Duration::zero();
  options.max_uncertainty = kTiming.edge_tolerance;
  for (const Net& net :
       {kDevices.nets.left_trigger, kDevices.nets.right_trigger, kDevices.nets.pmd_trigger}) {
    if (net.wired()) {
      options.outputs.emplace_back(net.line);
    }
  }
  for (const std::string& line : strobe_lines(device_options)) {
    if (!line.empty()) {
      options.strobes.push_back(line);
    }
  }
  return options;
}

}  // namespace stof::board
