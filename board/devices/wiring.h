#pragma once

#include "board/devices/device_options.h"
#include "hal/linux/gpio/gpio_trigger.h"

// How the trigger of a board with real devices is driven, and what it listens to.
namespace stof::board {

// The board's table, what of it this folder reads.
inline constexpr const DeviceConfig& kDevices = kConfig.devices;
inline constexpr const TimingConfig& kTiming = kConfig.timing;

// The table's pair of the requested kind.
const PairConfig& pair_of(const DeviceOptions& device_options);

// SCHED_FIFO, of what computes; 0: none.
int priority_of(const DeviceOptions& device_options);

hal::linux::GpioTriggerOptions trigger_options(const DeviceOptions& device_options);

}  // namespace stof::board
