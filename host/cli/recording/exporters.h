#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/client/frame/frame.h"
#include "host/recording/recording.h"

namespace stof::host {

// Of a frame that is exported.
struct ExportStamp {
  std::uint64_t index = 0;     // its place among those that came, from 0
  std::uint64_t log_time = 0;  // when it arrived, ns since 1970
};

// Writes frames as files of one format into a folder that is there. Throws Failure where one cannot
// be written.
class Exporter {
 public:
  explicit Exporter(std::filesystem::path to) : to_(std::move(to)) {}
  virtual ~Exporter() = default;
  Exporter(const Exporter&) = delete;
  Exporter& operator=(const Exporter&) = delete;
  // False: the frame has nothing for this format.
  virtual bool add(const client::Frame& frame, const ExportStamp& stamp) = 0;
  virtual void finish(const recording::Sights& /*sights*/) {}
  // After a file could not be written: makes usable what is there, and returns how many frames that
  // is, of `exported`.
  virtual std::uint64_t rescue(std::uint64_t exported) { return exported; }

 protected:
  const std::filesystem::path& to() const { return to_; }

 private:
  std::filesystem::path to_;
};

std::vector<std::string> export_formats();  // csv, pcd, ply, png16, tum
// format: one of them.
std::unique_ptr<Exporter> make_exporter(const std::string& format, const std::filesystem::path& to);

}  // namespace stof::host
