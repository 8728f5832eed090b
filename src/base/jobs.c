/* SPDX-License-Identifier: MIT */
#include "base/jobs.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { MAX_THREADS = 256 };

struct jobs {
    fnl_host host;
    pthread_mutex_t mutex;
    pthread_cond_t work_given, work_done;
    pthread_t threads[MAX_THREADS];
    uint32_t worker_count; /* threads of the pool, the caller not counted */

    /* The loop in progress; guarded by mutex except `next`. */
    void (*run)(void *context, uint32_t index);
    void *context;
    uint32_t count, generation, busy;
    bool stop;
    atomic_uint next;
};

static void take_indices(struct jobs *jobs, void (*run)(void *, uint32_t), void *context, uint32_t count) {
    for (uint32_t index; (index = atomic_fetch_add(&jobs->next, 1)) < count;) run(context, index);
}

static void *worker(void *argument) {
    struct jobs *jobs = argument;
    uint32_t seen = 0;
    pthread_mutex_lock(&jobs->mutex);
    for (;;) {
        while (!jobs->stop && jobs->generation == seen) pthread_cond_wait(&jobs->work_given, &jobs->mutex);
        if (jobs->stop) break;
        seen = jobs->generation;
        void (*run)(void *, uint32_t) = jobs->run;
        void *context = jobs->context;
        uint32_t count = jobs->count;
        pthread_mutex_unlock(&jobs->mutex);
        take_indices(jobs, run, context, count);
        pthread_mutex_lock(&jobs->mutex);
        if (--jobs->busy == 0) pthread_cond_signal(&jobs->work_done);
    }
    pthread_mutex_unlock(&jobs->mutex);
    return NULL;
}

fnl_result jobs_create(const fnl_host *host, struct jobs **out) {
    *out = NULL;
    struct jobs *jobs = host_allocate_zero(host, sizeof *jobs);
    if (!jobs) return FNL_ERROR_MEMORY;
    jobs->host = *host;
    uint32_t wanted = host->thread_count;
    if (wanted == 0) {
        long processors = sysconf(_SC_NPROCESSORS_ONLN);
        wanted = processors > 0 ? (uint32_t)processors : 1;
    }
    wanted = MIN(wanted, (uint32_t)MAX_THREADS);
    pthread_mutex_init(&jobs->mutex, NULL);
    pthread_cond_init(&jobs->work_given, NULL);
    pthread_cond_init(&jobs->work_done, NULL);
    if (!host->parallel_for) {
        /* Fewer threads than asked for still give the right result. */
        while (jobs->worker_count + 1 < wanted &&
               pthread_create(&jobs->threads[jobs->worker_count], NULL, worker, jobs) == 0)
            jobs->worker_count++;
    }
    *out = jobs;
    return FNL_OK;
}

void jobs_destroy(struct jobs **handle) {
    struct jobs *jobs = *handle;
    if (!jobs) return;
    pthread_mutex_lock(&jobs->mutex);
    jobs->stop = true;
    pthread_cond_broadcast(&jobs->work_given);
    pthread_mutex_unlock(&jobs->mutex);
    for (uint32_t i = 0; i < jobs->worker_count; i++) pthread_join(jobs->threads[i], NULL);
    pthread_cond_destroy(&jobs->work_done);
    pthread_cond_destroy(&jobs->work_given);
    pthread_mutex_destroy(&jobs->mutex);
    fnl_host host = jobs->host;
    host_free(&host, jobs, sizeof *jobs);
    *handle = NULL;
}

uint32_t jobs_thread_count(const struct jobs *jobs) {
    return jobs->host.parallel_for ? MAX(jobs->host.thread_count, 1u) : jobs->worker_count + 1;
}

void jobs_parallel_for(struct jobs *jobs, uint32_t count, void (*run)(void *context, uint32_t index), void *context) {
    if (jobs->host.parallel_for) {
        jobs->host.parallel_for(jobs->host.user, count, run, context);
        return;
    }
    if (jobs->worker_count == 0 || count < 2) {
        for (uint32_t i = 0; i < count; i++) run(context, i);
        return;
    }
    pthread_mutex_lock(&jobs->mutex);
    jobs->run = run;
    jobs->context = context;
    jobs->count = count;
    jobs->busy = jobs->worker_count;
    jobs->generation++;
    atomic_store(&jobs->next, 0);
    pthread_cond_broadcast(&jobs->work_given);
    pthread_mutex_unlock(&jobs->mutex);
    take_indices(jobs, run, context, count);
    pthread_mutex_lock(&jobs->mutex);
    while (jobs->busy) pthread_cond_wait(&jobs->work_done, &jobs->mutex);
    pthread_mutex_unlock(&jobs->mutex);
}
