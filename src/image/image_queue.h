/* SPDX-License-Identifier: MIT */
/**
 * Decodes pictures in the background. A thread of the queue spreads them over jobs of its own, which are the host's where that has a
 * parallel_for. Answers wait until they are taken; while 32 MiB of pixels or more wait, nothing else is begun.
 */
#ifndef FNL_IMAGE_IMAGE_QUEUE_H
#define FNL_IMAGE_IMAGE_QUEUE_H

#include "image/texture.h"

struct image_queue;

/** A file of a picture, to be decoded by texture_decode(), with its mips. Its bytes and its name must stay as they are until the queue is destroyed. */
struct image_request {
    uint32_t id; /* the caller's */
    const void *bytes;
    size_t size;
    const char *name;       /* for messages */
    uint64_t pixel_bytes;   /* about what it takes when it is decoded */
    struct texture_use use;
};

struct image_answer {
    uint32_t id;
    fnl_result result; /* an error was logged, by the thread that met it */
    struct texture texture; /* of FNL_OK */
};

/** `threads`: at most so many decode at once, where the host has no parallel_for; at least 1. */
fnl_result image_queue_create(const fnl_host *host, uint32_t threads, struct image_queue **out);
/** Waits for pictures that are being decoded; those whose turn has not come are dropped. */
void image_queue_destroy(struct image_queue **queue);

/** FNL_ERROR_MEMORY: it was not taken into the queue. */
fnl_result image_queue_ask(struct image_queue *queue, const struct image_request *request);
/** The next answer, if there is one; its pixels are the caller's then. Never waits, unless the machine gives the queue no thread. */
bool image_queue_take(struct image_queue *queue, struct image_answer *out);

#endif
