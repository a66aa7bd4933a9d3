#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "host/client/frame/frame.h"
#include "host/lib/include/stof/stof.h"
#include "host/recording/mcap/storage.h"
#include "host/recording/recorder.h"
#include "host/recording/session_recording.h"

namespace stof::lib {

// What a sensor receives, on its way to a file. Locked by who uses it.
class Record {
 public:
  struct Options {
    bool replace = false;
    std::string sensor{};  // as the program named it, for the file
    bool is_signed = false;
    recording::ReadDocuments read{};  // none: nobody can be asked
  };
  static std::expected<std::unique_ptr<Record>, recording::Problem> start(
      const std::filesystem::path& file, Options options);

  void take(const client::Frame& frame, const std::string& place) { session_->take(frame, place); }
  void take(const client::ToldEvent& event) {
    if (session_->begun()) {
      session_->take(event);
    }
  }
  void look(client::Receiver& receiver) { session_->look(receiver); }
  stof_recorded state() const;
  // Blocks until all is written. Once.
  std::pair<stof_recorded, std::optional<recording::Problem>> finish();

 private:
  Record(std::filesystem::path file, mcap::FileSink&& sink)
      : file_(std::move(file)), sink_(std::move(sink)) {}

  std::filesystem::path file_;
  mcap::FileSink sink_;
  std::unique_ptr<recording::Recorder> recorder_;
  std::optional<recording::SessionRecording> session_;  // last: it uses the others
};

}  // namespace stof::lib
