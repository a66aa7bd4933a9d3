#pragma once

#include <cstdint>

#include "dataset/dataset.h"
#include "hal/emu/scenes/rig.h"

// What a lens does to a sharp picture.
namespace stof::hal::emu {

// exp(-x^2 / (2 sigma^2)) to 1e-11 of itself, the same bits on every machine.
double bell(double x, double sigma) noexcept;

// The light that a pixel collects from a place x pixels beside its centre, when a Gaussian spreads
// it: the pixel's width convolved with the Gaussian, not normalised.
double blurred_pixel(double x, double sigma) noexcept;

// How far a blur reaches, in pixels; 0 where there is none.
int reach_of(double blur_px) noexcept;

// Blurs a noise-free picture of kGreyBits fraction bits, then darkens it towards the corners. The
// Gaussian is sampled at pixel centres, out to 4 standard deviations, and has that variance;
// borders replicate. Without blur and vignetting not a bit changes.
void soften(const LensQuality& lens, double black, dataset::Image<std::uint16_t>& picture);

}  // namespace stof::hal::emu
