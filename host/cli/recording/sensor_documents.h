#pragma once

#include <string>

#include "host/cli/receive.h"
#include "host/recording/sensor_documents.h"

namespace stof::host {

// Of the sensor that is received, over a way of its own; blocks for as long as its answers take, a
// few seconds where it gives none.
recording::SensorDocuments read_documents(const ReceiveOptions& options, bool calibration);
// The same for whoever records it. None: it sends here by itself, and cannot be asked.
recording::ReadDocuments documents_reader(const ReceiveOptions& options);
// What a recording calls the sensor.
std::string name_for_file(const ReceiveOptions& options);

}  // namespace stof::host
