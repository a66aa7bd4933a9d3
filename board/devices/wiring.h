#pragma once

#include "board/devices/request.h"
#include "hal/linux/gpio/gpio_trigger.h"

// How the trigger of a board with real devices is driven, and what it listens to.
namespace stof::board {

// The table's pair of the requested kind.
const PairConfig& pair_of(const Request& request);

// SCHED_FIFO, of what computes; 0: none.
int priority_of(const Request& request);

hal::linux::GpioTriggerOptions trigger_options(const Request& request);

}  // namespace stof::board
