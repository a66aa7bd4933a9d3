#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/status.h"
#include "dsp/fusion/depth_map.h"
#include "firmware/wire/datagram_sink.h"
#include "firmware/wire/frame/tiles.h"
#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/frame_info.h"
#include "firmware/wire/packet.h"

namespace stof::wire {

inline constexpr std::size_t kStreams = 8;  // streams 1 to 8; index: number less 1

// kFit: RVL of depth and width rounded as far as the intervals do not care (interval_quantiser.h),
// and nothing else than kRvl of the other streams.
enum class Coding : std::uint8_t { kOff, kRaw, kRvl, kFit };

// What of a frame is sent, and how.
struct StreamChoice {
  std::array<Coding, kStreams> coding{};  // of the cloud: kOff, or anything else
  bool parity = false;                    // one packet of exclusive-ors for each 16
  int cloud_step = 8;                     // px, 2 to 64

  Coding& of(Stream stream) noexcept { return coding[static_cast<std::size_t>(stream) - 1]; }
  Coding of(Stream stream) const noexcept { return coding[static_cast<std::size_t>(stream) - 1]; }
  friend bool operator==(const StreamChoice&, const StreamChoice&) = default;
};

// Whatever is empty is not sent. The images of the map have one size, those of the PMD camera too.
struct FrameImages {
  dsp::DepthMap map{};
  dsp::ImageView<const dsp::Disparity> disparity{};
  std::array<dsp::ImageView<const std::uint16_t>, 4> pmd{};  // as the camera gave them
  dsp::ImageView<const std::uint8_t> left{};
  dsp::ImageView<const std::uint8_t> right{};
};

struct FrameSizes {
  int width = 0;
  int height = 0;
  int pmd_width = 0;  // 0: no PMD camera
  int pmd_height = 0;
};

// One frame as sealed datagrams in memory of its own. Their number is known before the first is
// sent, and all receivers get the same. No heap.
class FrameCoder {
 public:
  // Datagrams of every stream of a frame of these sizes, raw, with parity.
  static std::size_t most_packets(const FrameSizes& sizes) noexcept;
  // Enough for depth, width and source as they are sent by default, with parity.
  static std::size_t usual_packets(const FrameSizes& sizes) noexcept;

  // With memory for so many datagrams at a time.
  static std::size_t bytes_needed(const FrameSizes& sizes, std::size_t packets) noexcept;
  static std::size_t bytes_needed(const FrameSizes& sizes) noexcept {
    return bytes_needed(sizes, most_packets(sizes));
  }

  // The cloud's points are those of the lens of `calibration`; its fx and fy are positive.
  FrameCoder(const Origin& origin, const FrameSizes& sizes, const CalibrationPacket& calibration,
             dsp::Arena& arena, std::size_t packets) noexcept;
  FrameCoder(const Origin& origin, const FrameSizes& sizes, const CalibrationPacket& calibration,
             dsp::Arena& arena) noexcept
      : FrameCoder(origin, sizes, calibration, arena, most_packets(sizes)) {}

  // The frame's datagrams in the order of sending, valid until the next call: frame info (which
  // gets tiles, parity_groups and cloud_step written into it), the streams in the order of their
  // numbers, parity at the end of it all. Tiles are cut as tiles.h says. kTooLarge: images larger
  // than said, or more than 65,535 packets or pixels of a row or column; nothing is coded then.
  // Also where the memory does not hold all of them.
  Result<Datagrams> code(const FrameStamp& stamp, const FrameInfo& info, const FrameImages& images,
                         const StreamChoice& choice) noexcept;
  // The same datagrams to a sink. What the memory does not hold is coded twice: first to count it.
  Status code(const FrameStamp& stamp, const FrameInfo& info, const FrameImages& images,
              const StreamChoice& choice, DatagramSink& sink) noexcept;

 private:
  // What becomes of depth or width.
  struct Rounding {
    Stream stream = Stream::kDepth;
    bool depth = true;   // depth is rounded; the widths are those of the rounded depth
    bool scaled = true;  // the stream travels in units of its bands' scales
  };

  // A frame that does not fit the memory, on its way to the sink.
  class Passage;

  static std::size_t buffers_of(const FrameSizes& sizes, std::size_t packets) noexcept;
  static std::size_t groups_of(const FrameSizes& sizes, std::size_t packets) noexcept;

  // Codes all parts as far as the memory goes; false: it does not hold them.
  bool count(const FrameInfo& info, const FrameImages& images, const StreamChoice& choice) noexcept;
  Datagrams seal_all(const FrameStamp& stamp, const StreamChoice& choice) noexcept;
  void add_info(const FrameImages& images) noexcept;
  bool fits(const FrameImages& images) const noexcept;
  void add_streams(const FrameImages& images, const StreamChoice& choice) noexcept;
  template <typename T>
  void add_image(dsp::ImageView<const T> image, Stream stream, Coding coding) noexcept;
  void add_map(const dsp::DepthMap& map, const StreamChoice& choice) noexcept;
  void add_depth_and_width(const dsp::DepthMap& map, const StreamChoice& choice) noexcept;
  std::span<std::uint16_t> rounded(const dsp::DepthMap& map, const Rounding& rounding) noexcept;
  void add_scaled_tiles(std::span<std::uint16_t> values, const Raster& raster) noexcept;
  void add_source(const dsp::DepthMap& map, Coding coding) noexcept;
  bool add_steps(std::span<std::uint8_t> values, Raster raster) noexcept;
  void add_disparity(dsp::ImageView<const dsp::Disparity> image, Coding coding) noexcept;
  void add_pmd(const FrameImages& images, Coding coding) noexcept;
  template <typename T>
  std::span<T> room(std::size_t count) noexcept;
  template <typename T>
  void add_values(std::span<const T> values, const Raster& raster, Coding coding) noexcept;
  template <typename T>
  void add_tiles(std::span<const T> values, Stream stream, int width, int height,
                 Coding coding) noexcept;
  FrameInfo counted(const FrameInfo& info, const StreamChoice& choice) noexcept;
  std::span<const std::byte> seal_part(std::size_t index, std::uint16_t count,
                                       const FrameStamp& stamp) noexcept;
  std::span<const std::byte> seal_parity(ParityGroup& group, std::uint16_t index,
                                         std::uint16_t count, const FrameStamp& stamp,
                                         DatagramBuffer& buffer) noexcept;
  void gather(ParityGroup& group, std::size_t index, std::uint16_t count,
              const FrameStamp& stamp) noexcept;
  Header header_of(std::size_t index, std::uint16_t count, const FrameStamp& stamp) noexcept;

  Origin origin_;
  FrameSizes sizes_;
  CalibrationPacket calibration_;
  PartStore store_;
  std::span<std::span<const std::byte>> datagrams_;
  std::span<std::uint16_t> values16_;  // of an image that is not one piece in memory
  std::span<std::uint8_t> values8_;    // the same memory
  std::span<std::uint8_t> scales_;     // of the map's bands
  std::span<ParityGroup> groups_;      // one, or all where the memory may not hold a frame
  FrameInfo info_;                     // of this frame
  // What was found when its parts were counted.
  std::array<bool, kStreams> is_raw_{};  // RVL of this stream would have been longer
  bool no_steps_ = false;                // the source goes as it is
};

}  // namespace stof::wire
