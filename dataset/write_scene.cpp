#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "dataset/file.h"

namespace stof::dataset {
namespace {

constexpr int kTruthScale = 256;
constexpr float kMaxTruthPx = 255;

template <typename T>
std::string pgm_header(const Image<T>& image, int maxval) {
  return "P5\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n" +
         std::to_string(maxval) + "\n";
}

std::string pgm(const Image<std::uint8_t>& image) {
  std::string bytes = pgm_header(image, 255);
  for (const std::uint8_t value : image.pixels) {
    bytes.push_back(static_cast<char>(value));
  }
  return bytes;
}

// Big-endian, as PGM requires.
std::string pgm(const Image<std::uint16_t>& image) {
  std::string bytes = pgm_header(image, 65535);
  for (const std::uint16_t value : image.pixels) {
    bytes.push_back(static_cast<char>(value >> 8U));
    bytes.push_back(static_cast<char>(value & 0xFFU));
  }
  return bytes;
}

// 0 = unknown.
std::string truth_pgm(const Image<float>& truth) {
  Image<std::uint16_t> steps(truth.width, truth.height);
  std::ranges::transform(truth.pixels, steps.pixels.begin(), [](float d) {
    const long value = std::isfinite(d) && d > 0
                           ? std::max(std::lround(std::min(d, kMaxTruthPx) * kTruthScale), 1L)
                           : 0;
    return static_cast<std::uint16_t>(value);
  });
  return pgm(steps);
}

std::string meta(const StereoScene& scene) {
  std::string text = "scene " + scene.name + "\nndisp " + std::to_string(scene.ndisp) +
                     "\ngt_scale " + std::to_string(kTruthScale) + "\n";
  if (scene.rig) {
    std::array<char, 160> rig{};
    std::snprintf(rig.data(), rig.size(), "f_px %.17g\nbaseline_m %.17g\ndoff_px %.17g\n",
                  scene.rig->left.fx, scene.rig->baseline_m, scene.rig->doff_px);
    text += rig.data();
  }
  return text;
}

}  // namespace

std::expected<void, Problem> write_pgm8(const std::filesystem::path& file,
                                        const Image<std::uint8_t>& image) {
  return write_whole(file, pgm(image));
}

std::expected<void, Problem> write_pgm16(const std::filesystem::path& file,
                                         const Image<std::uint16_t>& image) {
  return write_whole(file, pgm(image));
}

std::expected<void, Problem> write_stereo_scene(const std::filesystem::path& dir,
                                                const StereoScene& scene) {
  std::vector<std::pair<const char*, std::string>> files{
      {"left.pgm", pgm(scene.left)}, {"right.pgm", pgm(scene.right)}, {"meta.txt", meta(scene)}};
  if (scene.truth) {
    files.emplace_back("gt_left.pgm", truth_pgm(*scene.truth));
  }
  if (scene.visible) {
    files.emplace_back("nonocc.pgm", pgm(*scene.visible));
  }
  for (const auto& [name, bytes] : files) {
    if (std::expected<void, Problem> written = write_whole(dir / name, bytes); !written) {
      return written;
    }
  }
  return {};
}

}  // namespace stof::dataset
