#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "host/client/control/control_client.h"

namespace stof::recording {

// What a recording holds of a sensor beside what it sends: settings, and its calibration file.
struct SensorDocuments {
  std::string settings{};        // the document `active`; empty: see the next
  std::string no_settings{};     // why
  std::string calibration{};     // the file; empty: not asked for, or see the next
  std::string no_calibration{};  // why
};

// By which frames name settings.
std::uint32_t fingerprint_of(const std::string& document);

// Blocks for as long as the answers take, a few seconds where there are none.
SensorDocuments read_documents(client::ControlClient& sensor, bool calibration);
// The same of whoever is recorded, from any thread; the calibration's file, too, where it is true.
using ReadDocuments = std::function<SensorDocuments(bool calibration)>;

// Reads them again, beside whoever receives, each time a frame was made with others, and keeps the
// settings that were read. For one thread.
class DocumentWatch {
 public:
  // read: none: nobody can be asked. calibration: its file is read, too.
  DocumentWatch(ReadDocuments read, bool calibration)
      : read_(std::move(read)), calibration_(calibration) {}

  // What there is already.
  void know(const SensorDocuments& documents);
  // A frame was made with these; 0: not told.
  void note(std::uint32_t settings, std::uint32_t calibration);
  // What came since the last call and is not known yet, with empty texts for the rest; no_settings
  // says why those of wanted() did not come. wait: until what is being read has come.
  std::optional<SensorDocuments> take(bool wait = false);

  // Another start of the sensor may tell what an earlier one did not.
  void forget_unread() {
    std::erase_if(known_settings_, [](const auto& one) { return one.second.empty(); });
  }

  // The document that frames name so; empty: it was not read.
  std::string settings(std::uint32_t fingerprint) const;
  bool knows_calibration(std::uint32_t fingerprint) const {
    return known_calibrations_.contains(fingerprint);
  }
  // Settings that were asked for last.
  std::uint32_t wanted() const noexcept { return wanted_settings_; }

 private:
  static constexpr std::size_t kMostSettings = 64;  // then all are forgotten, and asked for again

  void keep_settings(std::uint32_t fingerprint, std::string document);

  ReadDocuments read_;
  bool calibration_;
  std::map<std::uint32_t, std::string> known_settings_;  // empty: nobody has them any more
  std::set<std::uint32_t> known_calibrations_;
  std::uint32_t wanted_settings_ = 0;
  std::uint32_t wanted_calibration_ = 0;
  int tries_ = 0;  // for these, without an answer
  std::future<SensorDocuments> reading_;
};

}  // namespace stof::recording
