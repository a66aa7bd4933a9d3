#include "tests/host/calibrate/rig/rendered_plane.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "dsp/calib/pmd/ray_table.h"
#include "host/calibrate/rig/target/target_sheet.h"

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

Texture print_of(const Board& board, bool turned) {
  const std::optional<BoardPicture> made = picture_of(board);
  if (!made) {
    return {};
  }
  const double pixel_m = made->pixel_mm / 1000;
  const bool tags = board.kind == Board::Kind::kAprilGrid;
  const double before = board.square_m * (1 + (tags ? board.share : 1));  // of the first corner
  return [=, picture = made->picture](double x, double y) {
    const double step = board.square_m * (1 + board.share);
    if (turned) {
      const double in_x = x - std::floor(x / step) * step;
      const double in_y = y - std::floor(y / step) * step;
      if (in_x < board.square_m && in_y < board.square_m) {
        x += board.square_m - 2 * in_x;
        y += board.square_m - 2 * in_y;
      }
    }
    const int u = static_cast<int>(std::floor((x + before) / pixel_m));
    const int v = static_cast<int>(std::floor((y + before) / pixel_m));
    const bool on = u >= 0 && v >= 0 && u < picture.width && v < picture.height;
    return on ? 30 + picture.view().at(u, v) * 180.0 / 255 : 100.0;
  };
}

Texture blotches(std::uint64_t seed) {
  return [seed](double x, double y) {
    return 40 + 110 * noise_at(x / 0.006, y / 0.006, seed) +
           60 * noise_at(x / 0.02, y / 0.02, seed + 1);
  };
}

PlaneCamera::PlaneCamera(const dsp::Pinhole& lens, int samples) : lens_(lens), samples_(samples) {
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      for (int j = 0; j < samples; ++j) {
        for (int i = 0; i < samples; ++i) {
          const std::array<double, 3> ray =
              dsp::unit_ray(lens, u + (i + 0.5) / samples - 0.5, v + (j + 0.5) / samples - 0.5);
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
    for (int k = 0; k < samples_ * samples_; ++k, ++ray) {
      const Vector3 direction(static_cast<double>((*ray)[0]), static_cast<double>((*ray)[1]), 1);
      const double z = normal.dot(origin) / normal.dot(direction);
      if (!(z > 0)) {
        sum += kGrey;
        continue;
      }
      const Vector3 on_plane = turn.transpose() * (z * direction - origin);
      sum += texture(on_plane.x(), on_plane.y());
    }
    pixel = static_cast<float>(sum / (samples_ * samples_));
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
