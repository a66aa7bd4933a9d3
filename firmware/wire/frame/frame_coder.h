#pragma once

#include <cstddef>

#include "dsp/base/arena.h"
#include "dsp/base/status.h"
#include "firmware/wire/datagram_sink.h"
#include "firmware/wire/frame/frame_images.h"
#include "firmware/wire/frame/frame_sealer.h"
#include "firmware/wire/frame/image_coder.h"
#include "firmware/wire/frame/part_store.h"
#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/frame_info.h"
#include "firmware/wire/packet.h"

namespace stof::wire {

// One frame as sealed datagrams in memory of its own. Their number is known before the first is
// sent, and all receivers get the same. No heap.
class FrameCoder {
 public:
  // Datagrams of every stream of a frame of these sizes, raw, with parity.
  static std::size_t most_packets(const FrameSizes& sizes) noexcept;
  // Enough for depth, width and source as they are sent by default, with parity.
  static std::size_t usual_packets(const FrameSizes& sizes) noexcept;

  // packets: datagrams that there is memory for at a time. The cloud's points are those of the lens
  // of `calibration`; its fx and fy are positive.
  FrameCoder(const Origin& origin, const FrameSizes& sizes, const CalibrationPacket& calibration,
             dsp::Arena& arena, std::size_t packets) noexcept;

  // From the next frame on; of the same sizes.
  void set_calibration(const CalibrationPacket& calibration) noexcept {
    calibration_ = calibration;
  }

  // The frame's datagrams in the order of sending, valid until the next call: frame info (which
  // gets tiles, parity_groups and cloud_step written into it), the streams in the order of their
  // numbers, parity at the end of it all. Tiles are cut as tiles.h says. kTooLarge: images larger
  // than said, or more than 65,535 packets or pixels of a row or column; nothing is coded then.
  // Also where the memory does not hold all of them.
  Result<Datagrams> code(const FrameStamp& stamp, const FrameInfo& info, const FrameImages& images,
                         const StreamChoice& choice) noexcept;
  // The same datagrams to a sink. A frame larger than the memory is coded twice: first to count it.
  Status code(const FrameStamp& stamp, const FrameInfo& info, const FrameImages& images,
              const StreamChoice& choice, DatagramSink& sink) noexcept;

 private:
  // Codes all parts as far as the memory goes; false: it does not hold them.
  bool count(const FrameInfo& info, const FrameImages& images, const StreamChoice& choice) noexcept;
  bool fits(const FrameImages& images) const noexcept;
  void add_info(const FrameImages& images) noexcept;
  void add_streams(const FrameImages& images, const StreamChoice& choice) noexcept;
  FrameInfo counted(const FrameInfo& info, const StreamChoice& choice) noexcept;
  FrameSealer sealer(const FrameStamp& stamp, const StreamChoice& choice) noexcept;
  Datagrams seal_all(const FrameStamp& stamp, const StreamChoice& choice) noexcept;

  Origin origin_;
  FrameSizes sizes_;
  CalibrationPacket calibration_;
  ImageCoder images_;
  PartStore store_;
  SealingMemory memory_;
  FrameInfo info_;  // of this frame
};

}  // namespace stof::wire
