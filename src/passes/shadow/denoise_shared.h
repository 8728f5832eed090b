/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_DENOISE_SHARED_H
#define FNL_PASSES_DENOISE_SHARED_H

#include "shared.h"

#define DENOISE_GROUP 8u  /* side of a work group, pixels */
#define DENOISE_LEVELS 4u /* of the spatial filter: taps are 1, 2, 4 and 8 pixels apart; Schied et al. 2017 have five */

#define DENOISE_FRAMES 32.0  /* that a pixel's history counts for at most while something moves, */
#define DENOISE_STILL 256.0  /* and when nothing has moved for DENOISE_SETTLED frames: a plain mean, as far as 16-bit floats hold one */
#define DENOISE_SETTLED 16
#define DENOISE_NORMAL 0.8   /* cosine between normals of one surface in two frames */
#define DENOISE_PLANE 1.0    /* pixels that its points may lie off its plane */
#define DENOISE_CHANGE 4.0   /* what a change of light, as a part of it, takes from the history */
#define DENOISE_STEADY 0.02  /* change that interpolation may feign */
#define DENOISE_DOUBT 2.0    /* standard deviations from which on this frame contradicts the history around a pixel, */
#define DENOISE_PROOF 4.0    /* and those that prove it wrong */
#define DENOISE_PRIOR 4.0    /* frames that the pixels around count for where a pixel's own variance is estimated */
#define DENOISE_SHARP 1.0    /* standard deviations at which the filter tells two pixels apart */
#define DENOISE_POWER 32.0   /* of the cosine between normals */
#define DENOISE_SKY 2.0      /* alpha of pixels that are not denoised: no coordinate of a normal */

/* Sums over the pixels of a view. */
struct gpu_denoise_counts {
    uint pixels;    /* whose shadows are noisy */
    uint fresh;     /* of them, without history */
    uint refuted;   /* of them, whose history was shortened because its shadows are no longer there */
    uint frames[2]; /* of their histories: low and high word */
};

/*
 * What of each pixel is kept for the next frame, RGBA16F each: `seen` the light that the shadows leave, over the luminance of all light, and the
 * frames that it is a mean of; `drawn` the same before shadows, and the part seen in this frame alone; `surface` view depth, 0 for none, and the
 * normal; `field` the vector of light and its sum (light_apart.field of shade.glsl), the former over the latter.
 */
struct gpu_denoise_collect_push {
    ADDRESS(view_block) view;
    ADDRESS(view_block) previous; /* of the last frame, without jitter; with keeps */
    ADDRESS(denoise_count_block) counts;
    uint depth;  /* sampled, all up to was_field */
    uint motion;
    uint open;   /* rgb all light, cd/m^2; alpha the normal's first coordinate, or DENOISE_SKY */
    uint now_seen;  /* rgb; alpha the normal's second coordinate */
    uint now_drawn; /* rgb; alpha light_apart.noise */
    uint now_field;
    uint was_seen;  /* with keeps, as the three below */
    uint was_drawn;
    uint was_surface;
    uint was_field;
    uint seen; /* storage, all below */
    uint drawn;
    uint surface; /* kept */
    uint places;  /* RGBA32F: view depth, 0 for none; normal; normal of the depths around; noise */
    uint keeps;   /* 1: there is a last frame */
    uint still;   /* 1: nothing has moved since */
    float longest; /* history: frames */
};

struct gpu_denoise_verify_push {
    ADDRESS(view_block) view;
    ADDRESS(denoise_count_block) counts;
    uint now_seen; /* sampled, all up to places: of this frame */
    uint now_drawn;
    uint seen; /* of the first pass */
    uint drawn;
    uint places;
    uint kept_seen; /* storage: as they are kept */
    uint kept_drawn;
    uint to_seen;  /* storage: the same with the variance of the part that is seen in place of the frames */
    uint to_drawn; /* storage: `drawn` with a guess of that part */
    uint settled;  /* 1: history stays as it is */
};

struct gpu_denoise_filter_push {
    ADDRESS(view_block) view;
    uint seen;  /* sampled; alpha variance */
    uint drawn; /* sampled; alpha the guess, by which pixels are compared */
    uint places;
    uint open;       /* sampled; of the last level, as the next */
    uint radiance;   /* storage */
    uint to_seen;    /* storage; not of the last level */
    uint to_drawn;
    uint step;       /* pixels between taps */
};

struct gpu_denoise_view_push {
    ADDRESS(view_block) view;
    uint image;  /* sampled: alpha is shown */
    uint places; /* sampled */
    uint target; /* storage */
    uint history; /* 1: frames, 0: variance */
    uint swap;
};

#endif
