#include "host/calibrate/rig/target/pair_folder.h"

#include <algorithm>

#include "dataset/files/file.h"

namespace stof::host {

dataset::Loaded<std::vector<std::filesystem::path>> list_pairs(const std::filesystem::path& dir) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (std::filesystem::directory_iterator at(dir, error), end; !error && at != end;
       at.increment(error)) {
    const bool left = dataset::is_there(at->path() / "left.pgm");
    const bool right = dataset::is_there(at->path() / "right.pgm");
    if (left != right) {
      return dataset::refuse(at->path(), left ? "has no right.pgm" : "has no left.pgm",
                             "add it, or remove the folder");
    }
    if (left) {
      found.push_back(at->path());
    }
  }
  if (found.empty()) {
    return dataset::refuse(dir, "holds no folder with left.pgm and right.pgm",
                           "give one with a folder for each view");
  }
  std::ranges::sort(found);
  return found;
}

dataset::Loaded<Pair> read_pair(const std::filesystem::path& dir) {
  dataset::Loaded<dataset::Image<std::uint8_t>> left = dataset::read_pgm8(dir / "left.pgm");
  if (!left) {
    return std::unexpected(std::move(left.error()));
  }
  dataset::Loaded<dataset::Image<std::uint8_t>> right = dataset::read_pgm8(dir / "right.pgm");
  if (!right) {
    return std::unexpected(std::move(right.error()));
  }
  if (left->width != right->width || left->height != right->height) {
    return dataset::refuse(dir / "right.pgm",
                           "is " + dataset::size_text(right->width, right->height) +
                               " but left.pgm is " + dataset::size_text(left->width, left->height),
                           "use cameras of one size");
  }
  return Pair{dir.filename().string(), std::move(*left), std::move(*right)};
}

}  // namespace stof::host
