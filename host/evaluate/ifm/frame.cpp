#include "host/evaluate/ifm/frame.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "dsp/base/fixed.h"
#include "dsp/calib/pmd/ray_table.h"
#include "host/evaluate/ifm/frame_file.h"
#include "host/evaluate/pmd/rank_correlation.h"
#include "host/evaluate/stereo/median.h"

namespace stof::host {
namespace {

constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();

FrameCloud empty_cloud(const dsp::Pinhole& lens) {
  const dataset::Image<float> nothing(lens.width, lens.height, kNoValue);
  return {nothing, nothing, nothing};
}

// As the appliance does it: quarter mm, Q15 rays, X = (d r_x + 2^14) >> 15.
FrameCloud fixed_point_cloud(const CameraFrame& frame) {
  const dsp::Pinhole& lens = frame.info.lens;
  const std::size_t n = frame.radial.pixels.size();
  std::vector<std::int16_t> x(n), y(n), z(n), forward(n);
  dsp::fill_ray_table(lens, dsp::RigidTransform{}.rotation, {x, y, z, forward});
  FrameCloud cloud = empty_cloud(lens);
  for (std::size_t i = 0; i < n; ++i) {
    if (!frame.valid(i) || forward[i] == 0) {
      continue;
    }
    const double exact = frame.radial.pixels[i] * frame.info.unit_m * dsp::kQuarterMmPerMetre;
    const int d = static_cast<int>(std::lround(std::min<double>(exact, dsp::kMaxQuarterMm)));
    const auto metres = [d](std::int16_t ray) {
      return static_cast<float>(dsp::round_shift(d * ray, dsp::kQ15Bits)) / dsp::kQuarterMmPerMetre;
    };
    cloud.x.pixels[i] = metres(x[i]);
    cloud.y.pixels[i] = metres(y[i]);
    cloud.z.pixels[i] = metres(z[i]);
  }
  return cloud;
}

// By rays that a function gives for every pixel, in double precision.
template <typename Ray>
FrameCloud exact_cloud(const CameraFrame& frame, const Ray& ray) {
  const dsp::Pinhole& lens = frame.info.lens;
  FrameCloud cloud = empty_cloud(lens);
  for (std::size_t i = 0; i < frame.radial.pixels.size(); ++i) {
    const int p = static_cast<int>(i);
    const std::array<double, 3> r = ray(p % lens.width, p / lens.width);
    if (frame.valid(i) && r[2] > 0) {
      const double d = frame.radial.pixels[i] * frame.info.unit_m;
      cloud.x.pixels[i] = static_cast<float>(d * r[0]);
      cloud.y.pixels[i] = static_cast<float>(d * r[1]);
      cloud.z.pixels[i] = static_cast<float>(d * r[2]);
    }
  }
  return cloud;
}

CloudDifference difference(const FrameCloud& a, const FrameCloud& b) {
  CloudDifference out;
  std::vector<double> lengths;
  for (std::size_t i = 0; i < a.z.pixels.size(); ++i) {
    const double dx = a.x.pixels[i] - b.x.pixels[i];
    const double dy = a.y.pixels[i] - b.y.pixels[i];
    const double dz = a.z.pixels[i] - b.z.pixels[i];
    if (const double length = std::hypot(dx, dy, dz); std::isfinite(length)) {
      lengths.push_back(length);
      out.largest_m = std::max(out.largest_m, length);
    }
  }
  out.pixels = static_cast<long>(lengths.size());
  out.median_m = median(std::move(lengths)).value_or(0);
  return out;
}

// Chunks 200 to 202: millimetres in 16 bits, metres as floats.
std::optional<FrameCloud> camera_cloud(const CameraFrame& frame) {
  constexpr std::uint32_t kI16 = 3;
  constexpr std::uint32_t kFloat = 6;
  constexpr float kMillimetre = 1e-3F;
  const dsp::Pinhole& lens = frame.info.lens;
  FrameCloud cloud = empty_cloud(lens);
  std::uint32_t type = kPcicX;
  for (dataset::Image<float>* image : {&cloud.x, &cloud.y, &cloud.z}) {
    const PcicChunk* const chunk = frame.chunk(type++);
    const std::size_t each = chunk != nullptr && chunk->format == kFloat ? 4 : 2;
    if (chunk == nullptr || (chunk->format != kI16 && chunk->format != kFloat) ||
        chunk->width != lens.width || chunk->height != lens.height ||
        chunk->size - chunk->header_size < each * image->pixels.size()) {
      return std::nullopt;
    }
    for (std::size_t i = 0; i < image->pixels.size(); ++i) {
      const std::uint32_t word = frame.word(*chunk, i, each);
      if (frame.valid(i)) {
        image->pixels[i] = each == 4 ? std::bit_cast<float>(word)
                                     : kMillimetre * static_cast<float>(static_cast<std::int16_t>(
                                                         static_cast<std::uint16_t>(word)));
      }
    }
  }
  return cloud;
}

// The camera's own polynomial from a pixel to its direction (chunk 420): the form of Pinhole, read
// the other way round.
std::optional<dsp::Pinhole> way_back(const CameraFrame& frame) {
  constexpr std::size_t kModel = 45;  // words before the inverse model's number
  constexpr std::size_t kWords = 57;
  const PcicChunk* const chunk = frame.chunk(kPcicTofInfo);
  if (chunk == nullptr || chunk->size - chunk->header_size < 4 * kWords) {
    return std::nullopt;
  }
  const auto real = [&frame, chunk](std::size_t n) {
    return static_cast<double>(std::bit_cast<float>(frame.word(*chunk, kModel + n, 4)));
  };
  const dsp::Pinhole lens{.width = frame.info.lens.width,
                          .height = frame.info.lens.height,
                          .fx = real(1),
                          .fy = real(2),
                          .cx = real(3),
                          .cy = real(4),
                          .k1 = real(6),
                          .k2 = real(7),
                          .k3 = real(10),
                          .p1 = real(8),
                          .p2 = real(9)};
  return lens.fx > 0 && lens.fy > 0 ? std::optional(lens) : std::nullopt;
}

std::array<double, 3> back_ray(const dsp::Pinhole& lens, int u, int v) {
  const double xd = (u - lens.cx) / lens.fx;
  const double yd = (v - lens.cy) / lens.fy;
  const double r2 = xd * xd + yd * yd;
  const double s = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double x = xd * s + 2 * lens.p1 * xd * yd + lens.p2 * (r2 + 2 * xd * xd);
  const double y = yd * s + lens.p1 * (r2 + 2 * yd * yd) + 2 * lens.p2 * xd * yd;
  const double length = std::sqrt(x * x + y * y + 1);
  return {x / length, y / length, 1 / length};
}

// Whether chunk 100 holds what radial_distance.pgm does.
bool same_distances(const CameraFrame& frame) {
  const PcicChunk* const chunk = frame.chunk(kPcicRadial);
  const std::size_t n = frame.radial.pixels.size();
  if (chunk == nullptr || chunk->size - chunk->header_size < 2 * n) {
    return frame.buffer.empty();
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (frame.word(*chunk, i, 2) != frame.radial.pixels[i]) {
      return false;
    }
  }
  return true;
}

// Shot and fixed noise, sigma ~ sqrt(light) / A: with nothing but an amplitude known, what
// falls with the amplitude of the exposure that a pixel was taken from.
void judge_noise(const CameraFrame& frame, FrameStudy& study) {
  study.rank_correlation = study.rank_correlation_as_given = std::nan("");
  study.median_noise_m = std::nan("");
  if (!frame.amplitude || !frame.noise) {
    return;
  }
  const std::vector<double> factors = frame.amplitude_factors();
  std::vector<double> given;
  std::vector<double> exposed;
  std::vector<double> noise;
  for (std::size_t i = 0; i < frame.radial.pixels.size(); ++i) {
    if (frame.valid(i) && frame.amplitude->pixels[i] > 0 && frame.noise->pixels[i] > 0) {
      given.push_back(1.0 / frame.amplitude->pixels[i]);
      exposed.push_back(given.back() * (factors.empty() ? 1 : factors[i]));
      noise.push_back(frame.noise->pixels[i] * frame.info.unit_m);
    }
  }
  study.knows_exposures = !factors.empty();
  study.rank_correlation = rank_correlation(exposed, noise);
  study.rank_correlation_as_given = rank_correlation(given, noise);
  study.median_noise_m = median(std::move(noise)).value_or(std::nan(""));
}

}  // namespace

dataset::Loaded<FrameStudy> study_frame(const std::filesystem::path& folder) {
  const dataset::Loaded<CameraFrame> frame = read_camera_frame(folder);
  if (!frame) {
    return std::unexpected(frame.error());
  }
  const dsp::Pinhole& lens = frame->info.lens;
  FrameStudy study{.folder = folder,
                   .width = lens.width,
                   .height = lens.height,
                   .buffer = !frame->buffer.empty(),
                   .same_distances = same_distances(*frame),
                   .camera = std::nullopt,
                   .exact = {},
                   .way_back = std::nullopt,
                   .cloud = fixed_point_cloud(*frame),
                   .amplitude = dataset::Image<float>(lens.width, lens.height)};
  for (std::size_t i = 0; i < frame->radial.pixels.size(); ++i) {
    study.valid += frame->valid(i) ? 1 : 0;
    if (frame->amplitude) {
      study.amplitude.pixels[i] = static_cast<float>(frame->amplitude->pixels[i]);
    }
  }
  study.exact = difference(
      study.cloud, exact_cloud(*frame, [&lens](int u, int v) { return unit_ray(lens, u, v); }));
  if (const std::optional<FrameCloud> camera = camera_cloud(*frame)) {
    study.has_cartesian = true;
    study.camera = difference(study.cloud, *camera);
  }
  if (const std::optional<dsp::Pinhole> back = way_back(*frame)) {
    study.way_back = difference(
        study.cloud, exact_cloud(*frame, [&back](int u, int v) { return back_ray(*back, u, v); }));
  }
  judge_noise(*frame, study);
  return study;
}

}  // namespace stof::host
