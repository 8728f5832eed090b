/* SPDX-License-Identifier: MIT */
/* Who shares a scene on the device, and what each user's last frame drew of it. */
#include "render/device/scene.h"

fnl_result device_scene_open(gpu_device *device, fnl_scene *scene, struct device_scene_user *out) {
    void **first = gpu_shared(device);
    struct device_scene *d = *first;
    *out = (struct device_scene_user){0};
    while (d && d->scene != scene) d = d->next;
    if (!d) {
        d = host_allocate(gpu_host(device), sizeof *d);
        if (!d) return FNL_ERROR_MEMORY;
        device_scene_init(d, device, scene);
        d->next = *first;
        *first = d;
    }
    *out = (struct device_scene_user){.scene = d, .next = d->users};
    d->users = out;
    return FNL_OK;
}

static void destroy(struct device_scene *d) {
    void **first = gpu_shared(d->device);
    struct device_scene *before = *first;
    if (before == d) {
        *first = d->next;
    } else {
        while (before->next != d) before = before->next;
        before->next = d->next;
    }
    const fnl_host host = d->host;
    device_scene_finish(d);
    host_free(&host, d, sizeof *d);
}

void device_scene_close(struct device_scene_user *user) {
    struct device_scene *d = user->scene;
    if (!d) return;
    gpu_buffer_destroy(d->device, &user->previous);
    gpu_buffer_destroy(d->device, &user->faded_lights);
    gpu_buffer_destroy(d->device, &user->faded_bounds);
    struct device_scene_user **link = &d->users;
    while (*link != user) link = &(*link)->next;
    *link = user->next;
    *user = (struct device_scene_user){0};
    if (!d->users) destroy(d);
}

/* ---- outside of frames ---- */

fnl_result device_users_prepare(struct device_scene *d) {
    const uint64_t size = d->instances.size + MAX(d->deformed_vertex_count, 1u) * 12ull;
    for (struct device_scene_user *user = d->users; user; user = user->next) {
        if (!user->wants_previous && !user->keeps_previous) continue;
        if (user->last == DEVICE_LAST_KEPT || user->previous.size >= size) continue;
        gpu_buffer_destroy(d->device, &user->previous);
        TRY(gpu_buffer_create_for(d->device, GPU_USE_GEOMETRY, "previous vertices", size, GPU_MEMORY_DEVICE, &user->previous));
    }
    return FNL_OK;
}

void device_users_lose(struct device_scene *d) {
    for (struct device_scene_user *user = d->users; user; user = user->next) user->last = DEVICE_LAST_UNKNOWN;
}

void device_users_trim(struct device_scene *d) {
    enum { MOST = 4096 }; /* a user that has missed more begins anew */
    uint64_t end = d->arrived_before + d->arrived.count, least = end;
    for (struct device_scene_user *user = d->users; user; user = user->next) {
        if (user->last != DEVICE_LAST_UNKNOWN && end - user->arrived > MOST) user->last = DEVICE_LAST_UNKNOWN;
        if (user->last != DEVICE_LAST_UNKNOWN) least = MIN(least, user->arrived);
    }
    const uint32_t drawn = (uint32_t)(least - d->arrived_before);
    d->arrived.count -= drawn;
    if (drawn && d->arrived.count)
        memmove(d->arrived.data, d->arrived.data + drawn, d->arrived.count * sizeof *d->arrived.data);
    d->arrived_before = least;
}

/* ---- inside a frame ---- */

struct keep_data {
    const struct device_scene *d;
    const struct gpu_buffer *to;
    struct device_previous layout;
};

static void execute_keep(const struct graph_context *context, const void *data) {
    const struct keep_data *k = data;
    const uint64_t offset = device_previous_offset(&k->layout);
    gpu_copy_buffer(context->commands, &k->d->instances, 0, k->to, 0, offset);
    if (k->layout.deformed_count)
        gpu_copy_buffer(context->commands, &k->d->positions, k->layout.first_deformed * 12ull, k->to, offset,
                        k->layout.deformed_count * 12ull);
}

static graph_buffer import_previous(const struct device_scene_user *user, struct graph *graph, uint32_t number) {
    return graph_import_buffer(graph, graph_numbered_name(graph, "previous vertices", number), &user->previous);
}

/* Copies what the user's last frame drew. */
static void keep(struct device_scene_user *user, struct graph *graph, graph_buffer vertices, uint32_t number) {
    const struct device_scene *d = user->scene;
    user->kept = (struct device_previous){.instance_count = (uint32_t)(d->instances.size / sizeof(struct gpu_instance)),
                                          .first_deformed = d->first_deformed,
                                          .deformed_count = d->deformed_vertex_count};
    const struct keep_data data = {d, &user->previous, user->kept};
    struct graph_pass *pass = graph_add_pass(graph, graph_numbered_name(graph, "keep previous", number), GRAPH_QUEUE_GRAPHICS,
                                             execute_keep, &data, sizeof data);
    graph_use_buffer(pass, vertices, GRAPH_COPY_FROM);
    graph_use_buffer(pass, import_previous(user, graph, number), GRAPH_COPY_TO);
}

struct arrived_data {
    const struct gpu_buffer *previous;
    const struct range *places; /* ascending, apart from each other */
    uint32_t count;
};

static void execute_arrived(const struct graph_context *context, const void *data) {
    const struct arrived_data *a = data;
    const uint64_t size = sizeof(struct gpu_instance);
    for (uint32_t i = 0; i < a->count; i++)
        gpu_fill_buffer(context->commands, a->previous, a->places[i].first * size, a->places[i].count * size, 0);
}

static int compare_places(const void *a, const void *b) {
    const struct range *x = a, *y = b;
    return x->first < y->first ? -1 : x->first > y->first;
}

/* Places below `end` where an instance has arrived that the user has not drawn: in some, several one after the other. */
static uint32_t list_arrived(const struct device_scene_user *user, uint32_t end, struct range *out) {
    const struct device_scene *d = user->scene;
    const uint32_t first = (uint32_t)(user->arrived - d->arrived_before);
    uint32_t count = 0, kept = 0;
    for (uint32_t i = first; i < d->arrived.count; i++) {
        struct range place = d->arrived.data[i];
        if (place.first >= end) continue;
        place.count = MIN(place.count, end - place.first);
        out[count++] = place;
    }
    if (count) qsort(out, count, sizeof *out, compare_places);
    for (uint32_t i = 0; i < count; i++) {
        struct range *last = kept ? &out[kept - 1] : NULL;
        if (last && out[i].first <= last->first + last->count)
            last->count = MAX(last->count, out[i].first + out[i].count - last->first);
        else
            out[kept++] = out[i];
    }
    return kept;
}

/* For the user whose frame it is: what its last frame drew, with marks on what that did not draw. */
static fnl_result add_own(struct device_scene_user *user, struct graph *graph, graph_buffer vertices,
                          struct device_scene_frame *out) {
    const struct device_scene *d = user->scene;
    const uint64_t arrived = d->arrived_before + d->arrived.count - user->arrived;
    if (!user->wants_previous || out->lost || (!out->moved && arrived == 0)) return FNL_OK;
    if (user->last == DEVICE_LAST_THERE) keep(user, graph, vertices, 0);
    out->previous = import_previous(user, graph, 0);
    out->previous_layout = user->kept;
    if (arrived == 0) return FNL_OK;
    struct gpu_slice places = gpu_frame_allocate(d->device, arrived * sizeof(struct range));
    if (!places.data) return gpu_status(d->device);
    const struct arrived_data data = {&user->previous, places.data,
                                      list_arrived(user, user->kept.instance_count, places.data)};
    struct graph_pass *pass =
        graph_add_pass(graph, "mark new instances", GRAPH_QUEUE_GRAPHICS, execute_arrived, &data, sizeof data);
    graph_use_buffer(pass, out->previous, GRAPH_COPY_TO);
    return FNL_OK;
}

fnl_result device_users_add(struct device_scene_user *user, struct graph *graph, graph_buffer vertices,
                      struct device_scene_frame *out) {
    struct device_scene *d = user->scene;
    out->moved = user->last == DEVICE_LAST_UNKNOWN || user->transform_version != d->scene->transform_version;
    out->lost = user->wants_previous && user->last == DEVICE_LAST_UNKNOWN;
    out->previous = (graph_buffer){0};
    out->previous_layout = (struct device_previous){0};
    TRY(add_own(user, graph, vertices, out));
    uint32_t number = 0;
    for (struct device_scene_user *other = d->users; other; other = other->next) {
        other->keeping =
            other != user && d->overwrites && other->keeps_previous && other->last == DEVICE_LAST_THERE;
        if (other->keeping) keep(other, graph, vertices, ++number);
    }
    return FNL_OK;
}

void device_scene_submitted(struct device_scene_user *user) {
    struct device_scene *d = user->scene;
    d->declared = false;
    device_structures_submitted(d);
    for (struct device_scene_user *other = d->users; other; other = other->next)
        if (other->last == DEVICE_LAST_THERE && d->overwrites)
            other->last = other->keeping ? DEVICE_LAST_KEPT : DEVICE_LAST_UNKNOWN;
    user->last = DEVICE_LAST_THERE;
    user->keeps_previous = user->wants_previous;
    user->transform_version = d->scene->transform_version;
    user->arrived = d->arrived_before + d->arrived.count;
}
