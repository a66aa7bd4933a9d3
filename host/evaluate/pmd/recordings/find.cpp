#include "host/evaluate/pmd/recordings/find.h"

#include <algorithm>
#include <tuple>

#include "dataset/files/file.h"

namespace stof::host {
namespace {

namespace fs = std::filesystem;

constexpr int kLevels = 2;
constexpr std::string_view kPatternEnding = "_fppn.pgm";

bool is_there(fs::path file, const char* ending) {
  std::error_code error;
  return fs::exists(file += ending, error);
}

dataset::Loaded<std::vector<fs::path>> entries_of(const fs::path& folder) {
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  std::vector<fs::path> found;
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    found.push_back(entry->path());
  }
  if (error) {
    return dataset::refuse(folder.string() +
                           ": is not a folder that can be read: give a folder of PMD recordings");
  }
  std::ranges::sort(found);
  return found;
}

// The recordings of one folder, sorted into sets.
class Sorter {
 public:
  Sorter(const fs::path& folder, PmdFolders& out) : folder_(folder), out_(out) {}

  void add(const fs::path& prefix, const PmdSetup& setup) {
    if (setup.camera && !camera_) {
      camera_ = setup.camera;
    }
    if (setup.pair) {
      (setup.modulation_hz == (*setup.pair)[0] ? first_frequencies_ : second_frequencies_)
          .emplace_back(prefix, *setup.pair);
    } else if (setup.edge_m) {
      set_of(PmdKind::kEdge).push_back(prefix);
    } else if (setup.z_m) {
      set_of(setup.lights_aside ? PmdKind::kLights : PmdKind::kWalls).push_back(prefix);
    } else if (is_there(prefix, "_r_min.pgm") && is_there(prefix, "_r_max.pgm") &&
               is_there(prefix, "_r_med.pgm")) {
      set_of(PmdKind::kScenes).push_back(prefix);
    } else {
      out_.notes.push_back(prefix.string() + ": says nothing about its scene; skipped");
    }
  }

  void note_pattern(const fs::path& file) { patterns_.push_back(file); }
  void note_frame() { frame_ = true; }

  void finish() {
    for (const auto& [prefix, pair] : first_frequencies_) {
      const auto other = std::ranges::find(second_frequencies_, pair, &PrefixWithPair::second);
      if (other == second_frequencies_.end()) {
        out_.notes.push_back(prefix.string() + ": its second frequency is absent; skipped");
        continue;
      }
      std::vector<fs::path>& frequencies = set_of(PmdKind::kFrequencies);
      frequencies.push_back(prefix);
      frequencies.push_back(other->first);
      second_frequencies_.erase(other);
    }
    for (const auto& [prefix, pair] : second_frequencies_) {
      out_.notes.push_back(prefix.string() + ": its first frequency is absent; skipped");
    }
    if (frame_) {
      set_of(PmdKind::kFrame);
    }
    for (const fs::path& file : patterns_) {
      const std::string name = file.filename().string();
      if (camera_) {
        out_.sources.patterns.try_emplace(
            {name.substr(0, name.size() - kPatternEnding.size()), *camera_}, file);
      }
    }
  }

 private:
  using PrefixWithPair = std::pair<fs::path, std::array<double, 2>>;

  std::vector<fs::path>& set_of(PmdKind kind) {
    for (PmdSet& set : out_.sets) {
      if (set.kind == kind && set.folder == folder_) {
        return set.prefixes;
      }
    }
    return out_.sets.emplace_back(PmdSet{.kind = kind, .folder = folder_, .prefixes = {}}).prefixes;
  }

  const fs::path& folder_;
  PmdFolders& out_;
  std::optional<long> camera_;
  bool frame_ = false;
  std::vector<fs::path> patterns_;
  std::vector<PrefixWithPair> first_frequencies_;
  std::vector<PrefixWithPair> second_frequencies_;
};

std::expected<void, dataset::Problem> look_into(const fs::path& folder, int levels,
                                                PmdFolders& out) {
  const dataset::Loaded<std::vector<fs::path>> entries = entries_of(folder);
  if (!entries) {
    return std::unexpected(entries.error());
  }
  Sorter sorter(folder, out);
  std::error_code error;
  for (const fs::path& entry : *entries) {
    fs::path prefix = entry;
    prefix.replace_extension();
    if (fs::is_directory(entry, error)) {
      if (levels > 0) {
        if (auto looked = look_into(entry, levels - 1, out); !looked) {
          return looked;
        }
      }
    } else if (entry.filename().string().ends_with(kPatternEnding)) {
      sorter.note_pattern(entry);
    } else if (entry.filename() == "info.json") {
      if (is_there(folder / "radial_distance", ".pgm")) {
        sorter.note_frame();
      }
    } else if (entry.extension() == ".json" && is_there(prefix, "_raw.pgm")) {
      const dataset::Loaded<PmdSetup> setup = read_setup(prefix);
      if (!setup) {
        return std::unexpected(setup.error());
      }
      sorter.add(prefix, *setup);
    }
  }
  sorter.finish();
  return {};
}

}  // namespace

dataset::Loaded<PmdFolders> find_pmd(const fs::path& folder) {
  PmdFolders out;
  if (auto looked = look_into(folder, kLevels, out); !looked) {
    return std::unexpected(std::move(looked.error()));
  }
  if (out.sets.empty()) {
    return dataset::refuse(
        folder.string() +
        ": holds no PMD recording with a known scene: give a folder with PREFIX.json and "
        "PREFIX_raw.pgm that say z_m, x_edge_m or pair, or have range maps");
  }
  std::ranges::sort(out.sets, [](const PmdSet& a, const PmdSet& b) {
    return std::tie(a.kind, a.folder) < std::tie(b.kind, b.folder);
  });
  return out;
}

}  // namespace stof::host
