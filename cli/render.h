/* SPDX-License-Identifier: MIT */
/** What `fanal render` was asked for, and the parts that do it. */
#ifndef FNL_CLI_RENDER_H
#define FNL_CLI_RENDER_H

#include "fanal/fanal.h"

enum { RENDER_MAX_OUTPUTS = 16 };
enum render_aov {
    RENDER_AOV_DEPTH,
    RENDER_AOV_NORMAL,
    RENDER_AOV_ALBEDO,
    RENDER_AOV_ROUGHNESS,
    RENDER_AOV_ID,
    RENDER_AOV_POSITION,
    RENDER_AOV_MOTION,
    RENDER_AOV_COUNT
};

struct render_options {
    const char *scene, *outputs[RENDER_MAX_OUTPUTS], *camera, *animation, *device, *stats;
    int output_count;
    fnl_frame frame;
    bool has_eye, has_look_at, has_shading, has_background, has_ambient, has_anisotropy, validate, quiet, plan, traffic;
    fnl_vec3 eye, look_at, background, ambient;
    float anisotropy;
    float fov;                  /* radians; 0: the camera's */
    double choose_seconds;      /* that auto may take before the frames */
    uint32_t frame_count;       /* timed ones; 0: the picture alone */
    uint32_t aovs;              /* bits 1 << enum render_aov */
    fnl_scatter_params scatter;
    uint32_t grow_metal; /* texels */
    bool has_range_roughness;
    float range_roughness;
    double time;
    bool has_frames, has_frame_time;
    uint32_t supersample; /* frames whose mean is taken; 0 or 1: none */
    double frame_time;    /* seconds between the pictures of a sequence */
};

/** Whether a path ends in this extension (without dot), in any case. */
bool render_has_extension(const char *path, const char *extension);
/** Whether a path stands for the pictures of a sequence: one %d, with or without a width, and no other %. */
bool render_is_sequence(const char *path);
/** Loads, renders, writes; returns the exit status. */
int render_run(const struct render_options *options);

/** Times and counts over the frames of a run. */
struct render_report {
    fnl_device_info device;
    fnl_scene_info scene;
    fnl_frame frame;
    fnl_frame_stats stats; /* of the last, counted frame; its passes are not used */
    uint32_t frame_count, pass_count;
    const char **names;            /* pass_count */
    double *pass_times;            /* pass_count * frame_count: times of one pass in a row */
    double *cpu_times, *gpu_times; /* frame_count */
};

void report_print(const struct render_report *report);
/** A line instead, where nothing but the picture was asked for; `seconds` is what the command took. */
void report_print_picture(const struct render_report *report, double seconds);
/** False with a message when the file cannot be written. */
bool report_save(const struct render_report *report, const char *path);

#endif
