/* SPDX-License-Identifier: MIT */
/** A device with validation, a graph and a buffer to read: what tests of graphs on a device share. */
#ifndef FNL_TESTS_GRAPH_WORLD_H
#define FNL_TESTS_GRAPH_WORLD_H

#include "graph/graph.h"

#include <setjmp.h>

#include <cmocka.h>

struct graph_world {
    gpu_device *device;
    struct graph *graph; /* of the device's host */
    struct gpu_buffer readback;
};

/** Without a cache folder. Fails the test if there is no device. */
static inline void graph_world_open(struct graph_world *out, const fnl_host *host, uint64_t readback_bytes) {
    fnl_device_params params = fnl_device_params_default();
    params.host = *host;
    params.validate = true;
    params.cache_folder = "";
    assert_int_equal(fnl_device_create(&params, &out->device), FNL_OK);
    assert_int_equal(graph_create(NULL, out->device, &out->graph), FNL_OK);
    assert_int_equal(gpu_buffer_create(out->device, "readback", readback_bytes, GPU_MEMORY_READBACK, &out->readback), FNL_OK);
}

/** Also checks that validation was silent. */
static inline void graph_world_close(struct graph_world *world) {
    assert_int_equal(gpu_wait_idle(world->device), FNL_OK);
    graph_destroy(&world->graph);
    gpu_buffer_destroy(world->device, &world->readback);
    uint64_t messages = fnl_device_validation_count(world->device);
    fnl_device_destroy(&world->device);
    assert_int_equal(messages, 0);
}

/** Compiles and executes the declared frame, and waits for it; the buffer holds zeros before. `params` may be NULL. */
static inline void graph_world_run(struct graph_world *world, const struct graph_execute_params *params) {
    assert_int_equal(graph_compile(world->graph), FNL_OK);
    assert_int_equal(gpu_frame_begin(world->device), FNL_OK);
    memset(world->readback.mapped, 0, world->readback.size);
    assert_int_equal(graph_execute_frame(world->graph, params), FNL_OK);
    assert_int_equal(gpu_wait_idle(world->device), FNL_OK);
}

#endif
