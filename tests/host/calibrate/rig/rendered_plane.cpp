#include "tests/host/calibrate/rig/rendered_plane.h"

#include <algorithm>
#include <cmath>

#include "dsp/calib/pmd/ray_table.h"

namespace stof::host::test {
namespace {

constexpr double kGrey = 100;

double lattice(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  const auto ux = static_cast<std::uint64_t>(x);
  const auto uy = static_cast<std::uint64_t>(y);
  return static_cast<double>(dsp::mix(dsp::mix(ux + seed) + 31 * uy) >> 40U) * 0x1p-24;
}

// Smooth noise of one size.
double noise_at(double x, double y, std::uint64_t seed) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto left = static_cast<std::int64_t>(fx);
  const auto top = static_cast<std::int64_t>(fy);
  const double a = x - fx;
  const double b = y - fy;
  return (1 - b) * ((1 - a) * lattice(left, top, seed) + a * lattice(left + 1, top, seed)) +
         b * ((1 - a) * lattice(left, top + 1, seed) + a * lattice(left + 1, top + 1, seed));
}

}  // namespace

Texture chessboard(const Board& board) {
  return [board](double x, double y) {
    const double column = x / board.square_m;
    const double row = y / board.square_m;
    const bool inside = column >= -1 && row >= -1 && column < board.columns && row < board.rows;
    if (!inside) {
      const bool white =
          column >= -2 && row >= -2 && column < board.columns + 1 && row < board.rows + 1;
      return white ? 210.0 : kGrey;
    }
    const auto parity = static_cast<int>(std::floor(column)) + static_cast<int>(std::floor(row));
    return parity % 2 == 0 ? 30.0 : 210.0;
  };
}

Texture blotches(std::uint64_t seed) {
  return [seed](double x, double y) {
    return 40 + 110 * noise_at(x / 0.006, y / 0.006, seed) +
           60 * noise_at(x / 0.02, y / 0.02, seed + 1);
  };
}

PlaneCamera::PlaneCamera(const dsp::Pinhole& lens) : lens_(lens) {
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      for (int j = 0; j < kSamples; ++j) {
        for (int i = 0; i < kSamples; ++i) {
          const std::array<double, 3> ray =
              dsp::unit_ray(lens, u + (i + 0.5) / kSamples - 0.5, v + (j + 0.5) / kSamples - 0.5);
          rays_.push_back(
              {static_cast<float>(ray[0] / ray[2]), static_cast<float>(ray[1] / ray[2])});
        }
      }
    }
  }
}

dataset::Image<std::uint8_t> PlaneCamera::picture(const PoseUnknowns& plane_to_camera,
                                                  const Texture& texture, double noise,
                                                  Gaussian& random, int smear_px) const {
  const Matrix3 turn = rotation_of(plane_to_camera);
  const Vector3 origin = translation_of(plane_to_camera);
  const Vector3 normal = turn.col(2);
  dataset::Image<float> sharp(lens_.width, lens_.height);
  auto ray = rays_.begin();
  for (float& pixel : sharp.pixels) {
    double sum = 0;
    for (int k = 0; k < kSamples * kSamples; ++k, ++ray) {
      const Vector3 direction(static_cast<double>((*ray)[0]), static_cast<double>((*ray)[1]), 1);
      const double z = normal.dot(origin) / normal.dot(direction);
      if (!(z > 0)) {
        sum += kGrey;
        continue;
      }
      const Vector3 on_plane = turn.transpose() * (z * direction - origin);
      sum += texture(on_plane.x(), on_plane.y());
    }
    pixel = static_cast<float>(sum / (kSamples * kSamples));
  }
  dataset::Image<std::uint8_t> made(lens_.width, lens_.height);
  for (int v = 0; v < lens_.height; ++v) {
    for (int u = 0; u < lens_.width; ++u) {
      double sum = 0;
      for (int k = 0; k <= smear_px; ++k) {
        sum += static_cast<double>(sharp.view().at(std::min(u + k, lens_.width - 1), v));
      }
      const double grey = sum / (1 + smear_px) + random.next(noise);
      made.view().at(u, v) = static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
    }
  }
  return made;
}

PoseUnknowns seen_from(const PoseUnknowns& first_to_second, const PoseUnknowns& plane_to_first) {
  const Matrix3 turn = rotation_of(first_to_second);
  return pose_of(Matrix3(turn * rotation_of(plane_to_first)),
                 Vector3(turn * translation_of(plane_to_first) + translation_of(first_to_second)));
}

}  // namespace stof::host::test
