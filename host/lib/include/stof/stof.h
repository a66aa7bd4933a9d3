/* libstof: frames, health and settings of a stof depth sensor. C99 and later; C++ programs may
 * prefer stof/stof.hpp, a thin wrapper of this header.
 *
 * Threads. A stof_sensor belongs to one thread at a time, except where a function says otherwise;
 * different sensors are independent. stof_discover() and all functions that return names may be
 * called from any thread.
 * Ownership. stof_close() frees a stof_sensor. Pointers in a stof_frame are the library's: valid
 * until the next stof_next() or stof_close() of that sensor, in a callback until it returns;
 * stof_keep() makes them yours.
 * Nothing is ever thrown or aborted for what arrives from the network.
 * Growth. Structures begin with their size where a later version may add fields at their end: set
 * it (STOF_INIT does), then an older program works with a newer library and the other way round.
 * Times are nanoseconds, of the sensor's clock unless "here" says CLOCK_MONOTONIC of this machine.
 */
#ifndef STOF_STOF_H
#define STOF_STOF_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define STOF_API __attribute__((visibility("default")))
#else
#define STOF_API
#endif

/* stof_options options = STOF_INIT(stof_options); */
#ifdef __cplusplus
#define STOF_INIT(type) stof_sized<type>()
extern "C++" {
template <typename T>
inline T stof_sized() noexcept {
  T value{};
  value.struct_size = static_cast<uint32_t>(sizeof value);
  return value;
}
}
#else
#define STOF_INIT(type) {.struct_size = (uint32_t)sizeof(type)}
#endif

typedef enum stof_status {
  STOF_OK = 0,
  STOF_TIMEOUT = 1,      /* nothing came in time: call again */
  STOF_BAD_ARGUMENT = 2, /* a null pointer, a size of 0, a text that is no address */
  STOF_UNREACHABLE = 3,  /* no such host, no such port to be had, no answer */
  STOF_LOST = 4,         /* the socket failed: close, then open again */
  STOF_NOT_YET = 5,      /* the sensor has not sent that so far */
  STOF_BUSY = 6,         /* the sensor's own thread runs: stof_stop() first */
  STOF_TOO_SMALL = 7,    /* your array is too small; the count tells what is needed */
  STOF_REFUSED = 8,      /* the sensor refused the settings; the text says why */
  STOF_NO_MEMORY = 9,
  STOF_UNSUPPORTED = 10, /* the sensor or this library cannot do that */
  STOF_INTERNAL = 11     /* a fault of this library */
} stof_status;

/* A few words such as "timeout"; never NULL, also of numbers that have no name. */
STOF_API const char* stof_status_text(int status);
/* Of the library in use: "0.1.0". */
STOF_API const char* stof_version(void);
/* sizeof(name) in the library in use, of a structure of this header, "stof_frame"; 0: it has none
 * of that name. For languages that do not read this header: structures without struct_size never
 * change, the others only grow. */
STOF_API size_t stof_struct_size(const char* name);

/* ---- Opening ------------------------------------------------------------------------------- */

typedef struct stof_sensor stof_sensor;

typedef struct stof_options {
  uint32_t struct_size;
  uint32_t device_id;      /* only this one; 0: any, with keys the one that `stof` proved there */
  const char* sensor;      /* "HOST" or "HOST:PORT" (7560 without) to subscribe at; NULL: wait for a
                              sensor that was told to send here */
  const char* bind;        /* without a sensor: where to listen; NULL: every IPv4 interface */
  uint16_t port;           /* likewise; 0: 7560 */
  uint16_t reserved;       /* 0 */
  uint32_t socket_buffer;  /* bytes asked of the system; 0: 4 MiB */
  uint32_t max_pixels;     /* of one image, bounds the memory; 0: 2 Mi */
  uint32_t max_age_ms;     /* frames that arrived here longer ago, or come later than others by
                              more, are dropped and counted; 0: one period of the sensor and
                              100 ms */
  uint32_t signed_streams; /* 1: subscribe with a key of `keys`, and believe only what the sensor
                             signs for this program alone, see docs/SECURITY.md; 0: believe all */
  const char* keys; /* file of the keys that requests are signed with, as `stof pair` makes it;
                       NULL: this user's own, "": none */
  uint32_t key_id;  /* only the sensor of this key of `keys`: a number any sensor can say of itself,
                       a key it cannot; 0: any */
  uint32_t reserved_2; /* 0 */
} stof_options;

/* Does not wait for the sensor, but may block on a name server. `why` (may be NULL) gets one line
 * for a person when it fails. STOF_BAD_ARGUMENT, STOF_UNREACHABLE, STOF_NO_MEMORY. */
STOF_API stof_status stof_open(const stof_options* options, stof_sensor** sensor, char* why,
                               size_t why_size);
/* Ends the subscription and the sensor's thread. NULL is nothing. Not from a callback. */
STOF_API void stof_close(stof_sensor* sensor);

/* ---- Frames -------------------------------------------------------------------------------- */

/* An image. Pixel (x, y) lies at (char*)data + y * stride + x * pixel_bytes. data NULL: the
 * stream is not sent, or nothing of it arrived. What did not arrive is 0. */
typedef struct stof_plane {
  const void* data;
  uint32_t width;
  uint32_t height;
  size_t stride; /* bytes from row to row */
  size_t bytes;  /* from the first to the last pixel */
  uint32_t pixel_bytes;
  uint32_t missing;     /* pixels that did not arrive */
  const uint8_t* marks; /* a byte a pixel: it arrived where (marks[..] & mark) != 0; may be NULL */
  size_t marks_stride;  /* bytes from row to row */
  uint8_t mark;
  uint8_t reserved[7];
} stof_plane;

typedef enum stof_source {
  STOF_SOURCE_NONE = 0,
  STOF_SOURCE_STEREO = 1,
  STOF_SOURCE_PMD = 2,
  STOF_SOURCE_BOTH = 3,
  STOF_SOURCE_RESOLVED = 4, /* no agreement: one sensor, or the surfaces around, decided */
  STOF_SOURCE_CONFLICT = 5  /* they disagreed: no depth */
} stof_source;

typedef enum stof_cause { /* why a depth was resolved or is missing */
                          STOF_CAUSE_NONE = 0,
                          STOF_CAUSE_MIXED_PIXEL = 1,
                          STOF_CAUSE_STEREO_AMBIGUOUS = 2,
                          STOF_CAUSE_RANGE_AMBIGUOUS = 3,
                          STOF_CAUSE_OCCLUDED = 4,
                          STOF_CAUSE_CONTRADICTION = 5,
                          STOF_CAUSE_INTERPOLATED = 6 /* no sensor told it, surfaces around did */
} stof_cause;

typedef enum stof_health_state {
  STOF_HEALTH_OK = 0,
  STOF_HEALTH_DEGRADED = 1,
  STOF_HEALTH_FAULT = 2
} stof_health_state;

/* Of the rectified left camera: no distortion, the centre of the first pixel is (0, 0). The point
 * of pixel (u, v) with depth Z is X = (u - cx) Z / fx, Y = (v - cy) Z / fy: x right, y down, z
 * forward. Z = fx baseline_m / (disparity + doff). */
typedef struct stof_calibration {
  uint32_t width; /* pixels */
  uint32_t height;
  double fx; /* pixels, as fy, cx, cy, doff */
  double fy;
  double cx;
  double cy;
  double doff; /* cx of the right camera less that of the left */
  double k[9]; /* [fx 0 cx; 0 fy cy; 0 0 1], row by row */
  double baseline_m;
  double depth_unit_m; /* of one step of depth and interval_width */
  double max_range_m;
  double period_s;    /* of the trigger */
  uint32_t pmd_width; /* 0: no PMD camera */
  uint32_t pmd_height;
  double modulation_hz;
  double r[9]; /* X_left = R X_pmd + T, row by row */
  double t[3]; /* metres */
} stof_calibration;

/* What a frame stands on: the sum of these. Where a sensor is missing, the other one goes on. */
#define STOF_SENSOR_STEREO 1
#define STOF_SENSOR_PMD 2

typedef struct stof_info { /* how the frame was made */
  /* Of the stereo pair; in a frame of the PMD camera alone, of that. */
  int64_t exposure_begin_ns;
  int64_t exposure_end_ns;
  int64_t pmd_age_ns; /* how much older the PMD data are than the pair's */
  int64_t compute_ns;
  int64_t latency_ns; /* from the middle of the exposure to the sending of the first packet */
  uint32_t pixels_by_source[6];
  uint32_t pixels_by_cause[6];
  uint32_t settings_revision;
  uint8_t pmd_present; /* PMD data took part */
  uint8_t cloud_step;  /* side of a cloud's block, pixels; 0: no cloud */
  uint8_t sensors;     /* STOF_SENSOR_..., the sum; 0: the library is older than this field */
  uint8_t reserved;
} stof_info;

typedef struct stof_cloud_point { /* a pixel of the plane `cloud` */
  int16_t x_mm;
  int16_t y_mm;
  uint16_t depth; /* depth units; 0: no point */
  uint16_t interval_width;
} stof_cloud_point;

typedef struct stof_frame {
  uint32_t struct_size;
  uint32_t device_id;
  uint32_t session_id; /* another one at each start of the sensor */
  uint32_t number;     /* advances by one with each frame sent, wraps */
  uint32_t freshness;  /* advances with each verified new exposure */
  uint32_t health;     /* stof_health_state */
  int64_t exposure_middle_ns;
  int64_t first_packet_ns; /* here */
  int64_t last_packet_ns;  /* here */
  uint32_t packets;        /* that the frame was sent in */
  uint32_t missing_packets;
  uint32_t recovered_packets; /* made of parity */
  /* What stamps count: 0 the sensor's clock; 1 that of an emulated rig; 2 that of a recording that
     is played again: nothing of the frame is new. */
  uint8_t emulated;
  uint8_t has_info;
  uint8_t has_calibration;
  uint8_t reserved;
  stof_plane depth; /* uint16_t, depth units, Z; 0: none */
  /* uint16_t, depth units: the truth lies in depth -+ interval_width / 2 (95 %) */
  stof_plane interval_width;
  stof_plane source;    /* uint8_t, stof_source */
  stof_plane cause;     /* uint8_t, stof_cause */
  stof_plane disparity; /* int16_t, 1/16 pixel, stereo alone; INT16_MIN: none */
  stof_plane pmd[4];    /* uint16_t, the samples A0 to A3 */
  stof_plane left;      /* uint8_t, grey */
  stof_plane right;
  stof_plane cloud; /* stof_cloud_point */
  stof_info info;
  stof_calibration calibration;
  const void* self; /* the library's */
  /* Of the settings it was made with: another one, other settings. 0: unknown, or the library is
   * older than this field. */
  uint32_t settings_fingerprint;
  /* On how many frames in a row this depth stands, itself included: for how many the sensor stood.
   * 1: it stands alone; 0: nobody says (an older sensor or library, or no info arrived). */
  uint32_t steady_frames;
  /* Of the calibration that it was made with: another one, another calibration on the sensor. The
   * CRC-32C at the end of its file. `calibration` above is of this one or, until the sensor has
   * told it, absent. 0: unknown, as above. */
  uint32_t calibration_fingerprint;
  uint32_t reserved2;
} stof_frame;

/* The next frame, also an incomplete one (missing_packets). Blocks for timeout_ms at most, 0 only
 * looks. Call it at least once a second: it keeps the subscription alive. frame->struct_size is
 * set by you. STOF_TIMEOUT, STOF_LOST, STOF_BUSY, STOF_BAD_ARGUMENT, STOF_NO_MEMORY. */
STOF_API stof_status stof_next(stof_sensor* sensor, int timeout_ms, stof_frame* frame);

/* Keeps a frame beyond the next one, without a copy: its images move from the sensor to *kept, and
 * the pointers in `frame` stay valid until stof_release(), also after stof_close(). *kept NULL: a
 * new one is made, some 10 bytes a pixel. Otherwise the frame that it kept ends, and its memory is
 * the sensor's again: with a few of them in turn nothing is allocated. On the thread that
 * stof_next() gave the frame to, or in its callback, of a copy of the stof_frame.
 * STOF_BAD_ARGUMENT: also of a frame that is kept or over; then *kept is as before. STOF_NO_MEMORY.
 */
typedef struct stof_kept stof_kept;
STOF_API stof_status stof_keep(stof_frame* frame, stof_kept** kept);
/* NULL is nothing. From any thread. */
STOF_API void stof_release(stof_kept* kept);

/* For poll(): readable when stof_next(sensor, 0, ...) has something to do. -1: no sensor. */
STOF_API int stof_fd(const stof_sensor* sensor);
/* After so many milliseconds it has something to do in any case; 0: now. */
STOF_API int stof_due_ms(const stof_sensor* sensor);

typedef struct stof_point { /* metres in the rectified left camera: x right, y down, z forward */
  float x;
  float y;
  float z;
  float z_width;   /* the truth lies in z -+ z_width / 2 (95 %); -1: unknown */
  uint32_t source; /* stof_source; STOF_SOURCE_NONE: unknown */
} stof_point;

/* One point for each pixel of `depth`, or where that is not sent of `cloud`. `count` gets how many
 * there are, `points` (may be NULL when capacity is 0) the first `capacity` of them.
 * STOF_NOT_YET: no calibration yet; STOF_TOO_SMALL; STOF_BAD_ARGUMENT; STOF_NO_MEMORY. */
STOF_API stof_status stof_points(const stof_frame* frame, stof_point* points, size_t capacity,
                                 size_t* count);

/* ---- Health and events --------------------------------------------------------------------- */

typedef struct stof_health {
  uint32_t struct_size;
  uint32_t active;   /* bit k: condition k is active, see stof_condition_name() */
  uint32_t severity; /* 0 info, 1 minor, 2 major, 3 critical */
  uint32_t reaction; /* of the robot: 0 go on, 1 tell somebody, 2 slow down, 3 stop */
  uint64_t uptime_ms;
  double rate_hz; /* frames of the last second */
  double latency_s;
  double longest_latency_s;
  uint64_t frames_published;
  uint64_t packets_sent;
  uint32_t subscribers;
  uint32_t settings_revision;
} stof_health;

typedef struct stof_event {
  uint32_t struct_size;
  uint32_t sequence;
  uint32_t condition; /* see stof_condition_name() */
  uint32_t severity;
  uint32_t reaction;
  uint32_t active; /* 1: it began, 0: it ended */
  uint32_t count;  /* how often it has begun */
  uint32_t value;  /* depends on the condition */
  int64_t at_ns;
} stof_event;

/* The newest that stof_next() has read, from any thread. STOF_NOT_YET. */
STOF_API stof_status stof_get_health(stof_sensor* sensor, stof_health* health);
/* The next event, each once; look after every stof_next(). STOF_TIMEOUT: none. STOF_BUSY. */
STOF_API stof_status stof_next_event(stof_sensor* sensor, stof_event* event);
/* From any thread; never NULL, "unknown" for what this library does not know. */
STOF_API const char* stof_condition_name(unsigned condition); /* "stereo_lost" */
STOF_API const char* stof_condition_text(unsigned condition); /* a sentence */
STOF_API const char* stof_severity_name(unsigned severity);
STOF_API const char* stof_reaction_name(unsigned reaction);
STOF_API const char* stof_source_name(unsigned source);
STOF_API const char* stof_cause_name(unsigned cause);
STOF_API const char* stof_health_name(unsigned health);

/* What is known by this machine's clock, whatever the sensor says. */
#define STOF_LINK_SILENT 1U    /* no frame for three periods and 20 ms */
#define STOF_LINK_RESTARTED 2U /* for a second, and until the first frame after a start */
/* In the last 2 s came what no sensor can have sent, or what is not signed and should be. Not
 * believed. */
#define STOF_LINK_FORGED 4U
/* In the last 2 s frames came later than others before by more than max_age_ms: not delivered. */
#define STOF_LINK_DELAYED 8U
/* Of signed streams: whoever answers says that the sensor knows none of your keys: pair again. */
#define STOF_LINK_NO_KEY 16U

typedef struct stof_link {
  uint32_t struct_size;
  uint32_t conditions;        /* the sum of STOF_LINK_... */
  int64_t frame_age_ns;       /* since the newest frame arrived here; -1: there was none */
  int64_t health_age_ns;      /* likewise of what stof_get_health() tells */
  int64_t calibration_age_ns; /* likewise */
} stof_link;

/* As of now, also while nobody calls stof_next(). From any thread. */
STOF_API stof_status stof_get_link(stof_sensor* sensor, stof_link* link);

/* ---- A thread of its own ------------------------------------------------------------------- */

/* Called on the sensor's thread, one at a time; any of them may be NULL. Return soon: while one
 * runs nothing is received, and after 100 ms or so packets are lost. */
typedef struct stof_callbacks {
  uint32_t struct_size;
  void (*frame)(void* user, const stof_frame* frame);
  void (*health)(void* user, const stof_health* health); /* when a new one came */
  void (*event)(void* user, const stof_event* event);
  void (*failed)(void* user, stof_status status); /* the last call: the thread has ended */
  void* user;
} stof_callbacks;

/* STOF_BUSY: it runs already. STOF_BAD_ARGUMENT, STOF_INTERNAL: the system gives no thread. */
STOF_API stof_status stof_start(stof_sensor* sensor, const stof_callbacks* callbacks);
/* Returns when no callback runs or will run. STOF_BUSY: called from a callback. */
STOF_API stof_status stof_stop(stof_sensor* sensor);

/* ---- What became of the packets ------------------------------------------------------------ */

typedef struct stof_statistics { /* since stof_open() */
  uint32_t struct_size;
  uint32_t socket_buffer; /* bytes that the system granted */
  uint64_t packets;
  uint64_t packets_ok;
  uint64_t packets_refused; /* damaged, cut short, of another version, contradicting themselves */
  uint64_t packets_unknown; /* of a newer sensor */
  uint64_t packets_foreign; /* of another sensor or an ended session */
  uint64_t packets_duplicate;
  uint64_t packets_late;
  uint64_t packets_missing;
  uint64_t packets_recovered;
  uint64_t frames_complete;
  uint64_t frames_incomplete;
  uint64_t frames_stale;   /* showed the past: not delivered */
  uint64_t frames_lost;    /* nothing of them arrived */
  uint64_t frames_dropped; /* nobody took them, or the sensor started again */
  uint64_t sessions;
  uint64_t socket_drops;        /* found the socket's buffer full */
  uint64_t packets_old;         /* waited in this machine's queue for too long */
  uint64_t packets_implausible; /* no sensor can have sent them: forged, or a fault */
  uint64_t frames_old;          /* waited for too long, or held back: not delivered */
  uint64_t resynchronised;      /* the order of frames was wrong and begun anew */
  uint64_t packets_not_signed;  /* where signed_streams was asked for: not signed, or for others */
  uint64_t packets_forged;      /* likewise: with a wrong signature */
} stof_statistics;

/* From any thread. */
STOF_API stof_status stof_get_statistics(stof_sensor* sensor, stof_statistics* statistics);
/* One line: what to change on this machine to lose less; empty: nothing. Returns its length, which
 * may exceed what fitted. From any thread. */
STOF_API size_t stof_advice(stof_sensor* sensor, char* text, size_t size);

/* ---- Settings ------------------------------------------------------------------------------ */

typedef enum stof_operation {
  STOF_GET = 0,    /* a document, JSON */
  STOF_SET = 1,    /* text: a JSON object; changes those fields, or nothing if one is refused */
  STOF_STAGE = 2,  /* the same to the staged settings */
  STOF_COMMIT = 3, /* the staged settings become the active ones and are saved */
  STOF_REVERT = 4, /* what is staged is forgotten */
  STOF_PRESET = 5, /* text: a preset's name */
  STOF_SAVE = 6,   /* the active settings are those of the next start */
  STOF_RESET = 7   /* every field's default */
} stof_operation;

typedef enum stof_document { /* of STOF_GET */
                             STOF_ACTIVE = 0,
                             STOF_STAGED = 1,
                             STOF_SAVED = 2,
                             STOF_DEFAULTS = 3,
                             STOF_SCHEMA = 4 /* the JSON Schema of all of these */
} stof_document;

typedef struct stof_answer {
  uint32_t struct_size;
  uint32_t revision; /* of the active settings: advances with every change */
  uint32_t restart;  /* 1: some of them wait for the next start */
  uint32_t reserved;
  size_t text_length; /* of the whole text, without the final 0 */
} stof_answer;

/* Asks the sensor of stof_options::sensor over a socket of its own; blocks for about a second when
 * nobody answers. From any thread. `in`: the text, NULL: none. `out`: the answer's text, ended by
 * 0, cut where out_size is too small; of a refusal which field and what it takes. `answer` may be
 * NULL. With a key of the sensor requests are signed, and
 * only answers that it signed are believed. STOF_REFUSED (also: it takes a key, or the file of keys
 * cannot be used), STOF_UNREACHABLE, STOF_UNSUPPORTED (no sensor was named, or an operation it
 * does not know), STOF_TOO_SMALL (of STOF_GET), STOF_BAD_ARGUMENT, STOF_NO_MEMORY, STOF_LOST. */
STOF_API stof_status stof_settings(stof_sensor* sensor, stof_operation operation,
                                   stof_document document, const char* in, char* out,
                                   size_t out_size, stof_answer* answer);

/* ---- Finding sensors ----------------------------------------------------------------------- */

#define STOF_FOUND_BY_MDNS 1U
#define STOF_FOUND_BY_BEACON 2U
#define STOF_FOUND_DIRECTLY 4U /* it answered this machine */

typedef struct stof_found {
  char serial[17]; /* all texts end with 0 */
  char name[33];
  char version[17];
  char board[17];
  char endpoint[84]; /* for stof_options::sensor */
  uint32_t device_id;
  uint32_t found_by; /* the sum of STOF_FOUND_... */
  int32_t health;    /* stof_health_state; -1: unknown, as the rest */
  float rate_hz;
  uint32_t subscribers;
  uint32_t most_subscribers;
} stof_found;

/* Blocks for timeout_ms; 2,500 is good. addresses: HOST[:PORT] to ask besides, NULL when
 * address_count is 0. found_size: sizeof(stof_found). `count` gets how many there are.
 * STOF_TOO_SMALL, STOF_BAD_ARGUMENT, STOF_NO_MEMORY. */
STOF_API stof_status stof_discover(int timeout_ms, const char* const* addresses,
                                   size_t address_count, stof_found* found, size_t capacity,
                                   size_t found_size, size_t* count, char* why, size_t why_size);

#ifdef __cplusplus
}
#endif

#endif
