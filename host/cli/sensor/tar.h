#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace stof::host {

// A tar file (POSIX ustar) in memory: regular files of mode 0644 of nobody in particular.
class Tar {
 public:
  // modified_s: of all its files, seconds since 1970.
  explicit Tar(std::int64_t modified_s) : modified_s_(modified_s) {}

  // name: up to 100 characters, with / between folders. bytes: below 8 GiB.
  void add(std::string_view name, std::string_view bytes);
  // With its end. Nothing is added behind it.
  std::string take();

 private:
  std::int64_t modified_s_;
  std::string bytes_;
};

}  // namespace stof::host
