/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_LENS_SHARED_H
#define FNL_PASSES_LENS_SHARED_H

#include "shared.h"

#define LENS_QUADS 48u /* in each direction */
#define LENS_TERMS 4
#define LENS_ENCODES 1u /* to sRGB */
#define LENS_COUNTS 2u

/* A corner of the mesh: its place on the eye's part of the display, 0 .. 1 right and down, and what it shows, in tangents. */
struct gpu_lens_vertex {
    vec2 position;
    vec2 red;
    vec2 green;
    vec2 blue;
};

/* A picture that lies in a plane: what is seen at the tangents (x, y) is its place (a, b) / c with (a, b, c) = rows * (x, y, -1), if c > 0. */
struct gpu_lens_layer {
    vec3 rows[3];
    uint image;   /* sampled, linear light */
    uint blended; /* by its alpha */
};

struct gpu_lens_eye {
    vec4 display;  /* left, right, down, up of the display, tangents without lens */
    vec4 rendered; /* … of what was rendered: nothing is seen beyond */
    vec2 center;
    float visible_radius;
    float terms[12]; /* LENS_TERMS of red, green, blue */
    vec2 source_size; /* pixels of the eye's picture */
};

struct gpu_lens_push {
    ADDRESS(lens_eye_block) eye;
    ADDRESS(lens_layers) layers;
    ADDRESS(lens_vertices) vertices; /* 0: no mesh */
    ADDRESS(const_uint_array) cells; /* quads of the mesh that are drawn */
    ADDRESS(uint_array) count;       /* of pixels; with LENS_COUNTS */
    vec2 origin;                     /* of the eye's part, pixels from the upper left corner of the target */
    vec2 size;
    vec2 target;                     /* pixels of the target */
    uint layer_count;
    uint sampler_index;
    uint view;   /* fnl_display_view */
    uint flags; /* LENS_… */
};

#endif
