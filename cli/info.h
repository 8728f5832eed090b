/* SPDX-License-Identifier: MIT */
#ifndef FNL_CLI_INFO_H
#define FNL_CLI_INFO_H

#include <stdint.h>

struct gbuffer_question {
    uint32_t width, height, samples;
    double frames_per_second;
};
/** Fields, bits, bytes at a size and bandwidth of all G-buffer layouts. */
void info_print_gbuffers(const struct gbuffer_question *question);

#endif
