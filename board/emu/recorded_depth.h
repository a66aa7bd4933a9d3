#pragma once

#include "board/replay.h"
#include "dsp/fusion/depth_map.h"
#include "host/recording/recording.h"

namespace stof::board {

// Whether what is computed again is what was recorded, bit for bit, once it is rounded as it was
// for sending. Images that were not recorded are not compared; those that were have to be whole.
bool equals_recorded(const dsp::DepthMap& computed, const Replay::Sent& sent,
                     const recording::RecordedFrame& recorded);

// All packets of the frame arrived, and there is depth in it.
bool comparable(const recording::RecordedFrame& recorded) noexcept;

}  // namespace stof::board
