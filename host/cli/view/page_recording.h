#pragma once

#include <expected>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "host/cli/receive.h"
#include "host/recording/recorder.h"
#include "host/viewer/panel_messages.h"

namespace stof::host {

// The record button of the page: one recording after the other, each a file of its own in a folder.
// For the receiver's thread, which waits for no disk.
class PageRecording {
 public:
  // program: name and version, for the files.
  PageRecording(std::filesystem::path folder, std::string program);
  ~PageRecording();  // ends what is being recorded, and waits for it
  PageRecording(const PageRecording&) = delete;
  PageRecording& operator=(const PageRecording&) = delete;

  // Begins stof_20261126_203354.mcap, by the local time. receive: what is received, its sensor
  // where the settings are asked for. One line: why not.
  std::expected<void, std::string> begin(const ReceiveOptions& receive);
  // The file gets its end beside the receiver.
  void end();
  bool on() const noexcept { return open_ != nullptr; }

  // What comes meanwhile.
  void take(const client::Frame& frame, const std::string& place);
  void take(const client::ToldEvent& event);
  void look(client::Receiver& receiver);

  // Also ends it where the disk takes no more.
  viewer::RecordingState state();

 private:
  struct Open;
  void close();

  std::filesystem::path folder_;
  std::string program_;
  std::unique_ptr<Open> open_;
  std::future<recording::Recorder::Ended> ending_;
  viewer::RecordingState last_;
};

}  // namespace stof::host
