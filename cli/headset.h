/* SPDX-License-Identifier: MIT */
/** A scripted headset: what a file (--hmd) says about its two displays, and how the head moves. docs/techniques/stereo.md has the format. */
#ifndef FNL_CLI_HEADSET_H
#define FNL_CLI_HEADSET_H

#include "fanal/fanal.h"

enum { HEADSET_EYES = 2, HEADSET_LENS_TERMS = 4, HEADSET_HIDDEN_MAX = 3 * 4096, HEADSET_POSES_MAX = 100000 };

/**
 * A lens, with a polynomial for each colour: a point of the display at the distance r from the lens's centre shows the point of the picture at
 * r * (1 + k[0] r^2 + k[1] r^4 + ...), both in tangents.
 */
struct headset_lens {
    bool given;
    fnl_vec2 center;                      /* tangents */
    float k[3][HEADSET_LENS_TERMS];       /* red, green, blue; 0 where the file has fewer terms */
};

struct headset_eye {
    fnl_eye eye;
    uint32_t width, height; /* pixels of the picture that is rendered for it; 0: the file does not say */
    struct headset_lens lens;
    fnl_vec2 *hidden;       /* corners of triangles that nobody sees, three by three, in tangents: x right, y up */
    uint32_t hidden_count;
};

struct headset_pose {
    double time; /* seconds; they ascend */
    fnl_rigid_pose pose;
    fnl_vec3 gaze; /* the point that the eyes look at, seen from the head, metres */
};

struct headset {
    char name[64];
    struct headset_eye eyes[HEADSET_EYES]; /* left, right */
    struct headset_pose *poses;            /* of the head, seen from the camera; none: it stays there */
    uint32_t pose_count;
    bool has_gaze; /* some pose says where the eyes look; without, straight ahead */
};

/** Reads a file, or one of those built in ("builtin:simple"). False after a message that names the file and the place in it. */
bool headset_load(const char *path, struct headset *out);
void headset_free(struct headset *headset);
/** The names of those built in, without "builtin:"; NULL beyond the last. */
const char *headset_builtin(uint32_t index);
/** Moves the eyes along X until they are `ipd` metres apart, as far to the left of the head as to its right. */
void headset_set_ipd(struct headset *headset, float ipd);
/** Metres between the eyes. */
float headset_ipd(const struct headset *headset);
/** The head at a time: between two poses what lies between them, before the first and after the last these. */
fnl_rigid_pose headset_pose_at(const struct headset *headset, double time);
/** Likewise where the eyes look, seen from the head. */
fnl_vec3 headset_gaze_at(const struct headset *headset, double time);

#endif
