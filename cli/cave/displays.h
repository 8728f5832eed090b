/* SPDX-License-Identifier: MIT */
/** The displays of a CAVE: walls, devices, head and place, read from JSON (docs/cave.md). */
#ifndef FNL_CLI_CAVE_DISPLAYS_H
#define FNL_CLI_CAVE_DISPLAYS_H

#include "cave/pose.h"

enum { CAVE_WALLS = 32, CAVE_NAME = 32, CAVE_DEVICES = 16, CAVE_RANKS = 64 };
enum cave_eye { CAVE_MONO, CAVE_LEFT, CAVE_RIGHT, CAVE_EYES };

struct cave_wall {
    char name[CAVE_NAME];
    struct cave_vector lower_left, lower_right, upper_left; /* metres, in the space of the CAVE, as seen by the viewer */
    uint32_t width, height;                                 /* pixels */
    bool stereo;
    int32_t device[2], rank[2]; /* of mono or the left eye, and of the right eye; -1: not said */
};

struct cave_sample {
    double time; /* seconds */
    struct cave_pose pose;
};

struct cave_displays {
    char *source; /* as it was given */
    struct cave_wall walls[CAVE_WALLS];
    uint32_t wall_count;
    char *devices[CAVE_DEVICES]; /* index or part of a name, as --device takes it */
    uint32_t device_count;
    struct cave_sample *track; /* of the head, in the space of the CAVE, by time; one or more */
    uint32_t track_count;
    double ipd;  /* metres */
    double near_distance;
    bool has_origin;
    struct cave_place origin;
    uint64_t hash; /* of what was read, the file of the track too */
};

/** Reads a file or one of the examples, builtin:NAME. False with a message that names the file and the place in it. To be freed in any case. */
bool cave_displays_load(const char *source, struct cave_displays *out);
void cave_displays_free(struct cave_displays *displays);
/** The JSON of an example; NULL: there is none of this name. */
const char *cave_displays_example(const char *source);
/** "mono", "left", "right". */
const char *cave_eye_name(enum cave_eye eye);
/** Where the head is; before the first sample and after the last it stands still. */
struct cave_pose cave_displays_head(const struct cave_displays *displays, double time);

#endif
