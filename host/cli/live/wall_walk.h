#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace stof::host {

// Walls at known distances, one after the other: those that a folder holds are not asked for again.
class WallWalk {
 public:
  // distances: that are wanted, metres, in this order. folder: where walls are kept.
  WallWalk(std::vector<double> distances, std::filesystem::path folder)
      : distances_(std::move(distances)), folder_(std::move(folder)) {}

  // The folder holds a wall at this distance.
  void add(double z_m) { there_.insert(z_m); }
  // The first distance of which there is no wall; none: there is one of each.
  std::optional<double> next() const;
  // At how many distances walls are there in the end.
  std::size_t distances() const;
  // How many there are, for the line that ends it early.
  std::string kept_text() const;

 private:
  std::vector<double> distances_;
  std::filesystem::path folder_;
  std::set<double> there_;
};

// Until somebody presses Enter, because the wall stands where it was asked for. Throws Failure (1)
// where it is stopped or stdin ends, with walk.kept_text().
void wait_for_wall(const WallWalk& walk);

}  // namespace stof::host
