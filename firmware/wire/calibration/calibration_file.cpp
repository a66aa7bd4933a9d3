#include "firmware/wire/calibration/calibration_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/calibration/calibration_fields.h"
#include "firmware/wire/crc32c.h"

namespace stof::wire {
namespace {

constexpr std::array<std::byte, 8> kMagic{std::byte{'S'}, std::byte{'T'}, std::byte{'O'},
                                          std::byte{'F'}, std::byte{'C'}, std::byte{'A'},
                                          std::byte{'L'}, std::byte{0}};
constexpr std::size_t kPreambleBytes = 16;  // magic, version, reserved, length of the file
constexpr std::size_t kCrcSize = 4;
constexpr std::size_t kCountSize = 4;  // of the fixed pattern

std::uint32_t options_of(const dsp::Calibration& calibration) noexcept {
  return (calibration.stereo.raw ? kRawOption : 0) |
         (calibration.stereo.converging ? kConvergingOption : 0) |
         (calibration.pmd.second ? kSecondFrequencyOption : 0) |
         (calibration.pmd.sigma_polynomial ? kSigmaOption : 0);
}

std::uint32_t options_known_to(std::uint16_t version) noexcept {
  const std::uint32_t pairs = kRawOption | kConvergingOption;
  return version < kFirstVersionWithLights ? pairs : pairs | kSecondFrequencyOption | kSigmaOption;
}

void make_room(std::uint32_t options, dsp::Calibration& calibration) noexcept {
  if ((options & kRawOption) != 0) {
    calibration.stereo.raw.emplace();
  }
  if ((options & kConvergingOption) != 0) {
    calibration.stereo.converging.emplace();
  }
  if ((options & kSecondFrequencyOption) != 0) {
    calibration.pmd.second.emplace();
  }
  if ((options & kSigmaOption) != 0) {
    calibration.pmd.sigma_polynomial.emplace();
  }
}

// All walk the same fields in the same order; the order is docs/WIRE.md's.
class Counter {
 public:
  static std::uint16_t version() noexcept { return kCalibrationFileVersion; }
  void field(int) noexcept { bytes_ += 4; }
  void field(bool) noexcept { bytes_ += 4; }
  void field(double) noexcept { bytes_ += 8; }
  void field(std::int16_t) noexcept { bytes_ += 2; }
  void field(std::uint32_t) noexcept { bytes_ += 4; }
  std::size_t bytes() const noexcept { return bytes_; }

 private:
  std::size_t bytes_ = 0;
};

class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept : rest_(out) {}

  static std::uint16_t version() noexcept { return kCalibrationFileVersion; }
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

// Reads zeros behind the end, and says so.
class Reader {
 public:
  Reader(std::span<const std::byte> in, std::uint16_t version) noexcept
      : rest_(in), version_(version) {}

  std::uint16_t version() const noexcept { return version_; }
  bool is_short() const noexcept { return is_short_; }
  bool is_wrong() const noexcept { return is_wrong_; }  // a truth value that is neither 0 nor 1
  std::span<const std::byte> rest() const noexcept { return rest_; }
  void field(int& value) noexcept { value = get_i32(take<4>()); }
  void field(bool& value) noexcept {
    const std::uint32_t number = get_u32(take<4>());
    is_wrong_ |= number > 1;
    value = number != 0;
  }
  void field(double& value) noexcept { value = std::bit_cast<double>(get_u64(take<8>())); }
  void field(std::int16_t& value) noexcept {
    value = static_cast<std::int16_t>(get_u16(take<2>()));
  }
  void field(std::uint32_t& value) noexcept { value = get_u32(take<4>()); }

 private:
  template <std::size_t kBytes>
  std::span<const std::byte, kBytes> take() noexcept {
    static constexpr std::array<std::byte, kBytes> kNothing{};
    if (rest_.size() < kBytes) {
      is_short_ = true;
      rest_ = {};
      return kNothing;
    }
    const std::span<const std::byte, kBytes> bytes = rest_.first<kBytes>();
    rest_ = rest_.subspan(kBytes);
    return bytes;
  }

  std::span<const std::byte> rest_;
  std::uint16_t version_;
  bool is_short_ = false;
  bool is_wrong_ = false;
};

template <typename Walker>
void walk_all(Walker& walker, const dsp::Calibration& calibration) noexcept {
  walk(walker, calibration);
  walker.field(options_of(calibration));
  walk_options(walker, calibration);
}

// Everything in front of the fixed pattern.
Result<dsp::Calibration> read_all(Reader& reader) noexcept {
  dsp::Calibration calibration;
  walk(reader, calibration);
  if (reader.version() >= kFirstVersionWithOptions) {
    std::uint32_t options = 0;
    reader.field(options);
    if ((options & ~options_known_to(reader.version())) != 0) {
      return fail(Status::kUnsupported);
    }
    make_room(options, calibration);
    walk_options(reader, calibration);
  }
  return calibration;
}

}  // namespace

std::size_t calibration_file_bytes(const dsp::Calibration& calibration) noexcept {
  Counter counter;
  walk_all(counter, calibration);
  return kPreambleBytes + counter.bytes() + kCountSize +
         calibration.pmd.fixed_pattern.size_bytes() + kCrcSize;
}

std::size_t most_calibration_file_bytes(std::size_t pattern_pixels) noexcept {
  dsp::Calibration largest;
  make_room(kRawOption | kConvergingOption | kSecondFrequencyOption | kSigmaOption, largest);
  return calibration_file_bytes(largest) + pattern_pixels * sizeof(std::int16_t);
}

std::uint32_t calibration_fingerprint(std::span<const std::byte> file) noexcept {
  return file.size() < kCrcSize ? 0 : get_u32(file.last<kCrcSize>());
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
  walk_all(writer, calibration);
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
  Reader reader(file.first(file.size() - kCrcSize).subspan(kPreambleBytes), version);
  Result<dsp::Calibration> calibration = read_all(reader);
  if (!calibration) {
    return calibration;
  }
  std::uint32_t pixels = 0;
  reader.field(pixels);
  const std::span<const std::byte> pattern = reader.rest();
  if (reader.is_short() || reader.is_wrong() ||
      pattern.size() != sizeof(std::int16_t) * std::size_t{pixels}) {
    return fail(Status::kCorrupt);
  }
  if (pixels > fixed_pattern.size()) {
    return fail(Status::kTooLarge);
  }
  const std::span<std::int16_t> stored = fixed_pattern.first(pixels);
  get_pixels(pattern, stored);
  calibration->pmd.fixed_pattern = stored;
  return calibration;
}

}  // namespace stof::wire
