/* SPDX-License-Identifier: MIT */
/* Controllers: a ray from each hand. One button goes where the ray meets the floor, the other takes a light that the ray points at and moves it. */
#include "xr/xr.h"

#include <stdio.h>
#include <string.h>

static const char *const hand_names[XR_HANDS] = {"left", "right"};

static const float farthest_step = 20;    /* metres */
static const float widest_reach = 0.1f;   /* radians between the ray and a light that can be taken */

/* ---- bindings ---- */

static bool path_of(struct xr *x, const char *text, XrPath *out) { return xr_may(x, "xrStringToPath", xrStringToPath(x->instance, text, out), "controllers"); }

static bool make_action(struct xr *x, XrActionType type, const char *name, const char *text, XrAction *out) {
    XrPath hands[XR_HANDS] = {x->hands[0].path, x->hands[1].path};
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO, .actionType = type, .countSubactionPaths = XR_HANDS, .subactionPaths = hands};
    snprintf(info.actionName, sizeof info.actionName, "%s", name);
    snprintf(info.localizedActionName, sizeof info.localizedActionName, "%s", text);
    return xr_may(x, "xrCreateAction", xrCreateAction(x->actions, &info, out), "controllers");
}

/* A kind of controller that the runtime does not know is left out, and the others stay. */
static bool suggest(struct xr *x, const char *profile, const char *teleport, const char *grab) {
    XrActionSuggestedBinding bindings[3 * XR_HANDS];
    XrInteractionProfileSuggestedBinding info = {.type = XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, .suggestedBindings = bindings};
    const char *const inputs[3] = {"aim/pose", teleport, grab};
    const XrAction actions[3] = {x->aim_action, x->teleport_action, x->grab_action};
    char text[XR_MAX_PATH_LENGTH];
    if (!path_of(x, profile, &info.interactionProfile)) return false;
    for (uint32_t i = 0; i < 3 * XR_HANDS; i++) {
        XrActionSuggestedBinding *b = &bindings[info.countSuggestedBindings++];
        b->action = actions[i / XR_HANDS];
        snprintf(text, sizeof text, "/user/hand/%s/input/%s", hand_names[i % XR_HANDS], inputs[i / XR_HANDS]);
        if (!path_of(x, text, &b->binding)) return false;
    }
    const XrResult result = xrSuggestInteractionProfileBindings(x->instance, &info);
    if (result == XR_ERROR_PATH_UNSUPPORTED) return true;
    return xr_may(x, "xrSuggestInteractionProfileBindings", result, "controllers");
}

static bool start(struct xr *x) {
    XrActionSetCreateInfo set = {.type = XR_TYPE_ACTION_SET_CREATE_INFO};
    snprintf(set.actionSetName, sizeof set.actionSetName, "scene");
    snprintf(set.localizedActionSetName, sizeof set.localizedActionSetName, "Scene");
    if (!path_of(x, "/user/hand/left", &x->hands[0].path) || !path_of(x, "/user/hand/right", &x->hands[1].path)) return false;
    if (!xr_may(x, "xrCreateActionSet", xrCreateActionSet(x->instance, &set, &x->actions), "controllers")) return false;
    if (!make_action(x, XR_ACTION_TYPE_POSE_INPUT, "aim", "Point", &x->aim_action) ||
        !make_action(x, XR_ACTION_TYPE_BOOLEAN_INPUT, "teleport", "Go where the ray meets the floor", &x->teleport_action) ||
        !make_action(x, XR_ACTION_TYPE_BOOLEAN_INPUT, "grab", "Move a light", &x->grab_action))
        return false;
    if (!suggest(x, "/interaction_profiles/khr/simple_controller", "select/click", "menu/click") ||
        !suggest(x, "/interaction_profiles/oculus/touch_controller", "trigger/value", "squeeze/value") ||
        !suggest(x, "/interaction_profiles/valve/index_controller", "trigger/click", "squeeze/value") ||
        !suggest(x, "/interaction_profiles/htc/vive_controller", "trigger/click", "squeeze/click") ||
        !suggest(x, "/interaction_profiles/microsoft/motion_controller", "trigger/value", "squeeze/click"))
        return false;
    for (uint32_t i = 0; i < XR_HANDS; i++) {
        const XrActionSpaceCreateInfo info = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                              .action = x->aim_action,
                                              .subactionPath = x->hands[i].path,
                                              .poseInActionSpace = {{0, 0, 0, 1}, {0, 0, 0}}};
        if (!xr_may(x, "xrCreateActionSpace", xrCreateActionSpace(x->session, &info, &x->hands[i].aim), "controllers")) return false;
    }
    return true;
}

/* Of controllers and eyes, where there are some. */
static uint32_t list_sets(const struct xr *x, XrActionSet sets[2]) {
    uint32_t count = 0;
    if (x->has_input) sets[count++] = x->actions;
    if (x->has_gaze) sets[count++] = x->gaze_actions;
    return count;
}

static const char *name_sets(const struct xr *x) { return !x->has_gaze ? "controllers" : x->has_input ? "controllers and gaze" : "the gaze"; }

void xr_start_input(struct xr *x) {
    XrActionSet sets[2];
    x->has_input = !x->options->no_input && start(x);
    x->has_gaze = x->has_gaze && x->end == XR_RUNS && xr_start_gaze(x);
    const XrSessionActionSetsAttachInfo attach = {.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, .countActionSets = list_sets(x, sets), .actionSets = sets};
    if (attach.countActionSets == 0 || x->end != XR_RUNS) return;
    if (!xr_may(x, "xrAttachSessionActionSets", xrAttachSessionActionSets(x->session, &attach), name_sets(x))) x->has_input = x->has_gaze = false;
}

/* ---- what the buttons do ---- */

/* The floor is where the space of play has it: at 0 of a stage, else 1.6 m below where the user began. */
static float floor_of(const struct xr *x) {
    const float below = x->space_type == XR_REFERENCE_SPACE_TYPE_STAGE ? 0 : 1.6f * x->options->world_scale;
    return x->rig.position.y - below;
}

static bool meets_floor(const struct xr *x, const struct xr_hand *hand, float *out_distance) {
    const float slope = quat_turn(hand->pose.rotation, (fnl_vec3){0, 0, -1}).y;
    *out_distance = slope < -1e-4f ? (floor_of(x) - hand->pose.position.y) / slope : -1;
    return *out_distance > 0 && *out_distance <= farthest_step * x->options->world_scale;
}

float xr_ray_length(const struct xr *x, const struct xr_hand *hand) {
    float distance;
    const float scale = x->options->world_scale;
    return meets_floor(x, hand, &distance) ? fmaxf(distance, 0.1f * scale) : 3 * scale;
}

static void teleport(struct xr *x, const struct xr_hand *hand) {
    float distance;
    if (!meets_floor(x, hand, &distance)) return;
    const fnl_vec3 goal = add3(hand->pose.position, scale3(quat_turn(hand->pose.rotation, (fnl_vec3){0, 0, -1}), distance));
    x->rig.position.x += goal.x - x->head_in_world.x;
    x->rig.position.z += goal.z - x->head_in_world.z;
    x->head_in_world.x = goal.x;
    x->head_in_world.z = goal.z;
    x->numbers.teleports++;
}

/* The light that is nearest to the ray by its angle. */
static void grab(struct xr *x, struct xr_hand *hand) {
    const fnl_vec3 along = quat_turn(hand->pose.rotation, (fnl_vec3){0, 0, -1});
    const uint32_t count = fnl_scene_count(x->scene, FNL_ENTITY_LIGHT);
    float best = cosf(widest_reach);
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light;
        fnl_entity_info entity;
        if (fnl_scene_query_light(x->scene, i, &light) != FNL_OK || light.kind == FNL_LIGHT_DIRECTIONAL) continue;
        const fnl_vec3 to = sub3(light.position, hand->pose.position);
        const float length = sqrtf(dot3(to, to)), cosine = length > 0 ? dot3(to, along) / length : 1;
        if (cosine <= best || fnl_scene_query_entity(x->scene, FNL_ENTITY_LIGHT, i, &entity) != FNL_OK) continue;
        best = cosine;
        hand->holds = true;
        hand->light = entity.id.light;
        hand->held = light;
        hand->held_by = hand->pose;
    }
    x->numbers.grabs += hand->holds;
}

static void carry(struct xr *x, struct xr_hand *hand) {
    const fnl_vec4 turn = quat_mul(hand->pose.rotation, quat_inverse(hand->held_by.rotation));
    fnl_light_params light = hand->held;
    light.position = add3(hand->pose.position, quat_turn(turn, sub3(hand->held.position, hand->held_by.position)));
    light.direction = quat_turn(turn, hand->held.direction);
    light.up = quat_turn(turn, hand->held.up);
    hand->holds = fnl_scene_set_light(x->scene, hand->light, &light) == FNL_OK;
    x->numbers.light_moves += hand->holds;
    x->numbers.last_light = light.position;
}

static bool pressed(struct xr *x, const struct xr_hand *hand, XrAction action) {
    const XrActionStateGetInfo info = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = action, .subactionPath = hand->path};
    XrActionStateBoolean state = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    if (xr_may(x, "xrGetActionStateBoolean", xrGetActionStateBoolean(x->session, &info, &state), "controllers")) return state.isActive && state.currentState;
    x->has_input = false;
    return false;
}

static bool find_hand(struct xr *x, struct xr_hand *hand, XrTime time) {
    const XrActionStateGetInfo info = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = x->aim_action, .subactionPath = hand->path};
    XrActionStatePose state = {.type = XR_TYPE_ACTION_STATE_POSE};
    XrSpaceLocation location = {.type = XR_TYPE_SPACE_LOCATION};
    if (!xr_may(x, "xrGetActionStatePose", xrGetActionStatePose(x->session, &info, &state), "controllers") ||
        (state.isActive && !xr_may(x, "xrLocateSpace", xrLocateSpace(hand->aim, x->space, time, &location), "controllers"))) {
        x->has_input = false;
        return false;
    }
    const XrSpaceLocationFlags wanted = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    if (!state.isActive || (location.locationFlags & wanted) != wanted || !xr_is_pose(x, XR_POSE_HAND, &location.pose)) return false;
    const fnl_rigid_pose pose = xr_pose(x, &location.pose);
    hand->pose = pose_mul(&x->rig, &pose);
    return true;
}

void xr_take_input(struct xr *x, XrTime time) {
    XrActionSet sets[2];
    XrActiveActionSet active[2];
    const uint32_t count = list_sets(x, sets);
    if (count == 0 || !x->placed) return;
    for (uint32_t i = 0; i < count; i++) active[i] = (XrActiveActionSet){sets[i], XR_NULL_PATH};
    const XrActionsSyncInfo info = {.type = XR_TYPE_ACTIONS_SYNC_INFO, .countActiveActionSets = count, .activeActionSets = active};
    const XrResult result = xrSyncActions(x->session, &info);
    if (!xr_may(x, "xrSyncActions", result, name_sets(x))) {
        x->has_input = x->has_gaze = false;
        return;
    }
    for (uint32_t i = 0; i < XR_HANDS && x->has_input && x->end == XR_RUNS; i++) {
        struct xr_hand *hand = &x->hands[i];
        hand->active = result == XR_SUCCESS && find_hand(x, hand, time); /* else another program has the controllers */
        const bool goes = hand->active && pressed(x, hand, x->teleport_action), takes = hand->active && x->has_input && pressed(x, hand, x->grab_action);
        if (hand->active && hand->teleport && !goes) teleport(x, hand); /* when it is let go */
        if (takes && !hand->grab) grab(x, hand);
        if (!takes) hand->holds = false;
        if (hand->holds) carry(x, hand);
        hand->teleport = goes;
        hand->grab = takes;
    }
    if (x->has_input) xr_show_beams(x);
}
