/* SPDX-License-Identifier: MIT */
/* Which views there are, what each sees, and how its pictures are called. */
#include "cave/cave.h"
#include "cave/hash.h"
#include "output.h"
#include "print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct cave_moment cave_predict(const struct cave_options *o, const struct cave_displays *d, uint64_t frame, double ev) {
    const double time = (double)frame * o->render.frame_time;
    return (struct cave_moment){.frame = frame,
                                .display_time = time,
                                .animation_time = o->render.world.time + time,
                                .head = cave_displays_head(d, time),
                                .eyes = {[CAVE_LEFT] = {-d->ipd / 2, 0, 0}, [CAVE_RIGHT] = {d->ipd / 2, 0, 0}},
                                .ev = ev};
}

_Static_assert(sizeof(struct cave_moment) == 8 * (1 + 2 + 7 + 3 * CAVE_EYES + 1), "no gaps, which would be hashed");
uint64_t cave_moment_hash(const struct cave_moment *moment) { return cave_hash(moment, sizeof *moment, CAVE_HASH_SEED); }

uint32_t cave_list_views(const struct cave_options *o, const struct cave_displays *d, uint32_t rank_count, struct cave_view out[CAVE_VIEWS]) {
    uint32_t count = 0;
    for (uint32_t w = 0; w < d->wall_count; w++) {
        const struct cave_wall *wall = &d->walls[w];
        for (int e = 0; e < (wall->stereo ? 2 : 1); e++) {
            uint32_t rank = wall->rank[e] >= 0 ? (uint32_t)wall->rank[e] : rank_count ? w % rank_count : 0;
            if (rank_count && rank >= rank_count) {
                fprintf(stderr, "fanal: error: %s: /walls/%u/rank: is %u, but there are %u ranks: mpirun -n %u\n", d->source, w, rank, rank_count, rank + 1);
                return 0;
            }
            out[count++] = (struct cave_view){.wall = w,
                                              .rank = rank_count ? rank : 0,
                                              .device = wall->device[e] >= 0 ? (uint32_t)wall->device[e] : 0,
                                              .width = o->width ? o->width : wall->width,
                                              .height = o->height ? o->height : wall->height,
                                              .eye = wall->stereo ? (enum cave_eye)(CAVE_LEFT + e) : CAVE_MONO};
        }
    }
    return count;
}

void cave_view_name(const struct cave_displays *d, const struct cave_view *view, char *out, size_t capacity) {
    const struct cave_wall *wall = &d->walls[view->wall];
    snprintf(out, capacity, wall->stereo ? "%s/%s" : "%s", wall->name, cave_eye_name(view->eye));
}

bool cave_view_camera(const struct cave_displays *d, const struct cave_place *place, const struct cave_moment *m, const struct cave_view *view, fnl_camera *out) {
    const struct cave_wall *wall = &d->walls[view->wall];
    const struct cave_vector eye = cave_add_scaled(m->head.position, cave_rotate(m->head.rotation, m->eyes[view->eye]), 1);
    const fnl_rigid_pose nothing = {{0, 0, 0}, {0, 0, 0, 1}};
    fnl_eye seen;
    double distance;
    if (cave_look_through(cave_placed(place, wall->lower_left), cave_placed(place, wall->lower_right), cave_placed(place, wall->upper_left), cave_placed(place, eye),
                          &seen, &distance))
        return fnl_eye_query_camera(NULL, &seen, &nothing, view->width, view->height, (float)(d->near_distance * place->scale), out) == FNL_OK;
    char name[2 * CAVE_NAME];
    cave_view_name(d, view, name, sizeof name);
    distance /= place->scale;
    fprintf(stderr, "fanal: error: %s: /walls/%u: '%s': the eye at %.4g, %.4g, %.4g (frame %llu, %.4g s) is ", d->source, view->wall, name, eye.x, eye.y, eye.z,
            (unsigned long long)m->frame, m->display_time);
    if (distance < -1e-9)
        fprintf(stderr, "%.4g m behind the wall", -distance);
    else if (distance <= 1e-9)
        fprintf(stderr, "on the wall's plane");
    else
        fprintf(stderr, "%.4g m in front of the wall's plane, too near for the wall to be seen", distance);
    fputs("; it must be on the side from which lower_left is on the left\n", stderr);
    return false;
}

struct cave_place cave_find_place(const struct cave_displays *d, const struct cave_moment *m, const fnl_camera *camera, bool by_camera) {
    if (d->has_origin && !by_camera) return d->origin;
    const double x = (double)camera->target.x - (double)camera->position.x, z = (double)camera->target.z - (double)camera->position.z;
    struct cave_place place = {.scale = d->origin.scale};
    place.pose.rotation = cave_turn(x != 0 || z != 0 ? atan2(-x, -z) : 0);
    const struct cave_vector at = {(double)camera->position.x, (double)camera->position.y, (double)camera->position.z};
    place.pose.position = cave_subtract(at, cave_placed(&place, m->head.position));
    return place;
}

/* ---- names of pictures ---- */

void cave_path(const char *pattern, const struct cave_displays *d, const struct cave_view *view, uint64_t frame, char *out, size_t capacity) {
    const char *percent, *field;
    size_t used = 0;
    int width;
    for (; used < capacity && (field = output_next_field(pattern, &percent, &width)); pattern = field + 1) {
        const char *eye = cave_eye_name(view->eye), *wall = d->walls[view->wall].name;
        used = output_append(out, used, capacity, pattern, (size_t)(percent - pattern));
        if (*field == 'd') used += (size_t)snprintf(out + used, capacity - used, "%0*llu", width, (unsigned long long)frame);
        else used += (size_t)snprintf(out + used, capacity - used, "%s", *field == 'w' ? wall : eye);
    }
    if (used < capacity) output_append(out, used, capacity, pattern, strlen(pattern));
}

const char *cave_pattern_problem(const char *pattern, const struct cave_displays *d, uint64_t frames) {
    int walls = 0, eyes = 0, numbers = 0, width;
    bool stereo = false;
    for (const char *rest = pattern, *percent, *field; (field = output_next_field(rest, &percent, &width)); rest = field + 1) {
        const size_t digits = (size_t)(field - percent - 1);
        walls += *field == 'w';
        eyes += *field == 'e';
        numbers += *field == 'd';
        if (!*field || !strchr("wed", *field) || digits > 2 || (digits && *field != 'd')) return "% stands before w (the wall), e (the eye) or d (the frame, also as %04d); %% is a percent sign";
    }
    for (uint32_t i = 0; i < d->wall_count; i++) stereo = stereo || d->walls[i].stereo;
    if (walls > 1 || eyes > 1 || numbers > 1) return "%w, %e and %d may be there once each";
    if (d->wall_count > 1 && !walls) return "there are several walls: the name needs %w, which becomes the wall's";
    if (stereo && !eyes) return "there are stereo walls: the name needs %e, which becomes left, right or mono";
    if (frames > 1 && !numbers) return "there are several frames: the name needs %d or %04d, which becomes the frame's number";
    return NULL;
}
