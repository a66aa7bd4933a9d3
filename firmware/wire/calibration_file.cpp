#include "firmware/wire/calibration_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"

namespace stof::wire {
namespace {

constexpr std::array<std::byte, 8> kMagic{std::byte{'S'}, std::byte{'T'}, std::byte{'O'},
                                          std::byte{'F'}, std::byte{'C'}, std::byte{'A'},
                                          std::byte{'L'}, std::byte{0}};
constexpr std::size_t kPreambleBytes = 16;  // magic, version, reserved, length of the file
constexpr std::size_t kCrcSize = 4;
constexpr std::size_t kPinholeBytes = 2 * 4 + 6 * 8;
constexpr std::size_t kStereoBytes = kPinholeBytes + 2 * 8;
constexpr std::size_t kPmdBytes = kPinholeBytes + 5 * 4 + 7 * 8 + 2 * dsp::kWigglingSteps;
constexpr std::size_t kTransformBytes = 12 * 8;
constexpr std::size_t kOptionsOffset = kPreambleBytes + kStereoBytes + kPmdBytes + kTransformBytes;
static_assert(kOptionsOffset == 572);
constexpr std::size_t kCountSize = 4;  // of the fixed pattern

// What a pair has beside the rectified left camera; the fields follow in this order.
constexpr std::uint16_t kFirstVersionWithOptions = 2;
constexpr std::size_t kOptionsSize = 4;
constexpr std::uint32_t kRawOption = 1;
constexpr std::uint32_t kConvergingOption = 2;
constexpr std::size_t kRawBytes = 2 * kPinholeBytes + kTransformBytes;
constexpr std::size_t kConvergingBytes = 7 * 8;

std::uint32_t options_of(const dsp::StereoRig& rig) noexcept {
  return (rig.raw ? kRawOption : 0) | (rig.converging ? kConvergingOption : 0);
}

std::size_t bytes_of(std::uint32_t options) noexcept {
  return ((options & kRawOption) != 0 ? kRawBytes : 0) +
         ((options & kConvergingOption) != 0 ? kConvergingBytes : 0);
}

// Both ends walk the same fields in the same order; the order is docs/WIRE.md's.
class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept : rest_(out) {}

  void field(int value) noexcept { put_i32(take<4>(), value); }
  void field(bool value) noexcept { put_u32(take<4>(), value ? 1 : 0); }
  void field(double value) noexcept { put_u64(take<8>(), std::bit_cast<std::uint64_t>(value)); }
  void field(std::int16_t value) noexcept { put_u16(take<2>(), static_cast<std::uint16_t>(value)); }
  void field(std::uint32_t value) noexcept { put_u32(take<4>(), value); }

 private:
  template <std::size_t kBytes>
  std::span<std::byte, kBytes> take() noexcept {
    const std::span<std::byte, kBytes> bytes = rest_.first<kBytes>();
    rest_ = rest_.subspan(kBytes);
    return bytes;
  }

  std::span<std::byte> rest_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> in) noexcept : rest_(in) {}

  void field(int& value) noexcept { value = get_i32(take<4>()); }
  void field(bool& value) noexcept { value = get_u32(take<4>()) != 0; }
  void field(double& value) noexcept { value = std::bit_cast<double>(get_u64(take<8>())); }
  void field(std::int16_t& value) noexcept {
    value = static_cast<std::int16_t>(get_u16(take<2>()));
  }
  void field(std::uint32_t& value) noexcept { value = get_u32(take<4>()); }

 private:
  template <std::size_t kBytes>
  std::span<const std::byte, kBytes> take() noexcept {
    const std::span<const std::byte, kBytes> bytes = rest_.first<kBytes>();
    rest_ = rest_.subspan(kBytes);
    return bytes;
  }

  std::span<const std::byte> rest_;
};

template <typename Walker, typename Lens>
void walk_lens(Walker& walker, Lens& lens) noexcept {
  walker.field(lens.width);
  walker.field(lens.height);
  walker.field(lens.fx);
  walker.field(lens.fy);
  walker.field(lens.cx);
  walker.field(lens.cy);
  walker.field(lens.k1);
  walker.field(lens.k2);
}

// A field that was added to the calibration must be added to the file, with a new version.
static_assert(sizeof(dsp::Calibration) == 856);

template <typename Walker, typename Transform>
void walk_transform(Walker& walker, Transform& transform) noexcept {
  for (auto& element : transform.rotation) {
    walker.field(element);
  }
  for (auto& element : transform.translation_m) {
    walker.field(element);
  }
}

template <typename Walker, typename Rig>
void walk_options(Walker& walker, Rig& rig) noexcept {
  if (rig.raw) {
    walk_lens(walker, rig.raw->left);
    walk_lens(walker, rig.raw->right);
    walk_transform(walker, rig.raw->left_to_right);
  }
  if (rig.converging) {
    walker.field(rig.converging->alpha_rad);
    walker.field(rig.converging->beta_rad);
    walker.field(rig.converging->f1_m);
    walker.field(rig.converging->f2_m);
    walker.field(rig.converging->pixel_m);
    walker.field(rig.converging->cx_left);
    walker.field(rig.converging->cx_right);
  }
}

// Everything but the options and the fixed pattern. Calib is dsp::Calibration or const
// dsp::Calibration.
template <typename Walker, typename Calib>
void walk(Walker& walker, Calib& calibration) noexcept {
  walk_lens(walker, calibration.stereo.left);
  walker.field(calibration.stereo.baseline_m);
  walker.field(calibration.stereo.doff_px);
  auto& pmd = calibration.pmd;
  walk_lens(walker, pmd.lens);
  walker.field(pmd.tone.modulation.value);
  walker.field(pmd.phase_falls);
  walker.field(pmd.saturation_lsb);
  walker.field(pmd.under_lsb);
  walker.field(pmd.min_amplitude_lsb);
  walker.field(pmd.dark_lsb);
  walker.field(pmd.tone.min_modulation_ratio);
  walker.field(pmd.asymmetry_sigmas);
  walker.field(pmd.electrons_per_lsb);
  walker.field(pmd.noise_lsb);
  walker.field(pmd.suppressed_lsb);
  walker.field(pmd.tone.offset_m);
  for (auto& step : pmd.tone.wiggling) {
    walker.field(step);
  }
  walk_transform(walker, calibration.pmd_to_stereo);
}

}  // namespace

std::size_t calibration_file_bytes(const dsp::Calibration& calibration) noexcept {
  return kOptionsOffset + kOptionsSize + bytes_of(options_of(calibration.stereo)) + kCountSize +
         calibration.pmd.fixed_pattern.size_bytes() + kCrcSize;
}

Result<std::size_t> encode_calibration_file(const dsp::Calibration& calibration,
                                            std::span<std::byte> out) noexcept {
  const std::size_t bytes = calibration_file_bytes(calibration);
  if (out.size() < bytes || bytes > UINT32_MAX) {
    return fail(Status::kTooLarge);
  }
  out = out.first(bytes);
  std::ranges::copy(kMagic, out.begin());
  put_u16(out.subspan<8, 2>(), kCalibrationFileVersion);
  put_u16(out.subspan<10, 2>(), 0);
  put_u32(out.subspan<12, 4>(), static_cast<std::uint32_t>(bytes));
  Writer writer(out.subspan(kPreambleBytes));
  walk(writer, calibration);
  writer.field(options_of(calibration.stereo));
  walk_options(writer, calibration.stereo);
  const std::span<const std::int16_t> pattern = calibration.pmd.fixed_pattern;
  writer.field(static_cast<std::uint32_t>(pattern.size()));
  put_pixels<std::int16_t>(
      out.subspan(bytes - kCrcSize - pattern.size_bytes(), pattern.size_bytes()), pattern);
  put_u32(out.last<kCrcSize>(), crc32c(out.first(bytes - kCrcSize)));
  return bytes;
}

Result<dsp::Calibration> decode_calibration_file(std::span<const std::byte> file,
                                                 std::span<std::int16_t> fixed_pattern) noexcept {
  if (file.size() < kPreambleBytes + kCrcSize || !std::ranges::equal(file.first<8>(), kMagic) ||
      get_u32(file.subspan<12, 4>()) != file.size() ||
      crc32c(file.first(file.size() - kCrcSize)) != get_u32(file.last<kCrcSize>())) {
    return fail(Status::kCorrupt);
  }
  const std::uint16_t version = get_u16(file.subspan<8, 2>());
  if (version < 1 || version > kCalibrationFileVersion) {
    return fail(Status::kUnsupported);
  }
  const std::span<const std::byte> body = file.first(file.size() - kCrcSize);
  std::size_t needed =
      kOptionsOffset + kCountSize + (version >= kFirstVersionWithOptions ? kOptionsSize : 0);
  if (body.size() < needed) {
    return fail(Status::kCorrupt);
  }
  dsp::Calibration calibration;
  Reader reader(body.subspan(kPreambleBytes));
  walk(reader, calibration);
  if (version >= kFirstVersionWithOptions) {
    std::uint32_t options = 0;
    reader.field(options);
    if ((options & ~(kRawOption | kConvergingOption)) != 0) {
      return fail(Status::kUnsupported);
    }
    needed += bytes_of(options);
    if (body.size() < needed) {
      return fail(Status::kCorrupt);
    }
    if ((options & kRawOption) != 0) {
      calibration.stereo.raw.emplace();
    }
    if ((options & kConvergingOption) != 0) {
      calibration.stereo.converging.emplace();
    }
    walk_options(reader, calibration.stereo);
  }
  std::uint32_t pixels = 0;
  reader.field(pixels);
  const std::span<const std::byte> pattern = body.subspan(needed);
  if (pattern.size() != sizeof(std::int16_t) * std::size_t{pixels}) {
    return fail(Status::kCorrupt);
  }
  if (pixels > fixed_pattern.size()) {
    return fail(Status::kTooLarge);
  }
  const std::span<std::int16_t> stored = fixed_pattern.first(pixels);
  get_pixels(pattern, stored);
  calibration.pmd.fixed_pattern = stored;
  return calibration;
}

}  // namespace stof::wire
