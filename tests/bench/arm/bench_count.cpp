// stof_count TASK...: runs each task once between two marks that count.c knows, and
// prints its name. Without a task it prints what there is.

#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tests/bench/arm/marks.h"
#include "tests/bench/bench_work.h"

namespace stof::bench {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kDisparities = 64;

using Make = std::function<Work()>;

dsp::MatchParams frame_params() {
  dsp::MatchParams match = block_params(kDisparities);
  match.left_right_tolerance = 1;
  return match;
}

template <typename Params>  // of the appliance or of the lab
Work matching(const Params& params) {
  return match_work(made_pictures(kWidth, kHeight), params);
}

// A step of the corridor's frame, which takes seconds to render: once for all.
Make step(void (CorridorWork::*one)()) {
  return [one]() -> Work {
    static const auto kCorridor = std::make_shared<CorridorWork>(frame_params());
    return [one] { (*kCorridor.*one)(); };
  };
}

const std::map<std::string_view, Make>& tasks() {
  static const std::map<std::string_view, Make> kTasks{
      {"wta", [] { return matching(block_params(kDisparities)); }},
      {"fast", [] { return matching(preset_params("fast", kDisparities)); }},
      {"fast_depth", [] { return matching(appliance_params("fast", kDisparities)); }},
      {"quality", [] { return matching(preset_params("quality", kDisparities)); }},
      {"pyramid1", [] { return matching(pyramid_params(1, kDisparities)); }},
      {"pyramid2", [] { return matching(pyramid_params(2, kDisparities)); }},
      {"phase", [] { return phase_work(Samples(176, 144)); }},
      {"rectify", [] { return rectify_work(made_pictures(kWidth, kHeight)); }},
      {"convert", step(&CorridorWork::convert)},
      {"fuse", step(&CorridorWork::convert_and_fuse)},
      {"packets", step(&CorridorWork::code_depth)},
      {"rvl_encode", step(&CorridorWork::encode)},
      {"rvl_decode", step(&CorridorWork::decode)},
      {"crc", step(&CorridorWork::check)},
      {"frame", step(&CorridorWork::frame)},
  };
  return kTasks;
}

int run(const std::vector<std::string_view>& names) {
  for (const std::string_view name : names) {
    const auto task = tasks().find(name);
    if (task == tasks().end()) {
      std::fprintf(stderr, "stof_count: no task %s\n", std::string(name).c_str());
      return 2;
    }
    const Work work = task->second();
    count_begin();
    work();
    count_end();
    std::printf("%s\n", std::string(name).c_str());
  }
  if (names.empty()) {
    for (const auto& [name, make] : tasks()) {
      std::printf("%s\n", std::string(name).c_str());
    }
  }
  return 0;
}

}  // namespace
}  // namespace stof::bench

int main(int argc, char** argv) { return stof::bench::run({argv + 1, argv + argc}); }
