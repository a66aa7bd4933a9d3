#pragma once

#include "dataset/calibration_truth.h"
#include "dataset/files/pfm.h"
#include "dataset/files/pgm.h"
#include "dataset/image.h"
#include "dataset/pmd_pair.h"
#include "dataset/pmd_recording.h"
#include "dataset/stereo_scene.h"
#include "dataset/write_pmd.h"

// Recorded scenes in files: the folder layout of stereo pairs (left.pgm, right.pgm, meta.txt,
// gt_left.pgm, nonocc.pgm) and of PMD frames (PREFIX.json, PREFIX_raw.pgm, <W>x<H>_fppn.pgm beside
// it). Used by the emulated cameras and by the command line; nothing here runs in the loop.
