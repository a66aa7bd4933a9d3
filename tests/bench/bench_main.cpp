// stof_bench [--quick] [--json FILE] [SCENE_DIR...]: what this project computes and what OpenCV
// does in its place, in random turns in one process. The first scene named, in several sizes;
// without any the emulated corridor.

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string_view>

#include <benchmark/benchmark.h>

#include "dsp/base/target.h"
#include "tests/bench/bench_opencv.h"
#include "tests/bench/bench_report.h"

namespace stof::bench {
namespace {

struct Options {
  bool quick = false;
  std::string json;
  std::vector<std::string> scenes;
};

struct Size {
  int width;
  int height;
  int disparities;

  std::string text() const {
    return std::to_string(width) + "x" + std::to_string(height) + "x" + std::to_string(disparities);
  }
};

constexpr const char* kBlocks = "WTA 15x15";
constexpr const char* kDenseBm = "StereoBM dense";
constexpr const char* kThreeWay = "StereoSGBM 3WAY";

// The kernels' NEON source through SIMDe, whatever the processor has.
Work with_neon(Work work) {
  return [work = std::move(work)] {
    dsp::use_vectors(dsp::Vectors::kNeon);
    work();
    dsp::use_vectors(dsp::widest_vectors());
  };
}

class Bench {
 public:
  explicit Bench(const Options& options) : quick_(options.quick), rounds_(options.quick ? 7 : 31) {}

  bool load(const std::vector<std::string>& scenes) {
    if (scenes.empty()) {
      return true;
    }
    for (const std::string& folder : scenes) {
      auto scene = dataset::read_stereo_scene(folder);
      if (!scene) {
        std::fprintf(stderr, "bench: %s\n", scene.error().message.c_str());
        return false;
      }
      scenes_.push_back(std::move(*scene));
    }
    return true;
  }

  void run() {
    std::printf("%s; best: %s; %d rounds\n", opencv_version().c_str(),
                name_of(dsp::widest_vectors()), rounds_);
    for (const int threads : {1, 2}) {
      for (std::size_t scene = 0; scene < std::clamp(scenes_.size(), 1UZ, 2UZ); ++scene) {
        stereo({450, 375, 64}, threads, scene);
      }
      stereo({640, 480, 64}, threads);
      if (!quick_) {
        stereo({1280, 720, 128}, threads);
      }
    }
    sensors();
    corridor();
    temporal();
    if (!quick_) {
      growth();
    }
  }

  bool keep(const std::string& file) const {
    std::ofstream out(file);
    out << json(outcomes_, rounds_, opencv_version());
    return out.good();
  }

 private:
  Pictures pictures(int width, int height, std::size_t index = 0) const {
    return scenes_.empty() ? corridor_pictures(width, height)
                           : resized(scenes_[index % scenes_.size()], width, height);
  }
  void add(const Group& group, int rounds) {
    set_opencv_threads(group.threads);
    const std::vector<Outcome> found = measure(group, rounds);
    outcomes_.insert(outcomes_.end(), found.begin(), found.end());
  }
  void add(const Group& group) { add(group, rounds_); }

  void stereo(const Size& size, int threads, std::size_t scene = 0) {
    const Pictures both = pictures(size.width, size.height, scene);
    const int n = size.disparities;
    const Work blocks = match_work(both, block_params(n), threads);
    const Work quality = match_work(both, preset_params("quality", n), threads);
    Group group{.name = size.text() + ", " + both.name, .threads = threads, .contenders = {}};
    group.contenders = {{kBlocks, blocks, kDenseBm},
                        {"fast", match_work(both, preset_params("fast", n), threads), kDenseBm},
                        {"quality", quality, kThreeWay},
                        {kDenseBm, stereo_bm_work(both, n, true), ""},
                        {kThreeWay, stereo_sgbm_work(both, n, true), ""}};
    if (threads == 1) {
      pairs_beside(both, n, group);
    } else {
      group.contenders.push_back({"WTA 15x15, one thread", match_work(both, block_params(n)), ""});
      group.contenders.push_back(
          {"quality, one thread", match_work(both, preset_params("quality", n)), ""});
      group.contenders[0].peer = "WTA 15x15, one thread";
      group.contenders[2].peer = "quality, one thread";
    }
    add(group);
  }

  // What is timed with one thread only.
  static void pairs_beside(const Pictures& both, int n, Group& group) {
    std::vector<Contender>& all = group.contenders;
    all.push_back(
        {"WTA 15x15, NEON source", with_neon(match_work(both, block_params(n))), kDenseBm});
    all.push_back({"quality, NEON source", with_neon(match_work(both, preset_params("quality", n))),
                   kThreeWay});
    all.push_back({"full search, whole px", match_work(both, pyramid_params(0, n)), kDenseBm});
    for (const int levels : {1, 2}) {
      all.push_back({"coarse to fine, " + std::to_string(levels),
                     match_work(both, pyramid_params(levels, n)), "full search, whole px"});
    }
    all.push_back({"StereoBM default", stereo_bm_work(both, n, false), ""});
    all.push_back({"StereoSGBM 5 paths", stereo_sgbm_work(both, n, false), ""});
  }

  void sensors() {
    for (const Size& size : {Size{176, 144, 0}, Size{640, 480, 0}}) {
      const Samples samples(size.width, size.height);
      const std::string text = std::to_string(size.width) + "x" + std::to_string(size.height);
      add({.name = "PMD " + text,
           .threads = 1,
           .contenders = {
               {"phase", phase_work(samples), "subtract, cartToPolar"},
               {"phase, NEON source", with_neon(phase_work(samples)), "subtract, cartToPolar"},
               {"subtract, cartToPolar", polar_work(samples), ""}}});
    }
    const Pictures both = pictures(640, 480);
    add({.name = "rectify 640x480, both pictures",
         .threads = 1,
         .contenders = {
             {"rectify", rectify_work(both), "remap, fixed point"},
             {"rectify, NEON source", with_neon(rectify_work(both)), "remap, fixed point"},
             {"remap, fixed point", remap_work(both), ""}}});
  }

  void corridor() {
    dsp::MatchParams match = block_params(64);
    match.left_right_tolerance = 1;
    const auto work = std::make_shared<CorridorWork>(match);
    const auto step = [&work](void (CorridorWork::*one)()) -> Work {
      return [work, one] { (*work.*one)(); };
    };
    add({.name = "frame: corridor 640x480x64, PMD 176x144",
         .threads = 1,
         .contenders = {{"whole frame", step(&CorridorWork::frame), kDenseBm},
                        {"PMD convert", step(&CorridorWork::convert), kDenseBm},
                        {"match", step(&CorridorWork::match), kDenseBm},
                        {"convert and fuse", step(&CorridorWork::convert_and_fuse), kDenseBm},
                        {"packets, depth by RVL", step(&CorridorWork::code_depth), kDenseBm},
                        {"packets, three streams", step(&CorridorWork::code_three), kDenseBm},
                        {"RVL encode depth", step(&CorridorWork::encode), kDenseBm},
                        {"RVL decode depth", step(&CorridorWork::decode), kDenseBm},
                        {"CRC of 600 KiB", step(&CorridorWork::check), kDenseBm},
                        {kDenseBm, stereo_bm_work(work->pictures(), 64, true), ""}}});
  }

  // What earlier frames of a view that stands still cost.
  void temporal() {
    const auto with = std::make_shared<CorridorWork>(preset_params("fast", 64), true);
    const auto without = std::make_shared<CorridorWork>(preset_params("fast", 64));
    const Group group{
        .name = "temporal filter, 640x480",
        .threads = 1,
        .contenders = {{"convert, fuse, temporal", [with] { with->stand(); }, kDenseBm},
                       {"convert, fuse", [without] { without->stand(); }, kDenseBm},
                       {kDenseBm, stereo_bm_work(with->pictures(), 64, true), ""}}};
    const std::size_t first = outcomes_.size();
    add(group, 61);  // a difference of two times
    outcomes_.push_back(difference("temporal filter", outcomes_[first], outcomes_[first + 1],
                                   outcomes_[first + 2]));
  }

  // Time over size and over candidates.
  void growth() {
    for (const Size& size :
         {Size{320, 240, 64}, Size{480, 360, 64}, Size{640, 480, 64}, Size{800, 600, 64},
          Size{960, 720, 64}, Size{1280, 720, 64}, Size{640, 480, 16}, Size{640, 480, 32},
          Size{640, 480, 96}, Size{640, 480, 128}, Size{640, 480, 192}, Size{640, 480, 256}}) {
      grow("growth ", size, 1);
    }
    // Pictures that become wider see the same depths with more candidates.
    for (const Size& size : {Size{320, 240, 32}, Size{480, 360, 48}, Size{640, 480, 64},
                             Size{800, 600, 80}, Size{960, 720, 96}, Size{1280, 720, 128}}) {
      for (const int threads : {1, 2}) {
        grow("together ", size, threads);
      }
    }
  }
  void grow(const char* what, const Size& size, int threads) {
    const Pictures both = pictures(size.width, size.height);
    const int n = size.disparities;
    add({.name = what + size.text(),
         .threads = threads,
         .contenders = {
             {kBlocks, match_work(both, block_params(n), threads), kDenseBm},
             {"fast", match_work(both, preset_params("fast", n), threads), kDenseBm},
             {"quality", match_work(both, preset_params("quality", n), threads), kDenseBm},
             {kDenseBm, stereo_bm_work(both, n, true), ""}}});
  }

  bool quick_;
  int rounds_;
  std::vector<dataset::StereoScene> scenes_;
  std::vector<Outcome> outcomes_;
};

std::optional<Options> read(std::vector<std::string> words) {
  Options options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--quick") {
      options.quick = true;
    } else if (words[i] == "--json" && i + 1 < words.size()) {
      options.json = words[++i];
    } else if (words[i].starts_with("-")) {
      return std::nullopt;
    } else {
      options.scenes.push_back(words[i]);
    }
  }
  return options;
}

int run(const std::vector<std::string>& words) {
  const std::optional<Options> options = read(words);
  if (!options) {
    std::fputs("bench: stof_bench [--quick] [--json FILE] [SCENE_DIR...]\n", stderr);
    return 2;
  }
  Bench bench(*options);
  if (!bench.load(options->scenes)) {
    return 2;
  }
  bench.run();
  if (!options->json.empty() && !bench.keep(options->json)) {
    std::fprintf(stderr, "bench: %s cannot be written: name another file\n", options->json.c_str());
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace stof::bench

int main(int argc, char** argv) {
  std::vector<std::string> flags{"stof_bench", "--benchmark_enable_random_interleaving=true"};
  std::vector<char*> pointers{flags[0].data(), flags[1].data()};
  int count = 2;
  benchmark::Initialize(&count, pointers.data());
  return stof::bench::run({argv + 1, argv + argc});
}
