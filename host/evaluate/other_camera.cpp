#include "host/evaluate/other_camera.h"

#include <cmath>

#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kTolerance = 1e-3;  // of one camera's numbers
constexpr double kHertzPerMegahertz = 1e6;

bool differ(double a, double b) { return std::abs(a - b) > kTolerance * b; }

std::string text(const char* what, double recorded, double calibrated, const char* unit) {
  return printed("the recording's %s is %g%s, the calibration's %g%s", what, recorded, unit,
                 calibrated, unit);
}

}  // namespace

std::string other_camera(const dsp::PmdSensor& calibrated, const dsp::PmdSensor& recorded) {
  const double modulation = recorded.frequency.modulation.value;
  if (const double known = calibrated.frequency.modulation.value; differ(known, modulation)) {
    return text("modulation frequency", modulation / kHertzPerMegahertz, known / kHertzPerMegahertz,
                " MHz");
  }
  if (calibrated.saturation_lsb != recorded.saturation_lsb) {
    return text("saturation", recorded.saturation_lsb, calibrated.saturation_lsb, " LSB");
  }
  if (calibrated.integration_us > 0 && recorded.integration_us > 0 &&
      differ(calibrated.integration_us, recorded.integration_us)) {
    return text("integration time", recorded.integration_us, calibrated.integration_us, " us");
  }
  return {};
}

}  // namespace stof::host
