#include "firmware/loop/pairing.h"

#include <cstddef>

namespace stof::firmware {
namespace {

template <typename T>
bool has_size(const dsp::ImageView<T>& image, int width, int height) noexcept {
  return image.width() == width && image.height() == height;
}

// The four samples of one frame against one edge.
Drop match_samples(const ExposureWindow& window, const hal::PmdFrame& frame) noexcept {
  const Drop first = match_exposure(window, frame.exposures[0]);
  if (first != Drop::kNone) {
    return first;
  }
  const hal::Time latest = window.edge + window.exposure + window.tolerance;
  for (std::size_t k = 1; k < frame.exposures.size(); ++k) {
    const hal::Exposure& sample = frame.exposures[k];
    if (sample.begin < frame.exposures[k - 1].end || sample.begin > latest) {
      return Drop::kTorn;
    }
    if (sample.end <= sample.begin || sample.end > latest) {
      return Drop::kBadStamp;
    }
  }
  return Drop::kNone;
}

}  // namespace

Drop match_exposure(const ExposureWindow& window, const hal::Exposure& exposure) noexcept {
  if (exposure.begin < window.edge - window.tolerance) {
    return Drop::kOlderEdge;
  }
  if (exposure.begin > window.edge + window.tolerance) {
    return Drop::kNewerEdge;
  }
  // begin is near the edge now: the sum cannot overflow.
  const hal::Time latest = exposure.begin + window.exposure + window.tolerance;
  return exposure.end > exposure.begin && exposure.end <= latest ? Drop::kNone : Drop::kBadStamp;
}

bool SequenceGuard::advances(std::uint32_t sequence) noexcept {
  if (!accepted_ || (anew_ && sequence != *accepted_)) {
    return true;
  }
  const std::uint32_t step = sequence - *accepted_;  // wraps as the sensor's counter does
  if (step >= 1 && step <= kMaxStep) {
    return true;
  }
  run_ = run_ > 0 && sequence == refused_ + 1 ? run_ + 1 : 1;
  refused_ = sequence;
  return run_ >= kRestart;
}

void SequenceGuard::accept(std::uint32_t sequence) noexcept {
  accepted_ = sequence;
  run_ = 0;
  anew_ = false;
}

Drop StereoPairing::judge(const ExposureWindow& window, const hal::StereoFrame& frame) noexcept {
  if (!has_size(frame.left, width_, height_) || !has_size(frame.right, width_, height_)) {
    return Drop::kWrongSize;
  }
  const bool left_new = left_.advances(frame.left_sequence);
  const bool right_new = right_.advances(frame.right_sequence);
  const Drop left = match_exposure(window, frame.left_exposure);
  const Drop right = match_exposure(window, frame.right_exposure);
  if (left_new != right_new) {
    return Drop::kTorn;
  }
  if (!left_new) {
    return Drop::kStale;
  }
  if (left != right) {
    return Drop::kTorn;
  }
  if (left == Drop::kNone) {
    left_.accept(frame.left_sequence);
    right_.accept(frame.right_sequence);
  }
  return left;
}

void StereoPairing::forget() noexcept {
  left_.forget();
  right_.forget();
}

void StereoPairing::expect_another() noexcept {
  left_.expect_another();
  right_.expect_another();
}

PmdVerdict PmdPairing::judge(std::span<const ExposureWindow> windows,
                             const hal::PmdFrame& frame) noexcept {
  for (const auto& sample : frame.samples) {
    if (!has_size(sample, width_, height_)) {
      return {Drop::kWrongSize};
    }
  }
  if (!sequence_.advances(frame.sequence)) {
    return {Drop::kStale};
  }
  const Drop newest = match_samples(windows.front(), frame);
  if (newest != Drop::kOlderEdge) {
    if (newest == Drop::kNone) {
      sequence_.accept(frame.sequence);
    }
    return {newest};
  }
  for (std::size_t age = 1; age < windows.size(); ++age) {
    if (match_samples(windows[age], frame) == Drop::kNone) {
      sequence_.accept(frame.sequence);
      return {Drop::kNone, static_cast<int>(age)};
    }
  }
  return {Drop::kOlderEdge};
}

}  // namespace stof::firmware
