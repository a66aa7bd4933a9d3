#include "host/cli/recording/sensor_documents.h"

#include "host/cli/failure.h"
#include "host/cli/sensor/find_sensor.h"

namespace stof::host {

recording::SensorDocuments read_documents(const ReceiveOptions& options, bool calibration) {
  if (options.sensor.empty()) {
    constexpr const char* kNotAsked = "the sensor was not asked: it sends here by itself";
    return {.no_settings = kNotAsked, .no_calibration = kNotAsked};
  }
  try {
    auto asked =
        client::ControlClient::open(sensor_address(options.sensor), reading_control(options));
    if (!asked) {
      return {.no_settings = asked.error().message, .no_calibration = asked.error().message};
    }
    return recording::read_documents(*asked, calibration);
  } catch (const Failure& failure) {  // the keys have gone meanwhile
    return {.no_settings = failure.what(), .no_calibration = failure.what()};
  }
}

std::string name_for_file(const ReceiveOptions& options) {
  return options.sensor.empty() ? "sends here" : options.sensor;
}

recording::ReadDocuments documents_reader(const ReceiveOptions& options) {
  if (options.sensor.empty()) {
    return {};
  }
  return [options](bool calibration) { return read_documents(options, calibration); };
}

}  // namespace stof::host
