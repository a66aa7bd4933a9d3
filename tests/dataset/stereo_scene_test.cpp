#include <limits>

#include "dataset/dataset.h"
#include "tests/dataset/scratch.h"

namespace stof::dataset {
namespace {

using test::expect_one_line_about;
using namespace std::string_view_literals;

constexpr float kNone = std::numeric_limits<float>::infinity();

class StereoScenes : public test::Scratch {
 protected:
  StereoScenes() {
    put("Little/left.pgm", "P5\n3 1\n255\n\x0a\x14\x1e"sv);
    put("Little/right.pgm", "P5\n3 1\n255\n\x14\x1e\x28"sv);
    put("Little/meta.txt", "scene Little\nndisp 16\r\nndisp_note 99\ngt_scale 4\n");
  }
  std::filesystem::path dir() const { return folder() / "Little"; }
  void expect_refused(const std::filesystem::path& file, std::string_view fact) const {
    const Loaded<StereoScene> scene = read_stereo_scene(dir());
    ASSERT_FALSE(scene) << file;
    expect_one_line_about(scene.error().message, file, fact);
  }
};

TEST_F(StereoScenes, AreReadWithoutTruth) {
  const Loaded<StereoScene> scene = read_stereo_scene(dir());
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->name, "Little");
  EXPECT_EQ(scene->ndisp, 16);
  EXPECT_EQ(scene->left.pixels, (std::vector<std::uint8_t>{10, 20, 30}));
  EXPECT_EQ(scene->right.pixels, (std::vector<std::uint8_t>{20, 30, 40}));
  EXPECT_FALSE(scene->truth);
  EXPECT_FALSE(scene->visible);
}

TEST_F(StereoScenes, AreNamedAfterTheFolderHoweverItIsWritten) {
  for (const std::filesystem::path& path : {dir() / "", dir() / ".", dir() / ".." / "Little"}) {
    const Loaded<StereoScene> scene = read_stereo_scene(path);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->name, "Little") << path;
  }
}

TEST_F(StereoScenes, ScaleTheTruthAndLeaveZeroUnknown) {
  put("Little/gt_left.pgm", "P5\n3 1\n255\n\x00\x06\xff"sv);
  put("Little/nonocc.pgm", "P5\n3 1\n255\n\x00\xff\x00"sv);
  const Loaded<StereoScene> scene = read_stereo_scene(dir());
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_TRUE(scene->truth);
  EXPECT_EQ(scene->truth->pixels, (std::vector<float>{kNone, 1.5F, 63.75F}));
  ASSERT_TRUE(scene->visible);
  EXPECT_EQ(scene->visible->pixels, (std::vector<std::uint8_t>{0, 255, 0}));
}

TEST_F(StereoScenes, AreRefusedWithoutOneOfTheirFiles) {
  for (const char* name : {"left.pgm", "right.pgm", "meta.txt"}) {
    std::filesystem::rename(dir() / name, dir() / "aside");
    expect_refused(dir() / name, "does not exist");
    std::filesystem::rename(dir() / "aside", dir() / name);
  }
}

TEST_F(StereoScenes, AreRefusedWhenTheFolderIsMissing) {
  const std::filesystem::path absent = folder() / "absent";
  const Loaded<StereoScene> scene = read_stereo_scene(absent);
  ASSERT_FALSE(scene);
  expect_one_line_about(scene.error().message, absent, "is not a folder");
}

TEST_F(StereoScenes, AreRefusedWhenSizesDiffer) {
  for (const char* name : {"right.pgm", "gt_left.pgm", "nonocc.pgm"}) {
    put(std::string("Little/") + name, "P5\n1 3\n255\n123"sv);
    expect_refused(dir() / name, "is 1x3 but left.pgm is 3x1");
    put("Little/right.pgm", "P5\n3 1\n255\n123"sv);
    put("Little/gt_left.pgm", "P5\n3 1\n255\n123"sv);
  }
}

TEST_F(StereoScenes, AreRefusedWithoutAUsableSearchRange) {
  for (const char* meta : {"", "ndisp", "ndisp \n", "ndisp 0", "ndisp -4", "ndisp nan", "ndisp 1e9",
                           "ndisp 2.5", "ndisp 16x", "ndisps 16", " ndisp 16"}) {
    put("Little/meta.txt", meta);
    expect_refused(dir() / "meta.txt", "ndisp");
  }
}

TEST_F(StereoScenes, AreRefusedWithTheSizeOfOtherPictures) {
  for (const char* line : {"width 0", "width -5", "width 321", "width abc", "width ", "width 3.5",
                           "height 0", "height 3"}) {
    put("Little/meta.txt", std::string("ndisp 16\n") + line + "\n");
    expect_refused(dir() / "meta.txt", line);
  }
  put("Little/meta.txt", "ndisp 16\nwidth 3\nheight 1\nnote width 7\n");
  EXPECT_TRUE(read_stereo_scene(dir()));
}

TEST_F(StereoScenes, AreRefusedWithAKeyTwice) {
  for (const char* line : {"ndisp 8", "ndisp x", "gt_scale 4", "width 3"}) {
    const std::string twice = std::string(line) + "\n" + line + "\n";
    put("Little/meta.txt", (line[0] == 'n' ? "" : "ndisp 16\n") + twice);
    expect_refused(dir() / "meta.txt", "twice");
  }
}

TEST_F(StereoScenes, AreRefusedWithTruthOfUnknownScale) {
  put("Little/gt_left.pgm", "P5\n3 1\n255\n123"sv);
  for (const char* meta : {"ndisp 16\n", "ndisp 16\ngt_scale 0\n", "ndisp 16\ngt_scale inf\n",
                           "ndisp 16\ngt_scale -1\n"}) {
    put("Little/meta.txt", meta);
    expect_refused(dir() / "meta.txt", "gt_scale");
  }
}

TEST_F(StereoScenes, KnowTheirRigWhereItIsGivenWhole) {
  EXPECT_FALSE(read_stereo_scene(dir())->rig);
  for (const char* meta : {"ndisp 16\nf_px 60\n", "ndisp 16\nf_px 60\nbaseline_m 0\n",
                           "ndisp 16\nf_px inf\nbaseline_m 1\n"}) {
    put("Little/meta.txt", meta);
    EXPECT_FALSE(read_stereo_scene(dir())->rig) << meta;
  }
  put("Little/meta.txt", "ndisp 16\nf_px 60.5\nbaseline_m 0.1\ndoff_px -2\n");
  const Loaded<StereoScene> scene = read_stereo_scene(dir());
  ASSERT_TRUE(scene && scene->rig);
  EXPECT_EQ(scene->rig->left.fx, 60.5);
  EXPECT_EQ(scene->rig->left.cx, 1);  // the middle of three columns
  EXPECT_EQ(scene->rig->baseline_m, 0.1);
  EXPECT_EQ(scene->rig->doff_px, -2);
}

TEST_F(StereoScenes, KnowHowFarTheirPlaneIs) {
  EXPECT_FALSE(read_stereo_scene(dir())->plane_z_m);
  for (const char* z : {"0", "-1", "1001", "nan", "inf", "far"}) {
    put("Little/meta.txt", std::string("ndisp 16\nplane_z_m ") + z + "\n");
    expect_refused(dir() / "meta.txt", "plane_z_m");
  }
  put("Little/meta.txt", "ndisp 16\nplane_z_m 1.6\n");
  EXPECT_EQ(read_stereo_scene(dir())->plane_z_m, 1.6);
}

TEST_F(StereoScenes, KnowTheFloorWhereSurfacesAreGiven) {
  EXPECT_FALSE(read_stereo_scene(dir())->floor);
  put("Little/surfaces.pgm", "P5\n3 1\n255\n\x01\x04\x06"sv);
  for (const char* pose : {"", "camera_height_m 0.6\n", "camera_tilt_degrees 15\n",
                           "camera_height_m 0\ncamera_tilt_degrees 15\n",
                           "camera_height_m inf\ncamera_tilt_degrees 15\n",
                           "camera_height_m 0.6\ncamera_tilt_degrees 90\n",
                           "camera_height_m 0.6\ncamera_tilt_degrees nan\n"}) {
    put("Little/meta.txt", std::string("ndisp 16\n") + pose);
    expect_refused(dir() / "meta.txt", "camera_height_m");
  }
  put("Little/meta.txt", "ndisp 16\ncamera_height_m 0.6\ncamera_tilt_degrees -15.5\n");
  const Loaded<StereoScene> scene = read_stereo_scene(dir());
  ASSERT_TRUE(scene && scene->floor);
  EXPECT_EQ(scene->floor->height_m, 0.6);
  EXPECT_EQ(scene->floor->tilt_degrees, -15.5);
  EXPECT_EQ(scene->floor->surface.pixels,
            (std::vector<Surface>{Surface::kFloor, Surface::kGlass, Surface::kOther}));
  put("Little/surfaces.pgm", "P5\n1 3\n255\n123"sv);
  expect_refused(dir() / "surfaces.pgm", "is 1x3 but left.pgm is 3x1");
}

TEST_F(StereoScenes, AreReadAsTheyWereWritten) {
  StereoScene written;
  written.name = "Copy";
  written.left = {3, 2, 7};
  written.right = {3, 2, 255};
  written.ndisp = 33;
  written.truth.emplace(3, 2, 12.25F);
  written.truth->pixels[1] = kNone;
  written.truth->pixels[2] = 0.001F;  // no longer known to be 0, which means unknown
  written.truth->pixels[3] = 900;
  written.visible.emplace(3, 2, 255);
  written.visible->pixels[4] = 0;
  written.rig = dsp::StereoRig{.left = {}, .baseline_m = 0.1, .doff_px = 1.0 / 3};
  written.rig->left.fx = 615.123456789;
  written.floor = FloorTruth{.height_m = 0.1, .tilt_degrees = 1.0 / 3, .surface = {3, 2}};
  written.floor->surface.pixels[1] = Surface::kWall;
  std::filesystem::create_directories(folder() / "Copy");
  ASSERT_TRUE(write_stereo_scene(folder() / "Copy", written));
  const Loaded<StereoScene> read = read_stereo_scene(folder() / "Copy");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->name, written.name);
  EXPECT_EQ(read->ndisp, 33);
  EXPECT_EQ(read->left.pixels, written.left.pixels);
  EXPECT_EQ(read->right.pixels, written.right.pixels);
  EXPECT_EQ(read->visible->pixels, written.visible->pixels);
  EXPECT_EQ(read->truth->pixels,
            (std::vector<float>{12.25F, kNone, 1.0F / 256, 255, 12.25F, 12.25F}));
  EXPECT_EQ(read->rig->left.fx, 615.123456789);
  EXPECT_EQ(read->rig->doff_px, 1.0 / 3);
  ASSERT_TRUE(read->floor);
  EXPECT_EQ(read->floor->height_m, 0.1);
  EXPECT_EQ(read->floor->tilt_degrees, 1.0 / 3);
  EXPECT_EQ(read->floor->surface.pixels, written.floor->surface.pixels);
}

TEST_F(StereoScenes, AreRefusedWhereTheyCannotBeWritten) {
  StereoScene scene;
  scene.left = {1, 1};
  scene.right = {1, 1};
  const std::expected<void, Problem> written = write_stereo_scene(folder() / "absent", scene);
  ASSERT_FALSE(written);
  expect_one_line_about(written.error().message, folder() / "absent" / "left.pgm",
                        "cannot be written");
}

}  // namespace
}  // namespace stof::dataset
