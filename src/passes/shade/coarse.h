/* SPDX-License-Identifier: MIT */
/**
 * Deferred shading at a coarse rate: blocks of 2x2 or 4x4 pixels whose surfaces are alike are lit once, all other pixels each. The inverse of
 * multisampling: most of a picture needs less than one evaluation a pixel. After Sathe and Janczak, "Deferred Coarse Pixel Shading", GPU Pro 7
 * (2016), III.2. One pass decides what each block is; the next lights them: a thread has a block, then pixels of those blocks that are not alike.
 */
#ifndef FNL_PASSES_COARSE_H
#define FNL_PASSES_COARSE_H

#include "passes/shade/coarse_shared.h"
#include "passes/shade/gbuffer.h"

/** Whether criterion minmax reads ranges through samplers; else shaders look at each texel, with the same result. */
bool coarse_has_samplers(const gpu_device *device);

struct coarse_params {
    fnl_coarse_options options;
    bool samplers; /* coarse_has_samplers(), or false all the same */
    bool words;    /* keep the kind of each pixel, for views */
    vec3 gaze;     /* with options.fovea: where the viewer looks, a unit vector in view space */
};

/** The G-buffer of the default layout, and what the options need of more: see gbuffer_add(). */
struct gbuffer coarse_gbuffer_add(struct graph *graph, const struct shade_input *input, const struct coarse_params *params,
                                  bool prepass, graph_image radiance, graph_image depth);
/** Bytes of a pixel that this has more than the layout. */
uint32_t coarse_extra_bytes(const fnl_coarse_options *options);

struct coarse {
    graph_buffer counts; /* COARSE_COUNTS uints */
    graph_buffer words;  /* a COARSE_… kind for each pixel; id 0: none */
};
/** Lights the G-buffer of coarse_gbuffer_add(). `radiance` holds emission and background. */
struct coarse coarse_add(struct graph *graph, gpu_device *device, const struct shade_input *input,
                         const struct coarse_params *params, const struct gbuffer *gbuffer, graph_image radiance);

#endif
