#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"

// Recorded scenes in files: the folder layout of stereo pairs (left.pgm, right.pgm, meta.txt,
// gt_left.pgm, nonocc.pgm) and of PMD frames (PREFIX.json, PREFIX_raw.pgm, <W>x<H>_fppn.pgm beside
// it). Used by the emulated cameras and by the command line; nothing here runs in the loop.
namespace stof::dataset {

// One line: what is wrong, in which file, what to do about it.
struct Problem {
  std::string message;
};
template <typename T>
using Loaded = std::expected<T, Problem>;

template <typename T>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<T> pixels;  // row by row

  Image() = default;
  Image(int w, int h, T fill = T{})
      : width(w),
        height(h),
        pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {}
  dsp::ImageView<const T> view() const { return {pixels.data(), width, height}; }
  dsp::ImageView<T> view() { return {pixels.data(), width, height}; }
};

// Binary PGM (P5), 8 bit (maxval <= 255) or 16 bit big-endian. Refused: other formats, truncated or
// oversized (more than 2^26 pixels) files, samples above maxval.
Loaded<Image<std::uint8_t>> read_pgm8(const std::filesystem::path& file);
Loaded<Image<std::uint16_t>> read_pgm16(const std::filesystem::path& file);

std::expected<void, Problem> write_pgm8(const std::filesystem::path& file,
                                        const Image<std::uint8_t>& image);
std::expected<void, Problem> write_pgm16(const std::filesystem::path& file,
                                         const Image<std::uint16_t>& image);

// PFM, "Pf", bottom row first, scale -1 (little-endian); +inf = none.
Loaded<Image<float>> read_pfm(const std::filesystem::path& file);
std::expected<void, Problem> write_pfm(const std::filesystem::path& file,
                                       const Image<float>& image);

// A stereo scene. left and right have equal size.
struct StereoScene {
  std::string name;  // the folder's name
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  int ndisp = 64;                              // search range to use, from meta.txt
  std::optional<Image<float>> truth;           // disparity in px of the left view, +inf = unknown
  std::optional<Image<std::uint8_t>> visible;  // not 0 = known and seen by both cameras
  // Parallel cameras, from meta.txt's f_px, baseline_m and doff_px (0 where absent); the principal
  // point is taken for the middle of the picture.
  std::optional<dsp::StereoRig> rig;
};

// Reads DIR. left.pgm, right.pgm and meta.txt must be there; gt_left.pgm and nonocc.pgm may be.
Loaded<StereoScene> read_stereo_scene(const std::filesystem::path& dir);

// Writes the files of a scene into a folder that exists; truth in steps of 1/256 px, up to 255 px.
std::expected<void, Problem> write_stereo_scene(const std::filesystem::path& dir,
                                                const StereoScene& scene);

// A PMD recording and the rig it belongs to.
struct PmdRecording {
  // One entry a frame, each four planes A0..A3 stacked from top to bottom (width x 4 height).
  std::vector<Image<std::uint16_t>> frames;
  // As many of calibration.pmd.second, or none.
  std::vector<Image<std::uint16_t>> second_frames;
  std::vector<std::int16_t> fixed_pattern;  // what calibration.pmd.fixed_pattern refers to
  // The camera's constants; `stereo` and `pmd_to_stereo` where the file has a rig.
  dsp::Calibration calibration;
  bool has_rig = false;

  using Samples = std::array<dsp::ImageView<const std::uint16_t>, 4>;
  Samples samples(std::size_t frame) const;
  Samples second_samples(std::size_t frame) const;

  PmdRecording() = default;
  PmdRecording(PmdRecording&&) = default;  // keeps fixed_pattern's storage
  PmdRecording& operator=(PmdRecording&&) = default;
  PmdRecording(const PmdRecording&) = delete;
  PmdRecording& operator=(const PmdRecording&) = delete;
};

// Reads PREFIX.json and PREFIX_raw.pgm. The wiggling table comes from kappa5 - kappa3 where the
// json has none. Truth (range maps, stray light) is never read. The fixed pattern is that of
// `fixed_pattern` where a file is named (then it must be there; 1/8 mm), else PREFIX_fppn.pgm,
// else <W>x<H>_fppn.pgm beside them, else there is none.
Loaded<PmdRecording> read_pmd(const std::filesystem::path& prefix,
                              const std::optional<std::filesystem::path>& fixed_pattern = {});

// Two recordings of one camera and one scene at two modulation frequencies: one recording with
// calibration.pmd.second. The higher frequency is the first one, in whichever order they are named.
// Where a json has no min_modulation_ratio it is 0.25 here.
Loaded<PmdRecording> read_pmd_pair(const std::filesystem::path& prefix,
                                   const std::filesystem::path& other,
                                   const std::optional<std::filesystem::path>& fixed_pattern = {});

// Writes PREFIX.json, PREFIX_raw.pgm and, where there is one, PREFIX_fppn.pgm into a folder that
// exists; what is read back is equal. The rig is written where has_rig says so, as the rectified
// pair that it is or becomes. write_pmd leaves a second frequency out, write_pmd_pair needs
// one and writes each under a prefix of its own.
std::expected<void, Problem> write_pmd(const std::filesystem::path& prefix,
                                       const PmdRecording& recording);
std::expected<void, Problem> write_pmd_pair(const std::filesystem::path& prefix,
                                            const std::filesystem::path& other,
                                            const PmdRecording& recording);

}  // namespace stof::dataset
