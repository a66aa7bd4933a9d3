#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include "dataset/files/pfm.h"
#include "dataset/files/pgm.h"
#include "dataset/pmd_recording.h"
#include "dataset/stereo_scene.h"
#include "tests/fuzz/fuzz_input.h"

// Files of a recorded scene: any bytes. The first byte of the input says which file it is; the
// others of its folder are good. Read whole, or refused in one line.
namespace stof {
namespace {

// Memory, not a disk, where the system has such a folder; gone with the process.
class Folder {
 public:
  Folder() {
    const std::filesystem::path memory = "/dev/shm";
    path_ = (std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path()) /
            ("stof_fuzz_" + std::to_string(getpid()));
    std::filesystem::create_directories(path_);
    const std::string picture = "P5\n4 2\n255\n" + std::string(8, 'x');
    put("left.pgm", picture);
    put("right.pgm", picture);
    put("meta.txt", "scene small\nndisp 16\n");
    put("p_raw.pgm", "P5\n2 4\n65535\n" + std::string(16, '\1'));
    put("p.json", kRecording);
  }
  ~Folder() {
    std::error_code none;
    std::filesystem::remove_all(path_, none);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void put(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary | std::ios::trunc) << bytes;
  }
  std::string get(const std::string& name) const {
    std::ifstream file(path_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  static constexpr const char* kRecording =
      R"({"width": 2, "height": 1, "f_mod_hz": 20e6, "dark_lsb": 0, "sat_lsb": 4000, "fx": 2,)"
      R"( "fy": 2, "cx": 0.5, "cy": 0, "lsb_e": 10, "read_e": 20})";

  std::filesystem::path path_;
};

template <typename Loaded>
void judge(const Loaded& loaded) {
  if (!loaded) {
    fuzz::require(!loaded.error().message.empty());
    fuzz::require(loaded.error().message.find('\n') == std::string::npos);
  }
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  static const Folder folder;
  static constexpr std::array<const char*, 8> kNames{"left.pgm",    "right.pgm",    "meta.txt",
                                                     "gt_left.pgm", "surfaces.pgm", "p.json",
                                                     "p_raw.pgm",   "z.pfm"};
  if (input.empty()) {
    return;
  }
  const std::string name = kNames[static_cast<std::size_t>(input[0]) % kNames.size()];
  const std::string before = folder.get(name);
  const auto* const begin = reinterpret_cast<const char*>(input.data());
  folder.put(name, std::string(begin + 1, begin + input.size()));
  if (name.starts_with("p")) {
    judge(dataset::read_pmd(folder.path() / "p"));
  } else if (name == "z.pfm") {
    judge(dataset::read_pfm(folder.path() / name));
  } else {
    judge(dataset::read_stereo_scene(folder.path()));
    if (name.ends_with(".pgm")) {
      judge(dataset::read_pgm8(folder.path() / name));
      judge(dataset::read_pgm16(folder.path() / name));
    }
  }
  if (before.empty()) {
    std::filesystem::remove(folder.path() / name);
  } else {
    folder.put(name, before);
  }
}
