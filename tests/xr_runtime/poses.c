/* SPDX-License-Identifier: MIT */
#include "runtime.h"

#include <math.h>

static XrQuaternionf quat_mul(XrQuaternionf a, XrQuaternionf b) {
    return (XrQuaternionf){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                           a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

static XrVector3f turn(XrQuaternionf q, XrVector3f v) {
    const XrQuaternionf r = quat_mul(quat_mul(q, (XrQuaternionf){v.x, v.y, v.z, 0}), (XrQuaternionf){-q.x, -q.y, -q.z, q.w});
    return (XrVector3f){r.x, r.y, r.z};
}

static XrQuaternionf unit(XrQuaternionf q) {
    const float length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return (XrQuaternionf){q.x / length, q.y / length, q.z / length, q.w / length};
}

XrPosef pose_mul(const XrPosef *a, const XrPosef *b) {
    const XrVector3f p = turn(a->orientation, b->position);
    return (XrPosef){unit(quat_mul(a->orientation, b->orientation)), {a->position.x + p.x, a->position.y + p.y, a->position.z + p.z}};
}

XrPosef pose_inverse(const XrPosef *a) {
    const XrQuaternionf q = {-a->orientation.x, -a->orientation.y, -a->orientation.z, a->orientation.w};
    return (XrPosef){q, turn(q, (XrVector3f){-a->position.x, -a->position.y, -a->position.z})};
}

struct swing {
    double sway, turn;
};

static struct swing swing_at(double seconds, bool rate) {
    const double full = 2 * 3.14159265358979323846;
    struct swing s = {0, 0};
    if (rt.script.head.sway_seconds > 0) {
        const double w = full / rt.script.head.sway_seconds;
        s.sway = rt.script.head.sway * (rate ? w * cos(w * seconds) : sin(w * seconds));
    }
    if (rt.script.head.turn_seconds > 0) {
        const double w = full / rt.script.head.turn_seconds;
        s.turn = rt.script.head.turn * (rate ? w * cos(w * seconds) : sin(w * seconds));
    }
    return s;
}

static XrPosef head_of(struct swing s) {
    const double half = (rt.script.head.yaw * 3.14159265358979323846 / 180 + s.turn) / 2;
    return (XrPosef){{0, (float)sin(half), 0, (float)cos(half)}, {(float)(rt.script.head.x + s.sway), (float)rt.script.head.y, (float)rt.script.head.z}};
}

XrPosef true_head(int64_t time) { return head_of(swing_at((double)time * 1e-9, false)); }

XrPosef predicted_head(int64_t now, int64_t time) {
    if (time <= now) return true_head(time);
    const double at = (double)now * 1e-9, ahead = (double)(time - now) * 1e-9;
    struct swing s = swing_at(at, false);
    const struct swing rate = swing_at(at, true);
    s.sway += rate.sway * ahead;
    s.turn += rate.turn * ahead;
    return head_of(s);
}

const struct hand_row *hand_now(uint32_t hand) {
    const struct hand_row *found = NULL;
    for (uint32_t i = 0; i < rt.script.hand_count; i++) {
        const struct hand_row *row = &rt.script.hands[i];
        if (row->hand == hand && row->frame <= rt.frame) found = row;
    }
    return found;
}

const struct gaze_row *gaze_now(void) {
    const struct gaze_row *found = NULL;
    for (uint32_t i = 0; i < rt.script.gaze_count; i++)
        if (rt.script.gazes[i].frame <= rt.frame) found = &rt.script.gazes[i];
    return found;
}

XrPosef space_in_stage(const struct object *space, int64_t time) {
    XrPosef origin = {{0, 0, 0, 1}, {0, 0, 0}};
    if (space->space.reference == XR_REFERENCE_SPACE_TYPE_VIEW) origin = predicted_head(rt.now, time);
    if (space->space.reference == XR_REFERENCE_SPACE_TYPE_LOCAL) origin = rt.recenter_time >= 0 && time >= rt.recenter_time ? rt.recentered : rt.local_origin;
    if (space->space.action) {
        const struct hand_row *hand = hand_now(space->space.hand);
        const struct gaze_row *gaze = gaze_now();
        if (hand) origin = hand->pose;
        if (space->space.action->action.is_gaze && gaze) {
            origin = predicted_head(rt.now, time);
            origin = pose_mul(&origin, &gaze->pose);
        }
    }
    return pose_mul(&origin, &space->space.pose);
}

double pose_distance(const XrPosef *a, const XrPosef *b) {
    const double x = (double)a->position.x - (double)b->position.x, y = (double)a->position.y - (double)b->position.y, z = (double)a->position.z - (double)b->position.z;
    return sqrt(x * x + y * y + z * z);
}

double pose_angle(const XrPosef *a, const XrPosef *b) {
    const XrPosef inverse = pose_inverse(a), between = pose_mul(&inverse, b);
    const double x = (double)between.orientation.x, y = (double)between.orientation.y, z = (double)between.orientation.z;
    return 2 * asin(fmin(1, sqrt(x * x + y * y + z * z)));
}
