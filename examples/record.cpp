// Records some frames of a sensor, and reads them again: record HOST[:PORT] FILE.mcap [FRAMES]
#include <cstdio>
#include <cstdlib>
#include <string>

#include <stof/stof.hpp>

namespace {

int fail(const std::string& why) {
  std::fprintf(stderr, "%s\n", why.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: record HOST[:PORT] FILE.mcap [FRAMES]\n");
    return 2;
  }
  const int frames = argc > 3 ? std::atoi(argv[3]) : 30;
  std::string why;
  auto sensor = stof::Sensor::open(argv[1], &why);
  if (!sensor || sensor->record(argv[2], &why) != STOF_OK) {
    return fail(why);
  }
  for (int i = 0; i < frames; ++i) {
    if (!sensor->next(std::chrono::seconds(5))) {
      return fail("no frame for 5 s");
    }
  }
  if (sensor->end_recording(nullptr, &why) != STOF_OK) {
    return fail(why);
  }

  stof_options options = STOF_INIT(stof_options);
  options.recording = argv[2];
  auto recording = stof::Sensor::open(options, &why);
  if (!recording) {
    return fail(why);
  }
  int read = 0;
  while (const auto frame = recording->next(std::chrono::seconds(1))) {
    std::printf("frame %u: %dx%d, %u of %u packets missing\n", frame->number(),
                frame->depth().width(), frame->depth().height(), frame->c().missing_packets,
                frame->c().packets);
    ++read;
  }
  std::printf("%d frames in %s\n", read, argv[2]);
  return read == frames ? 0 : 1;
}
