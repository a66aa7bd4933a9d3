#include "firmware/wire/calibration/calibration_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "tests/firmware/wire/calibration/some_calibration.h"
#include "tests/support/guarded_memory.h"

namespace stof::wire {
namespace {

using test::newest_calibration;
using test::some_calibration;
using test::some_pattern;
using File = std::vector<std::byte>;

File encoded(const dsp::Calibration& calibration) {
  test::GuardedBuffer<std::byte> out(calibration_file_bytes(calibration));
  const Result<std::size_t> bytes = encode_calibration_file(calibration, out.span());
  EXPECT_TRUE(bytes);
  EXPECT_EQ(bytes.value_or(0), out.size());
  return {out.span().begin(), out.span().end()};
}

void reseal(File& file) {
  put_u32(std::span(file).last<4>(), crc32c(std::span(file).first(file.size() - 4)));
}

void expect_equal(const dsp::Pinhole& a, const dsp::Pinhole& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.k1, b.k1);
  EXPECT_EQ(a.k2, b.k2);
  EXPECT_EQ(a.k3, b.k3);
  EXPECT_EQ(a.p1, b.p1);
  EXPECT_EQ(a.p2, b.p2);
}

void expect_equal(const dsp::PmdFrequency& a, const dsp::PmdFrequency& b) {
  EXPECT_EQ(a.modulation.value, b.modulation.value);
  EXPECT_EQ(a.min_modulation_ratio, b.min_modulation_ratio);
  EXPECT_EQ(a.offset_m, b.offset_m);
  EXPECT_EQ(a.offset_m_per_k, b.offset_m_per_k);
  EXPECT_EQ(a.wiggling, b.wiggling);
  EXPECT_EQ(a.stray_i_lsb, b.stray_i_lsb);
  EXPECT_EQ(a.stray_q_lsb, b.stray_q_lsb);
}

TEST(CalibrationFile, GivesBackEveryField) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const dsp::Calibration want = newest_calibration(pattern);
  std::vector<std::int16_t> space(20);
  const Result<dsp::Calibration> got = decode_calibration_file(encoded(want), space);
  ASSERT_TRUE(got);
  expect_equal(got->stereo.left, want.stereo.left);
  EXPECT_EQ(got->stereo.baseline_m, want.stereo.baseline_m);
  EXPECT_EQ(got->stereo.doff_px, want.stereo.doff_px);
  expect_equal(got->pmd.lens, want.pmd.lens);
  expect_equal(got->pmd.frequency, want.pmd.frequency);
  EXPECT_FALSE(got->pmd.second);
  EXPECT_FALSE(got->pmd.sigma_polynomial);
  EXPECT_EQ(got->pmd.phase_falls, want.pmd.phase_falls);
  EXPECT_EQ(got->pmd.dark_lsb, want.pmd.dark_lsb);
  EXPECT_EQ(got->pmd.saturation_lsb, want.pmd.saturation_lsb);
  EXPECT_EQ(got->pmd.under_lsb, want.pmd.under_lsb);
  EXPECT_EQ(got->pmd.min_amplitude_lsb, want.pmd.min_amplitude_lsb);
  EXPECT_EQ(got->pmd.asymmetry_sigmas, want.pmd.asymmetry_sigmas);
  EXPECT_EQ(got->pmd.electrons_per_lsb, want.pmd.electrons_per_lsb);
  EXPECT_EQ(got->pmd.noise_lsb, want.pmd.noise_lsb);
  EXPECT_EQ(got->pmd.suppressed_lsb, want.pmd.suppressed_lsb);
  EXPECT_EQ(got->pmd.integration_us, want.pmd.integration_us);
  EXPECT_EQ(got->pmd.reference_c, want.pmd.reference_c);
  EXPECT_EQ(got->pmd.scale, want.pmd.scale);
  EXPECT_EQ(got->pmd.shift_m, want.pmd.shift_m);
  EXPECT_EQ(got->pmd.white_lsb, want.pmd.white_lsb);
  EXPECT_EQ(got->pmd.emitter_count, want.pmd.emitter_count);
  EXPECT_EQ(got->pmd.emitters, want.pmd.emitters);
  EXPECT_EQ(got->pmd_to_stereo.rotation, want.pmd_to_stereo.rotation);
  EXPECT_EQ(got->pmd_to_stereo.translation_m, want.pmd_to_stereo.translation_m);
  EXPECT_TRUE(std::ranges::equal(got->pmd.fixed_pattern, pattern));
  EXPECT_EQ(got->pmd.fixed_pattern.data(), space.data());
}

TEST(CalibrationFile, GivesBackEveryOption) {
  const dsp::Calibration want = newest_calibration({}, true);
  const Result<dsp::Calibration> got = decode_calibration_file(encoded(want), {});
  ASSERT_TRUE(got);
  ASSERT_TRUE(got->stereo.raw);
  expect_equal(got->stereo.raw->left, want.stereo.raw->left);
  expect_equal(got->stereo.raw->right, want.stereo.raw->right);
  EXPECT_EQ(got->stereo.raw->left_to_right.rotation, want.stereo.raw->left_to_right.rotation);
  EXPECT_EQ(got->stereo.raw->left_to_right.translation_m,
            want.stereo.raw->left_to_right.translation_m);
  ASSERT_TRUE(got->stereo.converging);
  EXPECT_EQ(got->stereo.converging->alpha_rad, want.stereo.converging->alpha_rad);
  EXPECT_EQ(got->stereo.converging->beta_rad, want.stereo.converging->beta_rad);
  EXPECT_EQ(got->stereo.converging->f1_m, want.stereo.converging->f1_m);
  EXPECT_EQ(got->stereo.converging->f2_m, want.stereo.converging->f2_m);
  EXPECT_EQ(got->stereo.converging->pixel_m, want.stereo.converging->pixel_m);
  EXPECT_EQ(got->stereo.converging->cx_left, want.stereo.converging->cx_left);
  EXPECT_EQ(got->stereo.converging->cx_right, want.stereo.converging->cx_right);
  ASSERT_TRUE(got->pmd.second);
  expect_equal(*got->pmd.second, *want.pmd.second);
  ASSERT_TRUE(got->pmd.sigma_polynomial);
  EXPECT_EQ(got->pmd.sigma_polynomial->a, want.pmd.sigma_polynomial->a);
  EXPECT_EQ(got->pmd.sigma_polynomial->b, want.pmd.sigma_polynomial->b);
  EXPECT_EQ(got->pmd.sigma_polynomial->c, want.pmd.sigma_polynomial->c);
  for (unsigned options = 0; options < 16; ++options) {
    dsp::Calibration some = want;
    const auto keep = [options](unsigned bit, auto& optional) {
      if ((options & bit) == 0) {
        optional.reset();
      }
    };
    keep(1, some.stereo.raw);
    keep(2, some.stereo.converging);
    keep(4, some.pmd.second);
    keep(8, some.pmd.sigma_polynomial);
    const Result<dsp::Calibration> again = decode_calibration_file(encoded(some), {});
    ASSERT_TRUE(again);
    EXPECT_EQ(again->stereo.raw.has_value(), (options & 1) != 0);
    EXPECT_EQ(again->stereo.converging.has_value(), (options & 2) != 0);
    EXPECT_EQ(again->pmd.second.has_value(), (options & 4) != 0);
    EXPECT_EQ(again->pmd.sigma_polynomial.has_value(), (options & 8) != 0);
    EXPECT_EQ(encoded(*again), encoded(some));
  }
}

// Without what later versions added: bytes [begin, end) of the newest file, last ones first.
File as_version(int version, File file, std::span<const std::array<std::ptrdiff_t, 2>> added) {
  for (const auto& [begin, end] : added) {
    file.erase(file.begin() + begin, file.begin() + end);
  }
  file[8] = static_cast<std::byte>(version);
  put_u32(std::span(file).subspan<12, 4>(), static_cast<std::uint32_t>(file.size()));
  reseal(file);
  return file;
}

// The rest of the frequency, exposure and lights; k3, p1, p2 of the PMD's and the left lens.
constexpr std::array<std::array<std::ptrdiff_t, 2>, 3> kSinceVersion2{
    {{524, 688}, {168, 192}, {72, 96}}};
// The options too.
constexpr std::array<std::array<std::ptrdiff_t, 2>, 4> kSinceVersion1{
    {{784, 788}, {524, 688}, {168, 192}, {72, 96}}};
// Those of both raw lenses too.
constexpr std::array<std::array<std::ptrdiff_t, 2>, 5> kSinceVersion2WithRaw{
    {{924, 948}, {844, 868}, {524, 688}, {168, 192}, {72, 96}}};

void expect_short_ones_corrupt(const File& whole) {
  for (std::size_t size = 20; size < whole.size(); ++size) {
    test::GuardedBuffer<std::byte> cut(size);
    std::copy_n(whole.begin(), size, cut.span().begin());
    put_u32(cut.span().subspan<12, 4>(), static_cast<std::uint32_t>(size));
    put_u32(cut.span().last<4>(), crc32c(cut.span().first(size - 4)));
    ASSERT_EQ(decode_calibration_file(cut.span(), {}).error(), Status::kCorrupt) << size;
  }
}

TEST(CalibrationFile, ReadsVersion1AndWritesTheNewest) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const File newest = encoded(some_calibration(pattern));
  std::vector<std::int16_t> space(15);
  const File old = as_version(1, newest, kSinceVersion1);
  EXPECT_EQ(old.size(), 580U + 30U);
  const Result<dsp::Calibration> got = decode_calibration_file(old, space);
  ASSERT_TRUE(got);
  EXPECT_FALSE(got->stereo.raw);
  EXPECT_FALSE(got->stereo.converging);
  EXPECT_EQ(encoded(*got), newest);  // what it does not know is what a calibration begins with
  expect_short_ones_corrupt(old);
}

TEST(CalibrationFile, ReadsVersion2AndWritesTheNewest) {
  const std::vector<std::int16_t> pattern = some_pattern();
  std::vector<std::int16_t> space(15);
  for (const bool options : {false, true}) {
    const File newest = encoded(some_calibration(pattern, options));
    const std::span<const std::array<std::ptrdiff_t, 2>> added =
        options ? std::span<const std::array<std::ptrdiff_t, 2>>(kSinceVersion2WithRaw)
                : std::span<const std::array<std::ptrdiff_t, 2>>(kSinceVersion2);
    const File old = as_version(2, newest, added);
    // Size and CRC of what the last writer of version 2 made of this calibration.
    EXPECT_EQ(old.size(), options ? 878U : 614U);
    EXPECT_EQ(get_u32(std::span<const std::byte>(old).last<4>()),
              options ? 0xF6268F00U : 0xCD653AC6U);
    const Result<dsp::Calibration> got = decode_calibration_file(old, space);
    ASSERT_TRUE(got);
    EXPECT_EQ(encoded(*got), newest);
    expect_short_ones_corrupt(old);
  }
}

TEST(CalibrationFile, IsDecodedAndEncodedToTheSameBytes) {
  const std::vector<std::int16_t> pattern = some_pattern();
  dsp::Calibration odd = newest_calibration(pattern);
  odd.stereo.doff_px = -0.0;
  odd.pmd.dark_lsb = std::numeric_limits<double>::denorm_min();
  odd.pmd.noise_lsb = std::bit_cast<double>(0x7FF8000000000123);  // a NaN keeps its bits
  const File file = encoded(odd);
  std::vector<std::int16_t> space(15);
  const Result<dsp::Calibration> decoded = decode_calibration_file(file, space);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(encoded(*decoded), file);
}

TEST(CalibrationFile, LivesWithoutFixedPattern) {
  const File file = encoded(some_calibration({}));
  EXPECT_EQ(file.size(), 796U);
  const Result<dsp::Calibration> decoded = decode_calibration_file(file, {});
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(decoded->pmd.fixed_pattern.empty());
}

// Numbers at the places that docs/WIRE.md names.
class Bytes {
 public:
  explicit Bytes(const File& file) : in_(file) {}
  double f64(std::size_t at) const {
    return std::bit_cast<double>(get_u64(in_.subspan(at).first<8>()));
  }
  int i32(std::size_t at) const { return get_i32(in_.subspan(at).first<4>()); }
  void expect_steps(std::size_t at, std::span<const std::int16_t> steps) const {
    for (std::size_t i = 0; i < steps.size(); ++i) {
      EXPECT_EQ(static_cast<std::int16_t>(get_u16(in_.subspan(at + 2 * i).first<2>())), steps[i]);
    }
  }
  void expect_numbers(std::size_t at, std::span<const double> numbers) const {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      EXPECT_EQ(f64(at + 8 * i), numbers[i]) << at + 8 * i;
    }
  }
  void expect_lens(std::size_t at, const dsp::Pinhole& lens) const {
    EXPECT_EQ(i32(at), lens.width);
    EXPECT_EQ(i32(at + 4), lens.height);
    expect_numbers(at + 8, std::array{lens.fx, lens.fy, lens.cx, lens.cy, lens.k1, lens.k2, lens.k3,
                                      lens.p1, lens.p2});
  }

 private:
  std::span<const std::byte> in_;
};

TEST(CalibrationFile, HasTheDocumentsOffsets) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const dsp::Calibration c = newest_calibration(pattern);
  const File file = encoded(c);
  const Bytes in(file);
  EXPECT_EQ(std::memcmp(file.data(), "STOFCAL", 8), 0);
  EXPECT_EQ(in.i32(8), 3);
  EXPECT_EQ(in.i32(12), static_cast<int>(file.size()));
  in.expect_lens(16, c.stereo.left);
  in.expect_numbers(96, std::array{c.stereo.baseline_m, c.stereo.doff_px});
  in.expect_lens(112, c.pmd.lens);
  const dsp::PmdSensor& pmd = c.pmd;
  EXPECT_EQ(in.i32(192), 18'750'000);
  EXPECT_EQ(in.i32(196), 1);
  EXPECT_EQ(in.i32(200), pmd.saturation_lsb);
  EXPECT_EQ(in.i32(204), pmd.under_lsb);
  EXPECT_EQ(in.i32(208), pmd.min_amplitude_lsb);
  in.expect_numbers(212, std::array{pmd.dark_lsb, pmd.frequency.min_modulation_ratio,
                                    pmd.asymmetry_sigmas, pmd.electrons_per_lsb, pmd.noise_lsb,
                                    pmd.suppressed_lsb, pmd.frequency.offset_m});
  in.expect_steps(268, pmd.frequency.wiggling);
  in.expect_numbers(524, std::array{pmd.frequency.offset_m_per_k, pmd.frequency.stray_i_lsb,
                                    pmd.frequency.stray_q_lsb, pmd.integration_us, pmd.reference_c,
                                    pmd.scale, pmd.shift_m, pmd.white_lsb});
  EXPECT_EQ(in.i32(588), 3);
  for (std::size_t i = 0; i < pmd.emitters.size(); ++i) {
    in.expect_numbers(592 + 24 * i, pmd.emitters[i]);
  }
  in.expect_numbers(688, c.pmd_to_stereo.rotation);
  in.expect_numbers(760, c.pmd_to_stereo.translation_m);
  EXPECT_EQ(in.i32(784), 0);
  EXPECT_EQ(in.i32(788), 15);
  in.expect_steps(792, pattern);
  EXPECT_EQ(file.size(), 796U + 30U);
}

TEST(CalibrationFile, HasTheDocumentsOffsetsOfOptions) {
  const dsp::Calibration c = newest_calibration({}, true);
  const File file = encoded(c);
  const Bytes in(file);
  EXPECT_EQ(in.i32(784), 15);
  in.expect_lens(788, c.stereo.raw->left);
  in.expect_lens(868, c.stereo.raw->right);
  in.expect_numbers(948, c.stereo.raw->left_to_right.rotation);
  in.expect_numbers(1020, c.stereo.raw->left_to_right.translation_m);
  in.expect_numbers(1044, std::array{0.25, -0.125, 8.5e-3, 8.25e-3, 5.6e-6, 311.25, 330.5});
  const dsp::PmdFrequency& second = *c.pmd.second;
  EXPECT_EQ(in.i32(1100), 17'500'000);
  in.expect_numbers(1104, std::array{second.min_modulation_ratio, second.offset_m});
  in.expect_steps(1120, second.wiggling);
  in.expect_numbers(1376,
                    std::array{second.offset_m_per_k, second.stray_i_lsb, second.stray_q_lsb});
  in.expect_numbers(1400, std::array{-0.25, 0.5, 0.125});
  EXPECT_EQ(in.i32(1424), 0);
  EXPECT_EQ(file.size(), 1432U);
}

TEST(CalibrationFile, EverySingleBitFlipAndTruncationIsCorrupt) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const File good = encoded(newest_calibration(pattern, true));
  std::vector<std::int16_t> space(15);
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    File bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    ASSERT_EQ(decode_calibration_file(bad, space).error(), Status::kCorrupt) << "bit " << bit;
  }
  for (std::size_t size = 0; size < good.size(); ++size) {
    test::GuardedBuffer<std::byte> cut(size);
    std::copy_n(good.begin(), size, cut.span().begin());
    ASSERT_EQ(decode_calibration_file(cut.span(), space).error(), Status::kCorrupt) << size;
  }
  File longer = good;
  longer.push_back(std::byte{0});
  EXPECT_EQ(decode_calibration_file(longer, space).error(), Status::kCorrupt);
}

TEST(CalibrationFile, AnotherVersionAndAnUnknownOptionAreUnsupported) {
  const File good = encoded(some_calibration({}));
  File file = good;
  for (const int version : {0, 4, 255}) {
    file[8] = static_cast<std::byte>(version);
    reseal(file);
    EXPECT_EQ(decode_calibration_file(file, {}).error(), Status::kUnsupported) << version;
  }
  file = good;
  for (const int options : {16, 31, 128}) {
    file[784] = static_cast<std::byte>(options);
    reseal(file);
    EXPECT_EQ(decode_calibration_file(file, {}).error(), Status::kUnsupported) << options;
  }
  for (const int options : {1, 2, 4, 8, 15}) {  // what they announce is not there
    file[784] = static_cast<std::byte>(options);
    reseal(file);
    EXPECT_EQ(decode_calibration_file(file, {}).error(), Status::kCorrupt) << options;
  }
  file = as_version(2, good, kSinceVersion2);
  for (const int options : {4, 8, 128}) {  // two of them came with version 3
    file[572] = static_cast<std::byte>(options);
    reseal(file);
    EXPECT_EQ(decode_calibration_file(file, {}).error(), Status::kUnsupported) << options;
  }
}

TEST(CalibrationFile, ATruthValueThatIsNeitherIsCorrupt) {
  constexpr std::size_t kFallsAt = 196;  // docs/WIRE.md
  dsp::Calibration falls = newest_calibration({});
  falls.pmd.phase_falls = true;
  File file = encoded(falls);
  ASSERT_EQ(file[kFallsAt], std::byte{1});
  file[kFallsAt] = std::byte{7};
  reseal(file);
  EXPECT_EQ(decode_calibration_file(file, {}).error(), Status::kCorrupt);
}

TEST(CalibrationFile, AShortFileWithARightCrcIsCorrupt) {
  expect_short_ones_corrupt(encoded(newest_calibration({}, true)));
}

TEST(CalibrationFile, AHostileNumberOfPixelsIsCorrupt) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const File good = encoded(some_calibration(pattern));
  std::vector<std::int16_t> space(15);
  for (const std::uint32_t count : {0U, 14U, 16U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFFU}) {
    File bad = good;
    put_u32(std::span(bad).subspan<788, 4>(), count);
    reseal(bad);
    EXPECT_EQ(decode_calibration_file(bad, space).error(), Status::kCorrupt) << count;
  }
}

TEST(CalibrationFile, SaysWhenTheSpaceIsTooSmall) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const dsp::Calibration calibration = some_calibration(pattern);
  std::vector<std::int16_t> space(14);
  EXPECT_EQ(decode_calibration_file(encoded(calibration), space).error(), Status::kTooLarge);
  std::vector<std::byte> out(calibration_file_bytes(calibration) - 1);
  EXPECT_EQ(encode_calibration_file(calibration, out).error(), Status::kTooLarge);
}

}  // namespace
}  // namespace stof::wire
