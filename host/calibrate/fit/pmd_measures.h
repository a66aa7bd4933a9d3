#pragma once

#include <optional>

#include "host/calibrate/fit/pmd_fit.h"

// Measures of walls, or of walls and a fitted model, without fitting constants.
namespace stof::host {

// Takes out the walls without a usable pixel, and says how many they were.
std::size_t drop_blind(std::vector<Wall>& walls, const dsp::PmdSensor& camera);

std::size_t count_distances(const std::vector<Wall>& walls);

// Amplitude of a white surface at 1 m, LSB: albedo white exposure / z^2 near the optical axis, of
// walls from 1 m on. 0 where no wall tells.
double white_amplitude(const WallData& data, const PmdModel& model, double albedo);

// Eq. 15 for the spread of one reading in the middle of each wall of the longest integration time:
// what I and Q vary over the signal.
std::optional<dsp::SigmaPolynomial> measured_sigma(const WallData& data, const PmdModel& model);

// The longest way, in turns, between neighbouring phases that the walls show: what lies there is
// interpolated.
double widest_gap(const WallData& data, const PmdModel& model);

}  // namespace stof::host
