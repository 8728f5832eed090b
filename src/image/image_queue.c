/* SPDX-License-Identifier: MIT */
#include "image/image_queue.h"

#include "base/jobs.h"
#include "image/image.h"

#include <pthread.h>
#include <stdatomic.h>

enum {
    BATCH = 16,            /* pictures handed to the jobs at once */
    BATCH_BYTES = 64 << 20, /* of their pixels, where that is not fewer pictures than threads */
    WAITING_BYTES = 32 << 20
};

struct image_queue {
    fnl_host host;
    struct jobs *jobs;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    pthread_t thread;
    bool threaded;
    atomic_bool stop;

    struct image_request batch[BATCH]; /* the thread's own */

    /* Guarded by the mutex. */
    ARRAY(struct image_request) asked;  /* from first_asked on */
    ARRAY(struct image_answer) answers; /* from first_answer on; there is room for all that were asked for */
    uint32_t first_asked, first_answer, working;
    uint64_t waiting_bytes; /* of answers */
};

static uint64_t bytes_of(const struct texture *texture) { return texture->bytes ? texture_offset(texture, texture->mips, 0) : 0; }

static void decode_one(void *context, uint32_t i) {
    struct image_queue *queue = context;
    const struct image_request *request = &queue->batch[i];
    struct image_answer answer = {.id = request->id, .result = FNL_ERROR_CANCELLED};
    if (!atomic_load(&queue->stop))
        answer.result = texture_decode(&queue->host, request->bytes, request->size, request->name, &request->use, &answer.texture);
    pthread_mutex_lock(&queue->mutex);
    queue->answers.data[queue->answers.count++] = answer;
    queue->waiting_bytes += bytes_of(&answer.texture);
    queue->working--;
    pthread_mutex_unlock(&queue->mutex);
}

/* Takes requests out of the line and decodes them. The mutex is held, but not meanwhile. */
static void decode_batch(struct image_queue *queue) {
    uint32_t count = 0, least = jobs_thread_count(queue->jobs);
    for (uint64_t bytes = 0; count < BATCH && queue->first_asked < queue->asked.count; count++) {
        const struct image_request *next = &queue->asked.data[queue->first_asked];
        bytes += next->pixel_bytes;
        if (bytes > BATCH_BYTES && count >= least) break;
        queue->batch[count] = *next;
        queue->first_asked++;
    }
    if (queue->first_asked == queue->asked.count) queue->first_asked = queue->asked.count = 0;
    queue->working = count;
    pthread_mutex_unlock(&queue->mutex);
    jobs_parallel_for(queue->jobs, count, decode_one, queue);
    pthread_mutex_lock(&queue->mutex);
}

static void *work(void *argument) {
    struct image_queue *queue = argument;
    pthread_mutex_lock(&queue->mutex);
    while (!atomic_load(&queue->stop)) {
        if (queue->asked.count == 0 || queue->waiting_bytes >= WAITING_BYTES)
            pthread_cond_wait(&queue->changed, &queue->mutex);
        else
            decode_batch(queue);
    }
    pthread_mutex_unlock(&queue->mutex);
    return NULL;
}

fnl_result image_queue_create(const fnl_host *host, uint32_t threads, struct image_queue **out) {
    *out = NULL;
    struct image_queue *queue = host_allocate_zero(host, sizeof *queue);
    if (!queue) return FNL_ERROR_MEMORY;
    queue->host = *host;
    fnl_host jobs_host = *host;
    if (!host->parallel_for) jobs_host.thread_count = MAX(threads, 1u);
    if (jobs_create(&jobs_host, &queue->jobs) != FNL_OK) {
        host_free(host, queue, sizeof *queue);
        return FNL_ERROR_MEMORY;
    }
    pthread_mutex_init(&queue->mutex, NULL);
    pthread_cond_init(&queue->changed, NULL);
    queue->threaded = pthread_create(&queue->thread, NULL, work, queue) == 0;
    *out = queue;
    return FNL_OK;
}

void image_queue_destroy(struct image_queue **handle) {
    struct image_queue *queue = *handle;
    if (!queue) return;
    pthread_mutex_lock(&queue->mutex);
    atomic_store(&queue->stop, true);
    pthread_cond_signal(&queue->changed);
    pthread_mutex_unlock(&queue->mutex);
    if (queue->threaded) pthread_join(queue->thread, NULL);
    jobs_destroy(&queue->jobs);
    fnl_host host = queue->host;
    for (uint32_t i = queue->first_answer; i < queue->answers.count; i++)
        if (queue->answers.data[i].result == FNL_OK) texture_free(&host, &queue->answers.data[i].texture);
    array_free(&host, &queue->asked);
    array_free(&host, &queue->answers);
    pthread_cond_destroy(&queue->changed);
    pthread_mutex_destroy(&queue->mutex);
    host_free(&host, queue, sizeof *queue);
    *handle = NULL;
}

fnl_result image_queue_ask(struct image_queue *queue, const struct image_request *request) {
    pthread_mutex_lock(&queue->mutex);
    const uint64_t ahead = queue->asked.count - queue->first_asked + queue->working;
    bool room = array_reserve(&queue->host, &queue->answers, queue->answers.count + ahead + 1) &&
                array_push(&queue->host, &queue->asked, *request);
    pthread_cond_signal(&queue->changed);
    pthread_mutex_unlock(&queue->mutex);
    return room ? FNL_OK : FNL_ERROR_MEMORY;
}

bool image_queue_take(struct image_queue *queue, struct image_answer *out) {
    pthread_mutex_lock(&queue->mutex);
    if (!queue->threaded && queue->first_answer == queue->answers.count && queue->asked.count) decode_batch(queue);
    bool found = queue->first_answer < queue->answers.count;
    if (found) {
        *out = queue->answers.data[queue->first_answer];
        queue->waiting_bytes -= bytes_of(&out->texture);
        if (++queue->first_answer == queue->answers.count) queue->first_answer = queue->answers.count = 0;
        pthread_cond_signal(&queue->changed);
    }
    pthread_mutex_unlock(&queue->mutex);
    return found;
}
