#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "dsp/calib/calibration.h"
#include "hal/emu/scenes/vec3.h"

namespace stof::hal::emu {

// A grey sensor: level = black + gain * radiance, noise variance = read_noise^2 + level above black
// / electrons_per_level, rounded and clipped to 0..255.
struct GreyModel {
  double gain = 280;
  double black = 4;
  double electrons_per_level = 40;
  double read_noise = 0.7;  // levels
};

// What the lenses of the pair do to a picture beside bending it.
struct LensQuality {
  double blur_px = 0;     // standard deviation of their Gaussian point spread
  double vignetting = 0;  // the share of light that the corners lack; it grows with r^2. 0..1
};

// A PMD sensor and its light. A sample collects, with signal s, correlation D_k at reference phase
// k 90 degrees and ambient light B:
//   N_k = s + D_k + (1 - suppression) B + residual,  variance s + D_k + B + read_noise^2
//   [electrons] A_k = clip(round(N_k / electrons_per_lsb + dark), 0, 2^bits - 1) D_k = s contrast
//   sum over h = 1, 3, 5 of kappa_h cos(h (phase + k 90 degrees)), kappa_1 = 1 s   = signal albedo
//   cos^m(emission angle) cos(incidence) cos^4(field angle) / r_emitter^2
// summed over rays_per_side^2 rays a pixel, which is what mixes surfaces at edges.
// One number for each of them: nothing here belongs to a part of its own.
struct PmdModel {
  double signal_e = 400'000;  // a white surface at 1 m, a sample
  double contrast = 0.45;
  double kappa3 = 0.0497;  // square drive through a low-pass at the modulation frequency
  double kappa5 = 0.0111;
  double ambient_e = 15'000;  // from a white surface
  double suppression = 0.95;
  double residual_e = 500;
  double read_noise_e = 150;
  double electrons_per_lsb = 61;
  double dark_lsb = 100;
  int bits = 12;  // 10 .. 15
  // Light that never leaves the camera: amplitude of its correlation in electrons, and how far away
  // it seems. Without harmonics, the same in every pixel.
  double stray_e = 0;
  double stray_m = 0;
  int beam_half_powers = 4;                                 // 2 m: the beam is cos^m
  std::vector<Vec3> emitters{{-0.03, 0, 0}, {0.03, 0, 0}};  // in the PMD frame
  int rays_per_side = 4;
  bool scattered_rays = false;   // each pixel's in places of its own; else a grid, alike in all
  double blur_px = 0;            // standard deviation of the lens's Gaussian point spread
  double pattern_rms_m = 0.003;  // distance offset of each pixel, known to the calibration
};

// How the PMD camera moved after the rig was calibrated: the emulated world has it, the
// calibration that is published does not. The camera is turned about its own lens,
//   X_left = Ry(yaw) Rx(pitch) Rz(roll) R X_pmd + T
// with right-handed turns about the axes of the left camera: with a positive pitch it looks further
// up, with a positive yaw further to the right, with a positive roll it is turned clockwise.
struct Misplacement {
  double yaw_degrees = 0;
  double pitch_degrees = 0;
  double roll_degrees = 0;
  double range_offset_m = 0;  // what it measures too much, along the ray
};

// What a rig says of its geometry.
struct PublishedGeometry {
  dsp::StereoRig stereo;
  dsp::Pinhole pmd_lens;
  dsp::RigidTransform pmd_to_stereo;
};

// The geometry and the sensors of an emulated rig.
struct Rig {
  dsp::StereoRig stereo;  // complete(): its pair may be raw, or converge
  int disparities = 64;   // search range that holds the scene it was made for
  dsp::Pinhole pmd_lens;  // 0x0: no PMD camera
  dsp::Hertz modulation{20'000'000};
  dsp::RigidTransform pmd_to_stereo;
  Pose left_camera_pose;  // in the world, of the axes that StereoRig describes
  GreyModel grey;
  LensQuality lenses{};
  PmdModel pmd;
  std::uint32_t seed = 1;  // of all noise
  Misplacement misplacement{};
  // None: the truth but for `misplacement`.
  std::optional<PublishedGeometry> published = std::nullopt;
};

// One of the two cameras as it is: its lens, and its pose in the axes of Rig::stereo.
struct Eye {
  dsp::Pinhole lens;
  Pose pose{};
};
Eye left_eye(const Rig& rig) noexcept;
Eye right_eye(const Rig& rig) noexcept;

// The pose of the PMD camera in the axes of the left one as it really is.
Pose true_pmd_pose(const Rig& rig) noexcept;

// Cameras with more or fewer pixels that see as wide a field; pixels stay square, so that another
// shape of the picture changes the height of the field. The range of disparities grows along.
void resize_stereo(Rig& rig, int width, int height) noexcept;
void resize_pmd(Rig& rig, int width, int height) noexcept;

// 640x480, 55 degrees wide (615 px), 0.12 m baseline: Z = 73.8 m px / d, so that 64 disparities
// reach from 1.17 m on. A 176x144, 20 MHz PMD camera of 58 degrees sits between and above the two,
// turned by a degree. The left camera is 1 m above the floor and looks 3 degrees down and to the
// left.
Rig corridor_rig();

// The book chapter's rig: 640x480, 8.5 mm lenses and pixels of 5.6 um (1518 px, 24 degrees wide), a
// 0.20 m baseline, axes that meet at 4 m and are matched as they are: rows correspond in the middle
// alone. 128 disparities reach from 1.5 m to 4 m. Its PMD camera has 64x16 pixels over 70.5
// degrees, and stands between and above the two. It looks along z from the origin.
Rig chapter_rig();

// 640x480 as corridor_rig(), with a 0.25 m baseline: Z = 153.8 m px / d, so that 14 m and 14 m less
// one turn (7.49 m) are 12 px apart; 96 disparities reach from 1.6 m on. The 176x144 PMD camera
// measures at 20 MHz alone, with so strong a light and 15 bits that its modulation ratio is above
// 30 percent on everything that hall() has within its range, and white at 2 m does not saturate it.
// The left camera is 1.5 m above the floor and looks 2 degrees down.
Rig hall_rig();

}  // namespace stof::hal::emu
