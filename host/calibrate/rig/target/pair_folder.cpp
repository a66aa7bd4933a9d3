#include "host/calibrate/rig/target/pair_folder.h"

#include <algorithm>
#include <optional>
#include <string>

#include "dataset/files/file.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// What no pair can be read from.
std::optional<dataset::Problem> no_folder(const std::filesystem::path& dir) {
  constexpr const char* kRemedy = "give a folder with a folder for each view";
  if (!dataset::is_there(dir)) {
    return dataset::refuse(dir, "does not exist", kRemedy).error();
  }
  std::error_code error;
  if (!std::filesystem::is_directory(dir, error)) {
    return dataset::refuse(dir, "is no folder", kRemedy).error();
  }
  return std::nullopt;
}

// Folders with one picture alone: the first, and how many.
dataset::Problem halves(std::vector<std::filesystem::path> found) {
  std::ranges::sort(found);
  const std::filesystem::path& first = found.front();
  std::string what = dataset::is_there(first / "left.pgm") ? "has no right.pgm" : "has no left.pgm";
  if (found.size() > 1) {
    what += printed(", as %zu more miss one of both", found.size() - 1);
  }
  return dataset::refuse(first, what, "add it, or remove the folder").error();
}

}  // namespace

dataset::Loaded<std::vector<std::filesystem::path>> pairs_so_far(const std::filesystem::path& dir) {
  if (std::optional<dataset::Problem> problem = no_folder(dir)) {
    return std::unexpected(std::move(*problem));
  }
  std::vector<std::filesystem::path> found;
  std::vector<std::filesystem::path> half;
  std::error_code error;
  for (std::filesystem::directory_iterator at(dir, error), end; !error && at != end;
       at.increment(error)) {
    const bool left = dataset::is_there(at->path() / "left.pgm");
    const bool right = dataset::is_there(at->path() / "right.pgm");
    if (left || right) {
      (left && right ? found : half).push_back(at->path());
    }
  }
  if (!half.empty()) {
    return std::unexpected(halves(std::move(half)));
  }
  std::ranges::sort(found);
  return found;
}

dataset::Loaded<std::vector<std::filesystem::path>> list_pairs(const std::filesystem::path& dir) {
  dataset::Loaded<std::vector<std::filesystem::path>> found = pairs_so_far(dir);
  if (found && found->empty()) {
    return dataset::refuse(dir, "holds no folder with left.pgm and right.pgm",
                           "give one with a folder for each view");
  }
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
