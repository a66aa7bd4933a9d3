#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"
#include "firmware/wire/packet.h"

// The images of a frame, and the choice of those that are sent.
namespace stof::wire {

// kQuantised: RVL of depth and width rounded as far as the intervals do not care
// (interval_quantiser.h), and nothing else than kRvl of the other streams.
enum class Coding : std::uint8_t { kOff, kRaw, kRvl, kQuantised };

// The streams of a frame that are sent, and how.
struct StreamChoice {
  std::array<Coding, kStreams> coding{};  // of the cloud: kOff, or anything else
  bool parity = false;                    // one packet of exclusive-ors for each 16
  int cloud_step = 8;                     // px, 2 to 64

  Coding& of(Stream stream) noexcept { return coding[static_cast<std::size_t>(stream) - 1]; }
  Coding of(Stream stream) const noexcept { return coding[static_cast<std::size_t>(stream) - 1]; }
  friend bool operator==(const StreamChoice&, const StreamChoice&) = default;
};

inline constexpr std::size_t kPmdSamples = 4;  // of a pixel

// Whatever is empty is not sent. The images of the map have one size, those of the PMD camera too.
struct FrameImages {
  dsp::DepthMap map{};
  dsp::ImageView<const dsp::Disparity> disparity{};
  // As the camera gave them.
  std::array<dsp::ImageView<const std::uint16_t>, kPmdSamples> pmd{};
  dsp::ImageView<const std::uint8_t> left{};
  dsp::ImageView<const std::uint8_t> right{};
};

struct FrameSizes {
  int width = 0;
  int height = 0;
  int pmd_width = 0;  // 0: no PMD camera
  int pmd_height = 0;
};

}  // namespace stof::wire
