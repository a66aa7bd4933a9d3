#include "firmware/wire/calibration_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::wire {
namespace {

using File = std::vector<std::byte>;

// Every field has another value, so that a swap shows.
dsp::Calibration some_calibration(std::span<const std::int16_t> pattern, bool options = false) {
  dsp::Calibration c;
  double next = 0.1;
  const auto fill = [&next](dsp::Pinhole& lens, int width, int height) {
    lens.width = width;
    lens.height = height;
    for (double* number : {&lens.fx, &lens.fy, &lens.cx, &lens.cy, &lens.k1, &lens.k2}) {
      *number = next *= -1.7;
    }
  };
  fill(c.stereo.left, 640, 480);
  c.stereo.baseline_m = 0.16;
  c.stereo.doff_px = -31.5;
  fill(c.pmd.lens, 5, 3);
  if (options) {
    dsp::RawPair& pair = c.stereo.raw.emplace();
    fill(pair.left, 641, 481);
    fill(pair.right, 642, 482);
    for (double& element : pair.left_to_right.rotation) {
      element = next *= 1.05;
    }
    for (double& element : pair.left_to_right.translation_m) {
      element = next *= -1.05;
    }
    c.stereo.converging = dsp::Converging{.alpha_rad = 0.25,
                                          .beta_rad = -0.125,
                                          .f1_m = 8.5e-3,
                                          .f2_m = 8.25e-3,
                                          .pixel_m = 5.6e-6,
                                          .cx_left = 311.25,
                                          .cx_right = 330.5};
  }
  c.pmd.tone.modulation = dsp::Hertz{18'750'000};
  c.pmd.phase_falls = true;
  c.pmd.dark_lsb = 101.5;
  c.pmd.saturation_lsb = 4000;
  c.pmd.under_lsb = -7;
  c.pmd.min_amplitude_lsb = 9;
  c.pmd.tone.min_modulation_ratio = 0.25;
  c.pmd.asymmetry_sigmas = 5.5;
  c.pmd.electrons_per_lsb = 61;
  c.pmd.noise_lsb = 4.75;
  c.pmd.suppressed_lsb = 12;
  c.pmd.tone.offset_m = -0.03125;
  test::Random random(1);
  random.fill(std::span<std::int16_t>(c.pmd.tone.wiggling));
  for (double& element : c.pmd_to_stereo.rotation) {
    element = next *= 1.1;
  }
  for (double& element : c.pmd_to_stereo.translation_m) {
    element = next *= -1.1;
  }
  c.pmd.fixed_pattern = pattern;
  return c;
}

std::vector<std::int16_t> some_pattern(std::size_t count = 15) {
  std::vector<std::int16_t> pattern(count);
  test::Random random(2);
  random.fill(std::span(pattern));
  return pattern;
}

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
}

TEST(CalibrationFile, GivesBackEveryField) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const dsp::Calibration want = some_calibration(pattern);
  std::vector<std::int16_t> space(20);
  const Result<dsp::Calibration> got = decode_calibration_file(encoded(want), space);
  ASSERT_TRUE(got);
  expect_equal(got->stereo.left, want.stereo.left);
  EXPECT_EQ(got->stereo.baseline_m, want.stereo.baseline_m);
  EXPECT_EQ(got->stereo.doff_px, want.stereo.doff_px);
  expect_equal(got->pmd.lens, want.pmd.lens);
  EXPECT_EQ(got->pmd.tone.modulation.value, want.pmd.tone.modulation.value);
  EXPECT_EQ(got->pmd.phase_falls, want.pmd.phase_falls);
  EXPECT_EQ(got->pmd.dark_lsb, want.pmd.dark_lsb);
  EXPECT_EQ(got->pmd.saturation_lsb, want.pmd.saturation_lsb);
  EXPECT_EQ(got->pmd.under_lsb, want.pmd.under_lsb);
  EXPECT_EQ(got->pmd.min_amplitude_lsb, want.pmd.min_amplitude_lsb);
  EXPECT_EQ(got->pmd.tone.min_modulation_ratio, want.pmd.tone.min_modulation_ratio);
  EXPECT_EQ(got->pmd.asymmetry_sigmas, want.pmd.asymmetry_sigmas);
  EXPECT_EQ(got->pmd.electrons_per_lsb, want.pmd.electrons_per_lsb);
  EXPECT_EQ(got->pmd.noise_lsb, want.pmd.noise_lsb);
  EXPECT_EQ(got->pmd.suppressed_lsb, want.pmd.suppressed_lsb);
  EXPECT_EQ(got->pmd.tone.offset_m, want.pmd.tone.offset_m);
  EXPECT_EQ(got->pmd.tone.wiggling, want.pmd.tone.wiggling);
  EXPECT_EQ(got->pmd_to_stereo.rotation, want.pmd_to_stereo.rotation);
  EXPECT_EQ(got->pmd_to_stereo.translation_m, want.pmd_to_stereo.translation_m);
  EXPECT_TRUE(std::ranges::equal(got->pmd.fixed_pattern, pattern));
  EXPECT_EQ(got->pmd.fixed_pattern.data(), space.data());
}

TEST(CalibrationFile, GivesBackWhatAPairHasBesideTheRectifiedCamera) {
  const dsp::Calibration want = some_calibration({}, true);
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
  for (const bool raw : {true, false}) {
    dsp::Calibration one = want;
    raw ? one.stereo.converging.reset() : one.stereo.raw.reset();
    const Result<dsp::Calibration> single = decode_calibration_file(encoded(one), {});
    ASSERT_TRUE(single);
    EXPECT_EQ(single->stereo.raw.has_value(), raw);
    EXPECT_EQ(single->stereo.converging.has_value(), !raw);
    EXPECT_EQ(encoded(*single), encoded(one));
  }
}

// A version 1 file: without the options, which stand at 572.
File as_version_1(File file) {
  file.erase(file.begin() + 572, file.begin() + 576);
  file[8] = std::byte{1};
  put_u32(std::span(file).subspan<12, 4>(), static_cast<std::uint32_t>(file.size()));
  reseal(file);
  return file;
}

TEST(CalibrationFile, ReadsVersion1AndWritesVersion2) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const File newest = encoded(some_calibration(pattern));
  std::vector<std::int16_t> space(15);
  const File old = as_version_1(newest);
  EXPECT_EQ(old.size(), 580U + 30U);
  const Result<dsp::Calibration> got = decode_calibration_file(old, space);
  ASSERT_TRUE(got);
  EXPECT_FALSE(got->stereo.raw);
  EXPECT_FALSE(got->stereo.converging);
  EXPECT_EQ(encoded(*got), newest);
  for (std::size_t size = 20; size < old.size(); ++size) {
    File cut(old.begin(), old.begin() + static_cast<std::ptrdiff_t>(size));
    put_u32(std::span(cut).subspan<12, 4>(), static_cast<std::uint32_t>(size));
    reseal(cut);
    ASSERT_EQ(decode_calibration_file(cut, space).error(), Status::kCorrupt) << size;
  }
}

TEST(CalibrationFile, IsDecodedAndEncodedToTheSameBytes) {
  const std::vector<std::int16_t> pattern = some_pattern();
  dsp::Calibration odd = some_calibration(pattern);
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
  EXPECT_EQ(file.size(), 584U);
  const Result<dsp::Calibration> decoded = decode_calibration_file(file, {});
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(decoded->pmd.fixed_pattern.empty());
}

TEST(CalibrationFile, HasTheDocumentsOffsets) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const dsp::Calibration c = some_calibration(pattern);
  const File file = encoded(c);
  const std::span<const std::byte> in(file);
  const auto f64 = [&in](std::size_t at) {
    return std::bit_cast<double>(get_u64(in.subspan(at).first<8>()));
  };
  const auto i32 = [&in](std::size_t at) { return get_i32(in.subspan(at).first<4>()); };
  EXPECT_EQ(std::memcmp(file.data(), "STOFCAL", 8), 0);
  EXPECT_EQ(get_u16(in.subspan<8, 2>()), 2);
  EXPECT_EQ(get_u32(in.subspan<12, 4>()), file.size());
  const auto expect_lens = [&](std::size_t at, const dsp::Pinhole& lens) {
    EXPECT_EQ(i32(at), lens.width);
    EXPECT_EQ(i32(at + 4), lens.height);
    const std::array<double, 6> numbers{lens.fx, lens.fy, lens.cx, lens.cy, lens.k1, lens.k2};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      EXPECT_EQ(f64(at + 8 + 8 * i), numbers[i]) << i;
    }
  };
  expect_lens(16, c.stereo.left);
  EXPECT_EQ(f64(72), c.stereo.baseline_m);
  EXPECT_EQ(f64(80), c.stereo.doff_px);
  expect_lens(88, c.pmd.lens);
  EXPECT_EQ(i32(144), 18'750'000);
  EXPECT_EQ(i32(148), 1);
  EXPECT_EQ(i32(152), c.pmd.saturation_lsb);
  EXPECT_EQ(i32(156), c.pmd.under_lsb);
  EXPECT_EQ(i32(160), c.pmd.min_amplitude_lsb);
  EXPECT_EQ(f64(164), c.pmd.dark_lsb);
  EXPECT_EQ(f64(172), c.pmd.tone.min_modulation_ratio);
  EXPECT_EQ(f64(180), c.pmd.asymmetry_sigmas);
  EXPECT_EQ(f64(188), c.pmd.electrons_per_lsb);
  EXPECT_EQ(f64(196), c.pmd.noise_lsb);
  EXPECT_EQ(f64(204), c.pmd.suppressed_lsb);
  EXPECT_EQ(f64(212), c.pmd.tone.offset_m);
  for (std::size_t i = 0; i < c.pmd.tone.wiggling.size(); ++i) {
    const std::uint16_t step = get_u16(in.subspan(220 + 2 * i).first<2>());
    EXPECT_EQ(static_cast<std::int16_t>(step), c.pmd.tone.wiggling[i]);
  }
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(f64(476 + 8 * i), c.pmd_to_stereo.rotation[i]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(f64(548 + 8 * i), c.pmd_to_stereo.translation_m[i]);
  }
  EXPECT_EQ(i32(572), 0);
  EXPECT_EQ(i32(576), 15);
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const std::uint16_t value = get_u16(in.subspan(580 + 2 * i).first<2>());
    EXPECT_EQ(static_cast<std::int16_t>(value), pattern[i]);
  }
  EXPECT_EQ(file.size(), 584U + 30U);
}

TEST(CalibrationFile, HasTheDocumentsOffsetsOfOptions) {
  const dsp::Calibration c = some_calibration({}, true);
  const File file = encoded(c);
  const std::span<const std::byte> in(file);
  const auto f64 = [&in](std::size_t at) {
    return std::bit_cast<double>(get_u64(in.subspan(at).first<8>()));
  };
  EXPECT_EQ(get_u32(in.subspan<572, 4>()), 3U);
  EXPECT_EQ(get_u32(in.subspan<576, 4>()), 641U);
  EXPECT_EQ(f64(576 + 8), c.stereo.raw->left.fx);
  EXPECT_EQ(get_u32(in.subspan<632, 4>()), 642U);
  EXPECT_EQ(f64(632 + 48), c.stereo.raw->right.k2);
  EXPECT_EQ(f64(688), c.stereo.raw->left_to_right.rotation[0]);
  EXPECT_EQ(f64(760), c.stereo.raw->left_to_right.translation_m[0]);
  EXPECT_EQ(f64(784), 0.25);
  EXPECT_EQ(f64(792), -0.125);
  EXPECT_EQ(f64(800), 8.5e-3);
  EXPECT_EQ(f64(808), 8.25e-3);
  EXPECT_EQ(f64(816), 5.6e-6);
  EXPECT_EQ(f64(824), 311.25);
  EXPECT_EQ(f64(832), 330.5);
  EXPECT_EQ(get_u32(in.subspan<840, 4>()), 0U);
  EXPECT_EQ(file.size(), 848U);
}

TEST(CalibrationFile, EverySingleBitFlipAndTruncationIsCorrupt) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const File good = encoded(some_calibration(pattern, true));
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
  File file = encoded(some_calibration({}));
  for (const int version : {0, 3, 255}) {
    file[8] = static_cast<std::byte>(version);
    reseal(file);
    EXPECT_EQ(decode_calibration_file(file, {}).error(), Status::kUnsupported) << version;
  }
  file[8] = std::byte{2};
  for (const int options : {4, 7, 128}) {
    file[572] = static_cast<std::byte>(options);
    reseal(file);
    EXPECT_EQ(decode_calibration_file(file, {}).error(), Status::kUnsupported) << options;
  }
  for (const int options : {1, 2, 3}) {  // what they announce is not there
    file[572] = static_cast<std::byte>(options);
    reseal(file);
    EXPECT_EQ(decode_calibration_file(file, {}).error(), Status::kCorrupt) << options;
  }
}

TEST(CalibrationFile, AShortFileWithARightCrcIsCorrupt) {
  const File whole = encoded(some_calibration({}, true));
  for (std::size_t size = 20; size < whole.size(); ++size) {
    test::GuardedBuffer<std::byte> cut(size);
    std::copy_n(whole.begin(), size, cut.span().begin());
    put_u32(cut.span().subspan<12, 4>(), static_cast<std::uint32_t>(size));
    put_u32(cut.span().last<4>(), crc32c(cut.span().first(size - 4)));
    ASSERT_EQ(decode_calibration_file(cut.span(), {}).error(), Status::kCorrupt) << size;
  }
}

TEST(CalibrationFile, AHostileNumberOfPixelsIsCorrupt) {
  const std::vector<std::int16_t> pattern = some_pattern();
  const File good = encoded(some_calibration(pattern));
  std::vector<std::int16_t> space(15);
  for (const std::uint32_t count : {0U, 14U, 16U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFFU}) {
    File bad = good;
    put_u32(std::span(bad).subspan<576, 4>(), count);
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
